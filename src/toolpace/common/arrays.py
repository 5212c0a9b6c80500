"""Array types, and the check that arrays of a caller go through.

Numbers are in SI units. Kernels read the memory that they are given, whatever is in it: every public function that
takes an array takes it through the gate, which tells what is wrong in the words of its caller.
"""

from __future__ import annotations

import functools
import reprlib
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.common.errors import UsageError, printable
from toolpace.kernels.arrays import Bools, Floats, Ints

__all__ = ["Bools", "Floats", "Ints", "frozen", "gate_methods", "integers", "marks", "number", "numbers"]

Shape = tuple[int | str, ...]
"""Lengths of an array; a name stands for any length."""
SHOWN = 40
"""Most characters of a value that a message shows."""
KEPT = 2.0**53
"""Largest whole number up to which a float holds every one."""


def frozen(values: Floats) -> Floats:
    """The values in C order as they may not be written to; a kernel is compiled anew for arrays of another kind."""
    view = np.ascontiguousarray(values, dtype=float).view()
    view.flags.writeable = False
    return view


def numbers(value: object, name: str, *shapes: Shape, finite: bool = True, unit: str = "", cure: str = "") -> Floats:
    """Real numbers of one of some shapes, in C order, as doubles.

    `name` begins the message, as "machine xyzac-trunnion: q"; `unit` says in it what the numbers are in, `cure` what
    else would help. The array itself is returned where it is as wanted, writable or not, else a copy. Raises UsageError
    for another shape, for what are no real numbers, for masked values, and, with `finite`, for nan and infinity.
    """
    # what is as wanted costs as little as can be: kernels are asked in short calls too
    if (
        type(value) is np.ndarray
        and value.dtype == np.float64
        and value.flags.c_contiguous
        and value.flags.aligned
        and _fits(value.shape, shapes)
        and (not finite or np.isfinite(value).all())
    ):
        return value
    wanted = _wanted("real numbers", shapes, unit) + (f"; {cure}" if cure else "")
    array = _array(value, name, wanted, "iuf")
    _check_shape(array, name, shapes, wanted)
    found: Floats
    if array.dtype == np.float64:
        plain = array.flags.c_contiguous and array.flags.aligned
        found = array if plain else array.astype(np.float64, order="C")  # type: ignore[assignment]
    else:
        with np.errstate(over="ignore"):
            found = array.astype(np.float64, order="C")
    if finite and not np.isfinite(found).all():
        at = tuple(int(k) for k in np.argwhere(~np.isfinite(found))[0])
        place = f"[{', '.join(map(str, at))}]" if at else ""
        raise UsageError(f"{name}{place} is {found[at]:g}; give finite numbers{f' [{unit}]' if unit else ''}")
    return found


def number(
    value: object, name: str, *, least: float = -np.inf, above: bool = False, endless: bool = False, unit: str = ""
) -> float:
    """One real number, at least `least` or, with `above`, above it; infinity only where `endless`.

    Raises UsageError.
    """
    bound = f", {'above' if above else 'of at least'} {least:g}" if least > -np.inf else ""
    wanted = f"give a number{bound}{f' [{unit}]' if unit else ''}{', or inf' if endless else ''}"
    array = _array(value, name, wanted, "iuf")
    _check_shape(array, name, ((),), wanted)
    found = float(array)
    if not (found > least if above else found >= least) or (np.isinf(found) and not endless):
        raise UsageError(f"{name} is {found:g}; {wanted}")
    return found


def integers(value: object, name: str, *shapes: Shape) -> Ints:
    """Whole numbers of one of some shapes, in C order; floats that are whole are taken. Raises UsageError."""
    wanted = _wanted("whole numbers", shapes, "")
    array = _array(value, name, wanted, "iuf")
    _check_shape(array, name, shapes, wanted)
    if array.dtype.kind == "f" and not ((array == np.rint(array)) & (np.abs(array) <= KEPT)).all():
        raise UsageError(f"{name} holds numbers that are not whole; {wanted}")
    found: Ints = np.require(array, np.int64, ["C", "A"])
    return found


def marks(value: object, name: str, *shapes: Shape) -> Bools:
    """True and false of one of some shapes, in C order. Raises UsageError."""
    wanted = _wanted("true and false", shapes, "")
    array = _array(value, name, wanted, "b", empty_too=True)
    _check_shape(array, name, shapes, wanted)
    found: Bools = np.require(array, np.bool_, ["C", "A"])
    return found


def gate_methods(cls: type, names: tuple[str, ...], argument: str) -> None:
    """Have those of a class's own methods that take one array (n,) of places or times take it through the gate.

    For base classes of what planners and people alike ask: `__init_subclass__` calls it for each that is derived.
    """
    for name in names:
        method = vars(cls).get(name)
        if method is not None and not getattr(method, "__isabstractmethod__", False):
            setattr(cls, name, _gated(method, f"{cls.__name__}.{name}: {argument}"))


def _gated(method: Callable[..., Any], name: str) -> Callable[..., Any]:
    @functools.wraps(method)
    def through_gate(self: object, places: object) -> Any:
        return method(self, numbers(places, name, ("n",)))

    return through_gate


def _array(value: object, name: str, wanted: str, kinds: str, empty_too: bool = False) -> npt.NDArray[np.generic]:
    """What is given as an array of one of these kinds of elements (numpy's letters)."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.getmaskarray(value).any():
        raise UsageError(f"{name} has masked values; {wanted}, and fill or leave out what is masked")
    try:
        found = np.asarray(value)
    except (ValueError, TypeError, OverflowError):
        what = "is a list of lists of different lengths" if isinstance(value, list | tuple) else "makes no array"
        raise UsageError(f"{name} {what}; {wanted}") from None
    if found.dtype.kind not in kinds and not (empty_too and found.size == 0):
        what = _shown(value) if found.ndim == 0 else f"an array {_lengths(found.shape)} of {found.dtype}"
        raise UsageError(f"{name} is {what}; {wanted}")
    return found


def _fits(lengths: tuple[int, ...], shapes: tuple[Shape, ...]) -> bool:
    for shape in shapes:
        if len(shape) == len(lengths):
            for wanted, length in zip(shape, lengths):
                if wanted != length and type(wanted) is not str:
                    break
            else:
                return True
    return False


def _check_shape(found: npt.NDArray[np.generic], name: str, shapes: tuple[Shape, ...], wanted: str) -> None:
    if _fits(found.shape, shapes):
        return
    what = f"has shape {_lengths(found.shape)}" if found.ndim else "is one number"
    raise UsageError(f"{name} {what}; {wanted}")


def _wanted(kind: str, shapes: tuple[Shape, ...], unit: str) -> str:
    text = " or ".join("one" if not shape else _lengths(shape) for shape in shapes)
    return f"give {kind} {text}{f' [{unit}]' if unit else ''}"


def _lengths(shape: Shape) -> str:
    return f"({shape[0]},)" if len(shape) == 1 else f"({', '.join(map(str, shape))})"


def _shown(value: object) -> str:
    if value is None:
        return "None"
    text = printable(" ".join(reprlib.repr(value).split()))
    short = text if len(text) <= SHOWN else f"{text[:SHOWN]}..."
    return f"{type(value).__name__} {short}"
