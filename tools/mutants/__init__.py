"""Mutation testing: small changes of the code, each tried on the tests that run its line.

    python -m tools.mutants map                       which tests run which lines, and how long they take
    python -m tools.mutants try --count 300           random changes of the rooms that keep promises, from that map
    python -m tools.mutants try FILE... --count 30    of these files
    python -m tools.mutants table                     the results as a page

Results are kept in out/mutants, so that a run that was stopped goes on.
"""
