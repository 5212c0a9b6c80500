"""Pictures and short animations of a planned motion, drawn without a browser."""
