"""What words make the control do."""
