"""Two folders change places at once, where the system can do that."""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from pathlib import Path

_HERE = -100
"""AT_FDCWD: relative paths start at the working directory."""
_EXCHANGE = 2
"""RENAME_EXCHANGE."""
_CANNOT = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)
"""What the kernel says where it, or the file system, has no exchange."""


def exchange(one: Path, other: Path) -> bool:
    """Let two existing paths of one disk change places in one step; False, and nothing done, where that cannot be.

    renameat2 of Linux (3.15, glibc 2.28). At every moment both names are there, each with one of the two.
    Raises OSError.
    """
    if sys.platform != "linux":
        return False
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename is None:
        return False
    rename.argtypes = (ctypes.c_int, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_uint)
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE) == 0:
        return True
    code = ctypes.get_errno()
    if code in _CANNOT:
        return False
    raise OSError(code, os.strerror(code), str(other))
