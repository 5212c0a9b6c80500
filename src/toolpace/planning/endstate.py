"""States of a run at its ends: at rest, or in motion."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

import numpy as np

from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.machine.limits import KINDS, Limits
from toolpace.motion import limit_ratios
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import PROMISED


@dataclass(frozen=True)
class EndState:
    """State of s at an end of a run: ds/dt and d2s/dt2; both zero at rest."""

    speed: float = 0.0
    acceleration: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("speed", self.speed), ("acceleration", self.acceleration)):
            if not isinstance(value, Real):
                raise UsageError(f"end state: {name} is {value!r}; give ds/dt and d2s/dt2 as numbers")

    @property
    def at_rest(self) -> bool:
        """Whether the run starts or ends without motion."""
        return self.speed == 0.0


AT_REST = EndState()


def check_state(run: AxisRun, limits: Limits, state: EndState, s: float, orders: int = 2) -> None:
    """Raise InfeasibleError where the state itself breaks a limit, whatever comes next.

    `orders` is 2 where its acceleration is held too, 1 where only its speed is.
    """
    if state.at_rest:
        return
    if not (np.isfinite(state.speed) and np.isfinite(state.acceleration) and state.speed > 0.0):
        raise InfeasibleError(
            f"end state: ds/dt = {state.speed:g} and d2s/dt2 = {state.acceleration:g}; ds/dt must be positive"
        )
    side = np.array([1.0 if s == run.s0 else 0.0])
    moment = np.array([[s], [state.speed], [state.acceleration], [0.0]])
    m = len(limits)
    ratios = limit_ratios(run, limits, moment, side)[0, : 1 + orders * m]
    if ratios.max() > PROMISED:
        names = ["the feed cap"] + [f"the {kind} limit of {joint}" for kind in KINDS[:2] for joint in limits.joints]
        raise InfeasibleError(
            f"end state at {run.place(s)}: takes {ratios.max():.4g} of {names[int(ratios.argmax())]};"
            " start or end slower"
        )
