"""Blocks of flow: loops, conditions, calls, saved modes."""

from __future__ import annotations

from testbed.linuxcnc import modes, motions
from testbed.linuxcnc.writer import Writer


def inside(writer: Writer) -> None:
    """Blocks within a loop, which leave all modes as they were."""
    if writer.mode == "G93":
        writer.put("G1", writer.axes(0.5), writer.f())
        return
    was, writer.absolute = writer.absolute, False
    writer.put("G91 G1", writer.axes(0.5))
    writer.absolute = was
    if was:
        writer.put("G90")


def loop(writer: Writer) -> None:
    writer.labels += 1
    name = f"o{writer.labels}" if writer.chance(0.7) else f"o<loop{writer.labels}>"
    kind = writer.random.choice(["while", "repeat", "do", "if", "elseif"])
    times = writer.random.randint(0, 3)
    if kind == "repeat":
        writer.put(f"{name} repeat [{times}]")
        inside(writer)
        if writer.chance(0.3):
            loop(writer)
        writer.put(f"{name} endrepeat")
    elif kind == "while":
        writer.put("#10=0")
        writer.put(f"{name} while [#10 LT {times}]")
        inside(writer)
        writer.put("#10=[#10+1]")
        if writer.chance(0.3):
            writer.labels += 1
            writer.put(f"o{writer.labels} if [#10 EQ 2]")
            writer.put(f"{name} {writer.random.choice(['break', 'continue'])}")
            writer.put(f"o{writer.labels} endif")
        inside(writer)
        writer.put(f"{name} endwhile")
    elif kind == "do":
        writer.put("#11=0")
        writer.put(f"{name} do")
        writer.put("#11=[#11+1]")
        inside(writer)
        writer.put(f"{name} while [#11 LT {times}]")
    else:
        writer.put(f"#12={times}")
        writer.put(f"{name} if [#12 GT 1]")
        inside(writer)
        if kind == "elseif":
            writer.put(f"{name} elseif [#12 EQ 1]")
            inside(writer)
        if writer.chance(0.7):
            writer.put(f"{name} else")
            inside(writer)
        writer.put(f"{name} endif")


def call(writer: Writer) -> None:
    writer.labels += 1
    name = f"o{writer.labels}" if writer.chance(0.5) else f"o<part{writer.labels}>"
    was, writer.lines, named, writer.named = writer.lines, [], writer.named, ["#1", "#2", "#3"]
    writer.put(f"{name} sub")
    if writer.chance(0.3):
        writer.put("#1=[#1+1]")
    inside(writer)
    if writer.mode == "G93":
        writer.put(f"G1 X#1 Y#2 {writer.f()}")
    else:
        writer.put("G1 X#1 Y[#2/2]")
    if writer.chance(0.3):
        writer.put(f"{name} return [#1*2]" if writer.chance(0.5) else f"{name} return")
        writer.put("G1 X99")
    writer.put(f"{name} endsub {writer.random.choice(['', '[#1+3]'])}".rstrip())
    body, writer.lines, writer.named = writer.lines, was, named
    if writer.chance(0.5):
        writer.subs.append(body)
    else:
        writer.lines += body
    for _ in range(writer.random.randint(1, 2)):
        arguments = " ".join(f"[{writer.number(-20, 20)}]" for _ in range(writer.random.randint(0, 3)))
        writer.put(f"{name} call {arguments}".rstrip())
    if writer.chance(0.3):
        writer.put("G1 X[#<_value>/2]", writer.f())


def deep(writer: Writer) -> None:
    """Calls within each other: variables of their own, values returned early and late, recursion that ends."""
    writer.labels += 2
    inner, outer = f"o{writer.labels}", f"o{writer.labels - 1}"
    here = "G91 G1 " + writer.axes(0.4, turning=0.0) + (writer.f() if writer.mode == "G93" else "")
    back = "G90" if writer.absolute else ""
    f = writer.f() if writer.mode == "G93" else ""
    writer.subs.append([
        f"{inner} sub", "#3=[#1*2]", "#<a>=[#2+1]", "#<_wide>=[#<_wide>+1]", f"{outer} if [#1 GT 2.5]",
        f"{inner} return [#3+#<a>]", f"{outer} endif", here, *([back] if back else []), f"{inner} call [#1+1] [#3]",
        f"G1 X[#<_value>/9] Y#1 Z#<a> {f}".rstrip(), f"{inner} endsub [#<_value>-1]",
    ])  # fmt: skip
    writer.put(f"#<_wide>={writer.random.randint(0, 3)}", "#3=7")
    writer.put(f"{inner} call [{writer.random.randint(0, 3)}] [#3]")
    writer.put(f"G1 X#3 Y#<_wide> Z[#<_value>/7] {writer.f()}")


