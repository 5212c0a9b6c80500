"""Closed triangle meshes from files (STL, 3MF, OBJ): read, joined at their vertices, checked, and turned outward.

STL is read here. 3MF and OBJ are read by trimesh (extra `mesh`).
"""

from __future__ import annotations

import hashlib
import io
import re
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, in_short, printable
from toolpace.common.files.atomic import reason
from toolpace.common.units import LENGTHS, MILLIMETRE
from toolpace.cutting.stock.mesh_topology import joined_vertices, outward
from toolpace.programs.stock_figures import MESH_SUFFIXES

MOST_TRIANGLES = 12_000_000
"""More are refused: their surface is finer than any stock that is cut."""
MOST_BYTES = 1_000_000_000
"""Of a file, and of what it holds compressed."""
KEPT = 1_000_000_000
"""Bytes of meshes that are kept: one command needs its stock before the plan, for the cut and for the page."""
MESH_UNITS = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "meter": 1.0, "inch": 0.0254, "foot": 0.3048}
"""Units that a 3MF file may tell (3MF Core Specification 1.3, 3.4); trimesh puts an s behind."""
_HEADER, _FACET = 84, 50
"""Bytes of the head of a binary STL file, and of a triangle."""
_PIECE = 10_000_000
"""Bytes of an ASCII STL file that are read at once."""
_VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)
Corners = npt.NDArray[np.floating[Any]]
_NONE: npt.NDArray[np.float64] = np.zeros((0, 3, 3))


_latest: dict[tuple[str, str, bytes], Mesh] = {}
"""By path, unit and checksum of the contents."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed surface whose triangles are turned outward."""

    triangles: Floats
    """(n, 3, 3) corners, counterclockwise seen from outside [m]."""
    unit_assumed: bool
    """Whether neither file nor sheet tells the unit: it is taken to be mm."""
    notes: tuple[str, ...]
    """What was repaired, a sentence each."""


def load_mesh(path: Path, unit: str = "") -> Mesh:
    """The mesh in a file; `unit` is that of its coordinates ("mm"), as the file tells where it is empty, else mm.

    Raises UsageError, in one line with the cure, where the file holds no closed surface.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise UsageError(f"mesh {path}: '{suffix[:20]}' is not read; save it as STL, 3MF or OBJ")
    data = _data(path)
    key = (str(path), unit, hashlib.blake2b(data).digest())
    mesh = _latest.get(key)
    if mesh is None:
        corners, scale = _stl(data, path) if suffix == ".stl" else _by_trimesh(data, suffix, path)
        # as large as all that follows
        del data
        mesh = _checked(corners, LENGTHS[unit] if unit else scale, path)
        _keep(key, mesh)
    return mesh


def _checked(corners: Corners, scale: float | None, path: Path) -> Mesh:
    """The mesh of corners (n, 3, 3) in a unit of so many metres; None: mm is taken."""
    if len(corners) == 0:
        _fail(path, "has no triangles; export the body again")
    if len(corners) > MOST_TRIANGLES:
        _too_many(path, len(corners))
    if not np.isfinite(corners).all() or max(corners.max(), -corners.min()) > 1e9:
        _fail(path, "has a corner that is no place (not finite); export it again")
    triangles, notes = closed_surface(corners, str(path), scale or MILLIMETRE)
    triangles.setflags(write=False)
    return Mesh(triangles, scale is None, notes)


def _keep(key: tuple[str, str, bytes], mesh: Mesh) -> None:
    """Have a mesh at hand for the next time that its file is read, in place of older ones."""
    while _latest and sum(each.triangles.nbytes for each in _latest.values()) + mesh.triangles.nbytes > KEPT:
        _latest.pop(next(iter(_latest)), None)
    _latest[key] = mesh


def closed_surface(corners: Corners, name: str = "mesh", scale: float = 1.0) -> tuple[Floats, tuple[str, ...]]:
    """Triangles (n, 3, 3) [m] of a closed surface, turned outward, and what was repaired, a sentence each.

    corners: (n, 3, 3), in any order of the corners; times `scale` they are in m. `name` is for messages. Raises
    UsageError where the surface is open, has no volume, or passes through itself inside out.
    """
    notes = []
    points, faces, gap, edges = joined_vertices(corners, scale)
    if gap > 0.0:
        notes.append(f"{name}: corners up to {gap * 1e3:.2g} mm apart are taken for one")
    if len(faces) == 0:
        _fail(name, "has no triangles but such without area; export the body again")
    if len(edges):
        at = ", ".join(f"{value * 1e3:.6g}" for value in points[edges[0]].mean(axis=0))
        count = f"{len(edges)} edges belong" if len(edges) > 1 else "1 edge belongs"
        _fail(name, f"is open: {count} to an odd number of triangles, the first at {at} mm; close the body")
    turned = outward(points, faces, name)
    notes += turned.notes
    return turned.triangles, tuple(notes)


def _data(path: Path) -> bytes:
    try:
        with path.open("rb") as stream:
            if path.suffix.lower() == ".stl" and stream.seekable():
                count = int.from_bytes(stream.read(_HEADER)[80:], "little")
                if count > MOST_TRIANGLES and stream.seek(0, io.SEEK_END) == _HEADER + _FACET * count:
                    _too_many(path, count)
                stream.seek(0)
            data = stream.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else "no such name"
        raise UsageError(f"mesh {path}: cannot be read ({why}); check the path") from None
    if len(data) > MOST_BYTES:
        _fail(path, f"has more than {MOST_BYTES // 1_000_000} MB; export it with coarser triangles")
    return data


def _fail(path: Path | str, what: str) -> NoReturn:
    raise UsageError(f"mesh {path}: {what}" if isinstance(path, Path) else f"{path}: {what}")


def _too_many(path: Path, count: int) -> NoReturn:
    _fail(path, f"has {count} triangles; export it with coarser ones, {MOST_TRIANGLES} are the most")


def _stl(data: bytes, path: Path) -> tuple[Corners, None]:
    """Corners (n, 3, 3) in the file's unit, which STL does not tell."""
    count = int.from_bytes(data[80:_HEADER], "little") if len(data) >= _HEADER else 0
    whole = len(data) == _HEADER + _FACET * count and len(data) >= _HEADER
    # the head of a binary file may begin with "solid" as well
    if not whole and re.match(rb"\s*solid", data, re.IGNORECASE) and b"\0" not in data[: 2 * _HEADER]:
        return _ascii_stl(data, path), None
    if not whole:
        held = (len(data) - _HEADER) // _FACET
        if len(data) < _HEADER or (data[:_HEADER].isascii() and b"\n" in data[:_HEADER]):
            _fail(path, "is no STL file; export the body again")
        if held < count:
            _fail(path, f"is cut short: it tells of {count} triangles and holds {held}; copy it again")
        _fail(path, f"goes on behind its {count} triangles; export the body again")
    if count > MOST_TRIANGLES:
        _too_many(path, count)
    layout = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.frombuffer(data, layout, count, _HEADER)["corners"].copy(), None


