"""One program in every dialect: what it means by a model of its own, how each writes it, what readers make of it.

Nothing here knows `toolpace.programs.reading` but the last step, which reads what was written and compares.
"""
