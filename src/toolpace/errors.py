"""The errors and warnings that a caller can meet, by their public names."""

from toolpace.common.errors import (
    ClusterError,
    InfeasibleError,
    MachineError,
    PathError,
    ProgramError,
    ReachError,
    ToolpaceError,
    UnitWarning,
    UsageError,
    VerificationError,
)

__all__ = [
    "ClusterError",
    "InfeasibleError",
    "MachineError",
    "PathError",
    "ProgramError",
    "ReachError",
    "ToolpaceError",
    "UnitWarning",
    "UsageError",
    "VerificationError",
]