def by_number(writer: Writer) -> None:
    """Programs called by M98."""
    if writer.mode == "G93":
        return
    writer.labels += 1
    named, writer.named = writer.named, []  # they are the caller's own
    move = f"G1 {writer.axes(0.4)}"
    writer.named = named
    writer.behind += [f"O{writer.labels}", move, "G1 X[#30+1]", "#30=[#30+2]", "M99"]
    writer.put(f"#30={writer.random.randint(0, 5)}")
    writer.lines.append(" ".join([f"M98 P{writer.labels}", writer.random.choice(["", "L2", "L3"])]))


def together(writer: Writer) -> None:
    """Variables set in the block that uses them keep their old values in it."""
    writer.put(f"#1={writer.number(-9, 9)}", f"#2={writer.number(-9, 9)}")
    writer.put(f"G1 X#1 #1=[#1+5] Y[#2*#1] #2=#1 {writer.f()}")
    writer.put("#3=1")
    writer.put(f"G1 X##3 Y#[#3+1] #3=2 {writer.f()}" if writer.chance(0.5) else f"G1 X#1 Y#2 {writer.f()}")


def modes_kept(writer: Writer) -> None:
    """M70 and M72, or M73 in a subprogram."""
    was = writer.inch, writer.absolute, writer.plane, writer.mode
    changes = [modes.unit, modes.distance, modes.planes, modes.mode_of_path, motions.line, modes.offset, motions.line]
    in_sub = writer.chance(0.5)
    if in_sub:
        writer.labels += 1
        lines, writer.lines = writer.lines, []
        writer.put(f"o{writer.labels} sub")
    writer.put("M73" if in_sub else "M70")
    for _ in range(4):
        writer.random.choice(changes)(writer)
    if in_sub:
        writer.put(f"o{writer.labels} endsub")
        writer.subs.append(writer.lines)
        writer.lines = lines
        writer.put(f"o{writer.labels} call")
    else:
        writer.put("M72")
    writer.inch, writer.absolute, writer.plane, writer.mode = was
    writer.put("G1", writer.axes(0.5), writer.f())


def with_blanks(writer: Writer) -> None:
    """O-words with blanks in them, rounds that are no whole number, values with and without brackets."""
    writer.labels += 1
    name = f"o{writer.labels}"
    value = writer.random.choice(["[2.7]", "[1.5]", "[2.5]", "[-1]", "[0.4]", "[2]", "[#10]", "2", "[2] [3]"])
    writer.put(f"#10={writer.random.randint(0, 2)}")
    if writer.chance(0.5):
        writer.put(f"{name} repeat {value}")
        inside(writer)
        writer.put(f"{name} {writer.random.choice(['end repeat', 'endrepeat', 'endrepeat [1]'])}")
        return
    writer.put(f"{name} if {value}")
    inside(writer)
    writer.put(f"{name} {writer.random.choice(['else if [1]', 'elseif [0]', 'else'])}")
    inside(writer)
    writer.put(f"{name} {writer.random.choice(['end if', 'endif', 'e n d i f'])}")


def reckoned(writer: Writer) -> None:
    """A subprogram that is called by a number that is reckoned."""
    writer.labels += 1
    number, f = writer.labels, writer.f() if writer.mode == "G93" else ""
    writer.subs.append([f"o{number} sub", f"G1 X#1 {f}".rstrip(), f"o{number} end sub"])
    writer.put(f"#11={number / 2}")
    arguments = writer.random.choice(["", "[3]", "[1] [2]", " ".join(["[1]"] * writer.random.choice([30, 31]))])
    writer.put(f"o[#11*2] call {arguments}".rstrip())


def labels(writer: Writer) -> None:
    """Two loops or conditions, of one label or of two; in one subprogram, or not."""
    writer.labels += 2
    first, second = writer.labels, writer.labels - writer.random.choice([0, 1])
    lines, writer.lines = writer.lines, []
    in_sub = writer.chance(0.5)
    writer.labels += 1
    for k, name in enumerate((first, second)):
        if in_sub and k == 0:
            writer.put(f"o{writer.labels} sub")
        writer.put(f"o{name} if [{writer.random.randint(0, 1)}]")
        inside(writer)
        writer.put(f"o{name} endif")
        if in_sub and k == 0:
            writer.put(f"o{writer.labels} endsub")
            writer.subs.append(writer.lines)
            writer.lines = []
    writer.lines = lines + writer.lines
    if in_sub:
        writer.put(f"o{writer.labels} call")