def _ascii_stl(data: bytes, path: Path) -> Floats:
    text = data.lower()
    if not re.search(rb"endsolid[^\n]*\s*\Z", text):
        _fail(path, "is cut short: it does not end with endsolid; copy it again")
    facets = text.count(b"endfacet")
    if facets > MOST_TRIANGLES:
        _too_many(path, facets)
    corners, begin = [_NONE.reshape(-1, 3)], 0
    while begin < len(data):
        # piece by piece: as words a file takes thirty times its size
        end = text.find(b"endfacet", begin + _PIECE)
        end = len(data) if end < 0 else end
        found = _VERTEX.findall(data, begin, end)
        try:
            corners.append(np.array(found, dtype=np.bytes_).reshape(-1, 3).astype(np.float64))
        except ValueError:
            _fail(path, "has a corner that is not three numbers; export the body again")
        begin = end
    found_corners = np.concatenate(corners)
    if len(found_corners) != 3 * facets:
        _fail(path, f"has {len(found_corners)} corners of {facets} triangles; export the body again")
    return found_corners.reshape(-1, 3, 3)


def _by_trimesh(data: bytes, suffix: str, path: Path) -> tuple[Floats, float | None]:
    """Corners (n, 3, 3) in the file's unit, and how many metres that is; None where it does not tell."""
    try:
        import trimesh
    except ImportError:
        raise UsageError(
            f"mesh {path}: {suffix[1:].upper()} is read by trimesh, which is not installed; install toolpace[mesh], or "
            "save the body as STL"
        ) from None
    if suffix == ".3mf":
        _check_archive(data, path)
    try:
        # no resolver: what the file names beside itself (materials, pictures) is not opened
        scene = trimesh.load_scene(io.BytesIO(data), file_type=suffix[1:], process=False, resolver=None)
        unit = scene.metadata.get("units") if suffix == ".3mf" else None
        meshes = [each for each in scene.dump() if isinstance(each, trimesh.Trimesh)]
        corners = np.concatenate([np.asarray(each.vertices)[np.asarray(each.faces)] for each in meshes] or [_NONE])
        corners = np.ascontiguousarray(corners, dtype=np.float64)
        if corners.shape[1:] != (3, 3):
            raise ValueError("its corners do not have three coordinates each")
    # what a library raises of a damaged file is anything at all
    except Exception as error:
        why = in_short(error) or type(error).__name__
        raise UsageError(f"mesh {path}: is no {suffix[1:].upper()} file ({printable(why)}); export it again") from None
    if unit is None:
        return corners, None
    scale = MESH_UNITS.get(str(unit).lower().removesuffix("s").replace("feet", "foot").replace("inche", "inch"))
    if scale is None:
        _fail(path, f"tells the unit '{printable(str(unit))[:40]}', which is none of 3MF; export the body again")
    return corners, scale


def _check_archive(data: bytes, path: Path) -> None:
    """Refuse what would fill the memory once it is unpacked."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(each.file_size for each in archive.infolist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        _fail(path, "is no 3MF file (a damaged archive, or cut short); export the body again")
    if size > MOST_BYTES:
        _fail(path, f"holds {size // 1_000_000} MB; export it with coarser triangles")
