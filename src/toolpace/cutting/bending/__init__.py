"""The bending of a tool under cutting force, and programs compensated for it."""
