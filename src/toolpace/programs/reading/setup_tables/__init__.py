"""The tables of a set-up sheet: figures in its units, tools, and the solids of the workpiece."""
