"""Meshes from files: what is read, what is repaired, and one line for what is no body."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from toolpace.common.errors import UsageError
from toolpace.cutting.stock.mesh_file import MOST_TRIANGLES, closed_surface, load_mesh

BOX = np.ascontiguousarray(trimesh.creation.box((100.0, 60.0, 20.0)).triangles)
"""(12, 3, 3) [mm]"""


def volume(triangles: np.ndarray) -> float:
    """[m3]"""
    return float(np.einsum("ij,ij->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2]))) / 6.0


def moved(x: float, y: float, z: float) -> np.ndarray:
    """The box elsewhere."""
    return BOX + np.array([x, y, z])


def stl(triangles: np.ndarray, count: int | None = None) -> bytes:
    """A binary file."""
    rows = np.zeros(len(triangles), np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]))
    rows["c"] = triangles
    number = len(triangles) if count is None else count
    return b"solid by hand".ljust(80) + number.to_bytes(4, "little") + rows.tobytes()


def ascii_stl(triangles: np.ndarray) -> bytes:
    facets = [
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in triangle)
        + " endloop\nendfacet\n"
        for triangle in triangles
    ]
    return ("solid part\n" + "".join(facets) + "endsolid part\n").encode()


def three_mf(triangles: np.ndarray, unit: str = "millimeter") -> bytes:
    """The least that is a 3MF file, with the body once as it is and once moved by (200, 0, 0)."""
    points, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    vertices = "".join(f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in points)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in index.reshape(-1, 3))
    model = (
        f'<?xml version="1.0"?><model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
        f'<resources><object id="1" type="model"><mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles>'
        '</mesh></object></resources><build><item objectid="1"/>'
        '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 200 0 0"/></build></model>'
    )
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
    return stream.getvalue()


def obj(triangles: np.ndarray) -> bytes:
    corners = "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in triangles.reshape(-1, 3))
    faces = "".join(f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}\n" for k in range(len(triangles)))
    return b"mtllib ../../etc/passwd\n" + (corners + faces).encode()


@pytest.mark.parametrize("name, write", [("a.stl", stl), ("a.STL", ascii_stl), ("a.obj", obj)])
def test_a_box_is_the_same_in_each_kind_of_file(tmp_path, name, write):
    (tmp_path / name).write_bytes(write(BOX))
    mesh = load_mesh(tmp_path / name)
    assert volume(mesh.triangles) == pytest.approx(1.2e-4) and mesh.unit_assumed and mesh.notes == ()
    inch = load_mesh(tmp_path / name, "in")
    assert volume(inch.triangles) == pytest.approx(1.2e5 * 0.0254**3) and not inch.unit_assumed


@pytest.mark.parametrize("unit, metres", [("millimeter", 1e-3), ("inch", 0.0254), ("meter", 1.0), ("micron", 1e-6)])
def test_a_3mf_file_tells_its_unit_and_where_its_bodies_are(tmp_path, unit, metres):
    (tmp_path / "a.3mf").write_bytes(three_mf(BOX, unit))
    mesh = load_mesh(tmp_path / "a.3mf")
    assert volume(mesh.triangles) == pytest.approx(2 * 1.2e5 * metres**3, rel=1e-9) and not mesh.unit_assumed
    assert np.ptp(mesh.triangles[:, :, 0]) == pytest.approx(300 * metres)


SPHERE = np.ascontiguousarray(trimesh.creation.icosphere(3, 30.0).triangles)


def test_what_is_certain_is_repaired_and_said():
    inverted, notes = closed_surface(1e-3 * BOX[:, ::-1])
    assert volume(inverted) == pytest.approx(1.2e-4) and "inside out" in notes[0]
    some = SPHERE.copy()
    some[::7] = some[::7, ::-1]
    turned, notes = closed_surface(1e-3 * some)
    assert volume(turned) == pytest.approx(volume(1e-3 * SPHERE)) and "against their neighbours" in notes[0]
    # as a file of few digits has it: corners of one vertex differ in the last one
    shaken = SPHERE + np.random.default_rng(2).normal(size=SPHERE.shape) * 1e-7
    joined, notes = closed_surface(1e-3 * shaken)
    assert volume(joined) == pytest.approx(volume(1e-3 * SPHERE), rel=1e-5) and "taken for one" in notes[0]
    overlapping, notes = closed_surface(1e-3 * np.concatenate([BOX, moved(30.0, 10.0, 5.0)]))
    assert len(overlapping) == 24 and "union" in notes[0]


@pytest.mark.parametrize(
    "triangles",
    [
        np.concatenate([BOX, 0.5 * BOX[:, ::-1]]),  # a hollow
        np.concatenate([BOX, moved(100.0, 0.0, 0.0)]),  # two that share a side
        np.concatenate([BOX, moved(100.0, 60.0, 0.0)]),  # two that share an edge
        np.concatenate([BOX, np.repeat(BOX[:1, :1], 3, axis=1)]),  # a triangle without area
    ],
)
def test_bodies_that_only_look_strange_are_left_alone(triangles):
    surface, notes = closed_surface(1e-3 * triangles)
    assert notes == () and len(surface) == len(triangles) - len(triangles) % 12


def bow_tie() -> np.ndarray:
    """A prism over a four-sided figure that crosses itself."""
    lower = np.array([[0, 0, 0], [40, 40, 0], [40, 0, 0], [0, 30, 0]], dtype=float)
    upper = lower + np.array([0.0, 0.0, 10.0])
    sides = [[lower[i], lower[i - 3], upper[i - 3]] for i in range(4)]
    sides += [[lower[i], upper[i - 3], upper[i]] for i in range(4)]
    ends = [[lower[0], lower[2], lower[1]], [lower[0], lower[3], lower[2]]]
    return np.array([*sides, *ends, [upper[0], upper[1], upper[2]], [upper[0], upper[2], upper[3]]])


@pytest.mark.parametrize(
    "triangles, words",
    [
        (BOX[1:], ["is open", "3 edges", "mm; close the body"]),
        (np.concatenate([BOX, BOX[:1]]), ["is open"]),
        (bow_tie(), ["inside out at", "repair the body"]),
        (np.concatenate([BOX, 0.5 * BOX[:, ::-1] + [200.0, 0.0, 0.0]]), ["inside out at 2"]),
        (BOX * [1.0, 1.0, 0.0], ["no volume", "export a body"]),
        (np.zeros((4, 3, 3)), ["no triangles but such without area"]),
    ],
)
def test_a_surface_that_is_no_body_is_one_line(triangles, words):
    with pytest.raises(UsageError) as caught:
        closed_surface(1e-3 * triangles, "mesh part.stl")
    message = str(caught.value)
    assert message.startswith("mesh part.stl: ") and "\n" not in message
    for word in words:
        assert word in message


BOMB = io.BytesIO()
with zipfile.ZipFile(BOMB, "w", zipfile.ZIP_DEFLATED) as _archive:
    _archive.writestr("3D/3dmodel.model", b" " * 2_000_000)


@pytest.mark.parametrize(
    "name, data, words",
    [
        ("a.stl", stl(BOX)[:-10], ["cut short", "12 triangles and holds 11"]),
        ("a.stl", stl(BOX) + b"0", ["goes on behind its 12 triangles"]),
        ("a.stl", stl(BOX[:0]), ["has no triangles"]),
        ("a.stl", b"", ["is no STL file"]),
        ("a.stl", b"# a text\n" * 30, ["is no STL file"]),
        ("a.stl", ascii_stl(BOX)[:-40], ["cut short", "endsolid"]),
        ("a.stl", ascii_stl(BOX).replace(b"vertex", b"vertx", 1), ["35 corners of 12 triangles"]),
        ("a.stl", ascii_stl(BOX).replace(b"-50 ", b"-5O ", 1), ["not three numbers"]),
        ("a.stl", ascii_stl(BOX).replace(b"-50 ", b"nan ", 1), ["not finite"]),
        ("a.stl", b"solid a\nendsolid a\n", ["has no triangles"]),
        ("a.stl", b"solid".ljust(80) + (10_000_000).to_bytes(4, "little"), ["10000000 triangles and holds 0"]),
        ("a.3mf", stl(BOX), ["no 3MF file", "archive"]),
        ("a.3mf", three_mf(BOX)[:-30], ["no 3MF file"]),
        ("a.3mf", BOMB.getvalue(), ["no 3MF file"]),
        ("a.3mf", three_mf(BOX, "league"), ["unit 'league'"]),
        ("a.obj", b"v 0 0 0\nf 1 2 3\n", ["no OBJ file"]),
        ("a.obj", b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n", ["no OBJ file"]),
        ("a.obj", b"", ["a.obj"]),
        ("a.step", b"ISO-10303-21;", ["'.step' is not read", "STL, 3MF or OBJ"]),
    ],
)
def test_a_file_that_holds_no_mesh_is_one_line(tmp_path, name, data, words):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(UsageError) as caught:
        load_mesh(tmp_path / name)
    message = str(caught.value)
    assert name in message and "\n" not in message and len(message) < 600
    for word in words:
        assert word in message


def test_files_that_are_not_there_or_too_fine(tmp_path):
    with pytest.raises(UsageError, match=r"cannot be read \(no such file"):
        load_mesh(tmp_path / "gone.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(UsageError, match="cannot be read"):
        load_mesh(tmp_path / "folder.stl")
    many = tmp_path / "many.stl"
    with many.open("wb") as stream:
        stream.write(stl(BOX[:0], 19_000_000)[:84])
        stream.truncate(84 + 50 * 19_000_000)
    with pytest.raises(UsageError, match=f"has 19000000 triangles; .* {MOST_TRIANGLES} are the most"):
        load_mesh(many)


def test_a_mesh_is_read_once_as_long_as_its_file_stays_as_it_is(tmp_path):
    path = tmp_path / "a.stl"
    path.write_bytes(stl(BOX))
    mesh = load_mesh(path)
    assert load_mesh(path) is mesh and load_mesh(path, "in") is not mesh
    path.write_bytes(stl(2.0 * BOX))
    assert volume(load_mesh(path).triangles) == pytest.approx(8.0 * volume(mesh.triangles))
    with pytest.raises(ValueError, match="read-only"):
        mesh.triangles[0] = 0.0


def test_the_door_of_meshes_holds_whatever_the_bytes_are(tmp_path):
    """Random changes of each kind of file: a mesh that is closed, or one line."""
    r = np.random.default_rng(4)
    seeds = {"a.stl": [stl(BOX), ascii_stl(BOX)], "a.3mf": [three_mf(BOX)], "a.obj": [obj(BOX)]}
    read = 0
    for k in range(240):
        name = ("a.stl", "a.stl", "a.3mf", "a.obj")[k % 4]
        data = bytearray(seeds[name][k // 4 % len(seeds[name])])
        for _ in range(int(r.integers(1, 4))):
            at, kind = int(r.integers(len(data))), r.integers(4)
            if kind == 0:
                data[at] = int(r.integers(256))
            elif kind == 1:
                del data[at : at + int(r.integers(1, 80))]
            elif kind == 2:
                data[at:at] = bytes(r.integers(0, 256, int(r.integers(1, 40)), dtype=np.uint8))
            else:
                data[at : at + 12] = r.choice([b" 1e400 nan ", b"-0 inf 1e-9", b"\0" * 11]).ljust(12)
        path: Path = tmp_path / name
        path.write_bytes(data)
        try:
            mesh = load_mesh(path)
        except UsageError as error:
            assert "\n" not in str(error) and len(str(error)) < 900
            continue
        read += 1
        assert np.isfinite(mesh.triangles).all() and volume(mesh.triangles - mesh.triangles[0, 0]) > 0.0
    assert read > 10
