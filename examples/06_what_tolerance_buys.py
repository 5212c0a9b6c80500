"""
What tolerance buys
===================

How much time a few micrometres of freedom save, where feeds do not decide.
"""

from __future__ import annotations

import matplotlib.pyplot as plt

import toolpace as tp
from toolpace.cli import demo_programs

TOLERANCES = (2e-6, 5e-6, 10e-6, 20e-6, 50e-6)
"""[m]"""

# %%
# Seven blades of 30 blocks each, as fast as the machine can. Tip and axis tolerance are in proportion.

machine = tp.Machine.load("xyzac-trunnion")
toolpath = tp.read_text(demo_programs.impeller_program(machine, 30), machine, feed="none")
durations = []
for tolerance in TOLERANCES:
    path = tp.Path.fit(toolpath, tip_tolerance=tolerance, axis_tolerance=100.0 * tolerance, machine=machine)
    trajectory = tp.plan(path, machine, bound=False)
    durations.append(trajectory.duration)
    print(f"{tolerance * 1e6:5.0f} µm  {trajectory.duration:8.3f} s")

# %%

figure, panel = plt.subplots(figsize=(8, 4.5), layout="constrained")
panel.semilogx([1e6 * tolerance for tolerance in TOLERANCES], durations, "o-")
panel.set(xlabel="tip tolerance [µm]", ylabel="duration [s]")
panel.set_xticks([1e6 * tolerance for tolerance in TOLERANCES], [f"{1e6 * t:.0f}" for t in TOLERANCES])
panel.minorticks_off()
panel.grid(alpha=0.3)
plt.show()
