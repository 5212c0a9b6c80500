"""Minimum-time motion along five-axis tool paths, within every axis's velocity, acceleration and jerk limits.

    import toolpace as tp

    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read("part.ngc", machine)
    path = tp.Path.fit(toolpath, machine=machine)
    trajectory = tp.plan(path, machine)
    tp.verify(trajectory, machine, toolpath).raise_if_failed()
    tp.report(trajectory, "part.html")

Names are imported when they are first used: `import toolpace` alone loads no numerical library.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from toolpace import deflect
    from toolpace.axispath import AxisPath
    from toolpace.errors import ToolpaceError
    from toolpace.limits import Limits
    from toolpace.machine import Machine
    from toolpace.path import Path
    from toolpace.plan import plan
    from toolpace.plan.endstate import EndState
    from toolpace.plan.prove import prove
    from toolpace.read import apply_feed, read, read_text
    from toolpace.report import report
    from toolpace.setpoints import SetPoints
    from toolpace.toolpath import ToolPath
    from toolpace.trajectory import Trajectory
    from toolpace.verify import Verification, verify

__all__ = [
    "AxisPath",
    "EndState",
    "Limits",
    "Machine",
    "Path",
    "SetPoints",
    "ToolPath",
    "ToolpaceError",
    "Trajectory",
    "Verification",
    "__version__",
    "apply_feed",
    "deflect",
    "plan",
    "prove",
    "read",
    "read_text",
    "report",
    "verify",
]

_HOME = {
    "AxisPath": "axispath",
    "EndState": "plan.endstate",
    "Limits": "limits",
    "Machine": "machine",
    "Path": "path",
    "SetPoints": "setpoints",
    "ToolPath": "toolpath",
    "ToolpaceError": "errors",
    "Trajectory": "trajectory",
    "Verification": "verify",
    "apply_feed": "read",
    "plan": "plan",
    "prove": "plan.prove",
    "read": "read",
    "read_text": "read",
    "report": "report",
    "verify": "verify",
}
"""Public name to the module that defines it."""
_MODULES = ("deflect",)
"""Public modules that are reached as attributes."""


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"toolpace.{name}")
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'toolpace' has no attribute '{name}'; it has {', '.join(__all__)}")
    value = getattr(importlib.import_module(f"toolpace.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


class _Package(ModuleType):
    """The package itself; its functions `plan`, `read`, `report` and `verify` win over the folders of the same name.

    Python binds a submodule to its parent after importing it, and so would put the module `toolpace.plan` in the
    place of the function. `from toolpace.plan import ...` is not touched by this.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (isinstance(value, ModuleType) and name in _HOME):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
