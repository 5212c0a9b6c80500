"""How fast and how good the planner is, beside its peers, on paths from papers and on random ones.

    python -m benchmarks            all of it (about a quarter of an hour), results written to benchmarks/results/
    python -m benchmarks --quick    a few cases, no conic programs at large n; nothing written

Beside it, one file of results each, as the modules say: bound, bound_checks, deflections, robustness, rounding,
scaling, second_order, splines.
"""

import os

# one thread for everybody, whatever a library would take
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
