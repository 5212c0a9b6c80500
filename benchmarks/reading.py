"""How long it takes to read 100 000 blocks, by dialect and kind.

    python -m benchmarks.reading        writes benchmarks/results/reading.md

Programs are written here, with a fixed seed. What is measured is one reading of a program in memory, processor time
and wall-clock time, for the machine `xyzac-trunnion`; every reading is the first of its program.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text

BLOCKS = 100_000
MACHINE = "xyzac-trunnion"


def places() -> Iterator[tuple[float, float, float, float, float]]:
    """X, Y, Z [mm], A and C [deg] of a surface that is gone over in rows, as CAM systems write them."""
    angle = np.arange(BLOCKS) * 0.01
    rows = zip(
        (60.0 * np.sin(angle)).round(4).tolist(),
        (np.arange(BLOCKS) * 8e-4 - 40.0).round(4).tolist(),
        (5.0 * np.cos(angle * 0.7)).round(4).tolist(),
        (20.0 + 10.0 * np.sin(angle * 0.3)).round(3).tolist(),
        (30.0 * np.cos(angle * 0.2)).round(3).tolist(),
    )
    yield from rows


def vectors() -> Iterator[tuple[float, float, float, str, str, str]]:
    """X, Y, Z [mm] and the tool axis, to six digits."""
    for x, y, z, a, c in places():
        tilt, turn = np.deg2rad(a), np.deg2rad(c)
        yield x, y, z, *(f"{v:.6f}" for v in (np.sin(tilt) * np.sin(turn), -np.sin(tilt) * np.cos(turn), np.cos(tilt)))


def linuxcnc() -> Iterator[str]:
    """Five axes in tip mode."""
    yield "G21 G90 G94 G54\nG0 X0 Y0 Z50 A0 C0\nM428\nG1 F2000"
    for x, y, z, a, c in places():
        yield f"X{x} Y{y} Z{z} A{a} C{c}"
    yield "M429\nM2"


def fanuc_vectors() -> Iterator[str]:
    """Tool axes under G43.5."""
    yield "%\nO0001\nG21 G90 G94 G54\nG0 X0 Y0 Z50. A0 C0\nG43.5 H1\nG1 F2000."
    for x, y, z, i, j, k in vectors():
        yield f"X{x:.4f} Y{y:.4f} Z{z:.4f} I{i} J{j} K{k}"
    yield "G49\nM30\n%"


def fanuc_variables() -> Iterator[str]:
    """Every other block sets a variable, with functions."""
    yield "%\nO0001\nG21 G90 G94 G54\nG0 X0 Y0 Z50.\nG1 F2000.\n#100=1."
    for k, (x, y, z, _, _) in enumerate(places()):
        yield f"X[{x}+#100] Y[{y}*#101] Z[{z}-#102/2.]" if k % 2 else f"#{100 + k % 3}=[#100+SIN[{k % 90}.]]/2."
        if not k:
            yield "#101=1.\n#102=1."
    yield "M30\n%"


def fanuc_cycles() -> Iterator[str]:
    """Holes with pecks."""
    yield "%\nO0001\nG21 G90 G94 G54\nG0 X0 Y0 Z50.\nG98 G83 Z-12. R3. Q5. F300."
    for x, y, *_ in places():
        yield f"X{x:.4f} Y{y:.4f}"
    yield "G80\nM30\n%"


def sinumerik_axes() -> Iterator[str]:
    """Five axes under TRAORI."""
    yield "G71 G90 G94 G54\nG0 X0 Y0 Z50 A0 C0\nTRAORI\nG54\nG1 F2000"
    for x, y, z, a, c in places():
        yield f"X{x} Y{y} Z{z} A{a} C{c}"
    yield "TRAFOOF\nM30"


def sinumerik_vectors() -> Iterator[str]:
    """Tool axes."""
    yield "G71 G90 G94 G54\nG0 X0 Y0 Z50 A0 C0\nTRAORI\nG54\nG1 F2000"
    for x, y, z, i, j, k in vectors():
        yield f"X{x} Y{y} Z{z} A3={i} B3={j} C3={k}"
    yield "TRAFOOF\nM30"


def sinumerik_variables() -> Iterator[str]:
    """Every other block sets parameters, with functions."""
    yield "G71 G90 G94 G54\nG0 X0 Y0 Z50\nG1 F2000\nR0=1 R1=1 R2=1"
    for k, (x, y, z, _, _) in enumerate(places()):
        yield f"X={x}+R0 Y={y}*R1 Z={z}-R2/2" if k % 2 else f"R{k % 3}=(R0+SIN({k % 90}))/2"
    yield "M30"


def sinumerik_cycles() -> Iterator[str]:
    """Holes with pecks."""
    yield "G71 G90 G94 G54\nG0 X0 Y0 Z50 F300\nMCALL CYCLE83(50,0,3,-12,,-5,,5,0,0,1,1)"
    for x, y, *_ in places():
        yield f"X{x} Y{y}"
    yield "MCALL\nM30"


def klartext_axes() -> Iterator[str]:
    """Five axes under M128."""
    yield "BEGIN PGM P MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+50 A+0 C+0 FMAX\nM128"
    for x, y, z, a, c in places():
        yield f"L X{x:+} Y{y:+} Z{z:+} A{a:+} C{c:+} F2000"
    yield "M129\nM30\nEND PGM P MM"


def klartext_variables() -> Iterator[str]:
    """Every other block sets a parameter, with functions."""
    yield "BEGIN PGM P MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+50 FMAX\nQ1 = 1\nQ2 = 1\nQ3 = 1"
    for k, (x, y, _, _, _) in enumerate(places()):
        yield (
            f"L X+Q{1 + k % 3} Y{y:+} Z+Q{1 + (k + 1) % 3} F2000"
            if k % 2
            else f"Q{1 + k % 3} = ( {x} + SIN {k % 90} ) / 2"
        )
    yield "M30\nEND PGM P MM"


def klartext_cycles() -> Iterator[str]:
    """Holes with pecks."""
    yield "BEGIN PGM P MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+50 FMAX"
    figures = {200: "+3", 201: "-12", 206: "+300", 202: "+5", 210: "+0", 203: "+0", 204: "+50", 211: "+0"}
    yield "CYCL DEF 200 DRILLING ~\n" + " ~\n".join(f"Q{q}={value}" for q, value in figures.items())
    for x, y, *_ in places():
        yield f"L X{x:+} Y{y:+} FMAX M99"
    yield "M30\nEND PGM P MM"


def cl_points() -> Iterator[str]:
    """Points with tool axes."""
    yield "TOOL PATH/P,TOOL,T1\nTLDATA/MILL,10.0,0.0,75.0,0.0,0.0\nFEDRAT/MMPM,2000."
    for x, y, z, i, j, k in vectors():
        yield f"GOTO/{x:.4f},{y:.4f},{z:.4f},{i},{j},{k}"
    yield "END-OF-PATH"


def cl_cycles() -> Iterator[str]:
    """Holes with pecks."""
    yield "TOOL PATH/P,TOOL,T1\nTLDATA/MILL,10.0,0.0,75.0,0.0,0.0\nRAPID\nGOTO/0.,0.,50.,0.,0.,1."
    yield "CYCLE/DRILL,DEEP,RAPTO,3.,FEDTO,-12.,STEP,5.,RTRCTO,50.,MMPM,300."
    for x, y, *_ in places():
        yield f"GOTO/{x:.4f},{y:.4f},0.0000"
    yield "CYCLE/OFF\nEND-OF-PATH"


def cl_splines() -> Iterator[str]:
    """NURBS records of twenty points, each statement a block."""
    yield "TOOL PATH/P,TOOL,T1\nTLDATA/MILL,10.0,0.0,75.0,0.0,0.0\nFEDRAT/MMPM,2000.\nGOTO/0.,0.,0.,0.,0.,1."
    rows = list(places())
    control = 20
    for first in range(0, BLOCKS // 2, control):
        yield "NURBS/"
        inner = control - 3
        yield from (f"KNOT/{(k + 1) / (inner + 1):.10f}" for k in range(inner))
        yield "KNOT/1.0000000000"
        yield from (f"CNTRL/{x:.4f},{y:.4f},{z:.4f}" for x, y, z, *_ in rows[first : first + control])
    yield "END-OF-PATH"


CASES: dict[tuple[str, str], tuple[str | None, Callable[[], Iterator[str]]]] = {
    ("LinuxCNC", "five axes"): ("linuxcnc", linuxcnc),
    ("Fanuc", "tool vectors"): ("fanuc", fanuc_vectors),
    ("Fanuc", "variables"): ("fanuc", fanuc_variables),
    ("Fanuc", "cycles"): ("fanuc", fanuc_cycles),
    ("Sinumerik", "five axes"): ("sinumerik", sinumerik_axes),
    ("Sinumerik", "tool vectors"): ("sinumerik", sinumerik_vectors),
    ("Sinumerik", "variables"): ("sinumerik", sinumerik_variables),
    ("Sinumerik", "cycles"): ("sinumerik", sinumerik_cycles),
    ("Klartext", "five axes"): ("heidenhain", klartext_axes),
    ("Klartext", "variables"): ("heidenhain", klartext_variables),
    ("Klartext", "cycles"): ("heidenhain", klartext_cycles),
    ("CL data", "points"): (None, cl_points),
    ("CL data", "cycles"): (None, cl_cycles),
    ("CL data", "splines"): (None, cl_splines),
}


def program(case: tuple[str, str]) -> str:
    """The text of a case."""
    return "\n".join(CASES[case][1]()) + "\n"


def measured(case: tuple[str, str], machine: Machine) -> list[str]:
    """A line of the table."""
    text = program(case)
    begun = time.process_time(), time.perf_counter()
    path = read_text(text, machine=machine, controller=CASES[case][0])
    cpu, wall = time.process_time() - begun[0], time.perf_counter() - begun[1]
    return [*case, str(text.count("\n")), str(len(path)), f"{cpu:.2f}", f"{wall:.2f}"]


def main() -> None:
    """The table, on the terminal and in benchmarks/results."""
    machine = Machine.load(MACHINE)
    # what is imported and compiled once is no reading
    read_text("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nM428\nG1 X1 A1 F100\nM2\n", machine=machine, controller="linuxcnc")
    table = Table("Reading, one program each", ["dialect", "kind", "blocks", "points", "CPU [s]", "wall [s]"])
    for case in CASES:
        table.lines.append(measured(case, machine))
    table.show()
    page = f"# Reading 100 000 blocks\n\n{written_by('python -m benchmarks.reading')}\n\n{table.markdown()}"
    (RESULTS / "reading.md").write_text(page)


if __name__ == "__main__":
    main()
