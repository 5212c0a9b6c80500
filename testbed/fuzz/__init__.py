"""Coverage-guided fuzzing of everything that reads what people give: programs, tables, set-up sheets, controllers.

    python -m testbed.fuzz sinumerik --seconds 600 --seed 1

A fuzzer of our own, since it needs no more than the standard library and knows the words of each controller.
Coverage is counted by statements that are put into the modules of `toolpace.programs.reading` when they are imported,
one for each branch: a tenth of the time goes there, where `sys.settrace` makes reading ten times slower, and Python
3.11 has no `sys.monitoring`.
"""
