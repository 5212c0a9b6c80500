"""The workpiece as pages and pictures show it: the stock while it is cut, what is around it, and loads over time."""
