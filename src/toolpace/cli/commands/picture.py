"""The command `picture`: a planned motion at a moment as PNG, or an animation as GIF or MP4, without a browser."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from cyclopts import Parameter

from toolpace.cli import options
from toolpace.cli.console import Steps, new_console
from toolpace.common.errors import UsageError, printable

if TYPE_CHECKING:
    from toolpace.results.picture.draw import ShownPlan

SMALLEST, LARGEST = 64, 4000
"""Sides of a picture [pixels]."""
LONGEST = 60.0
"""Of an animation [s]."""
FRAMES_PER_SECOND = 10
VIDEO_FRAMES_PER_SECOND = 25
QUALITY = "20"
"""Of a video, as x264 counts it: less is better and larger; from 18 on nobody sees what is lost."""
MOVING_POINTS = 110
"""Of the lattice of the stock along its longest side, in an animation: its pictures are small."""
COLOURS, SAMPLES = 128, 6
"""Of an animation, and of how many of its pictures the palette is."""
STILL, MOVING = "1200x900", "480x360"
View = Annotated[
    str,
    Parameter(help="From where: iso, top, front, right; machine shows the machine too."),
]
At = Annotated[str, Parameter(help="The moment: 12.5s, 3min; start or end.")]
Out = Annotated[str | None, Parameter(name=["--out", "-o"], help="File for the picture: x.png.")]
To = Annotated[str | None, Parameter(help="File for an animation in place of a picture: x.gif, x.mp4.")]
Begin = Annotated[str, Parameter(help="Where the animation begins: 12.5s; start or end.")]
Finish = Annotated[str, Parameter(help="Where it ends.")]
Seconds = Annotated[str, Parameter(help="How long the animation plays.")]
Size = Annotated[
    str | None, Parameter(help=f"Width and height in pixels. {STILL} by default; of an animation {MOVING}.")
]


def picture_command(
    directory: options.PlanFolder,
    /,
    *,
    view: View = "iso",
    at: At = "end",
    out: Out = None,
    to: To = None,
    begin: Begin = "start",
    finish: Finish = "end",
    seconds: Seconds = "8s",
    size: Size = None,
) -> int:
    """Draw a plan: the stock as it is at a moment, tool, fixtures, and the path by speed.

    Nothing but the folder of the plan is needed, no browser and no display. What is
    passed later is thin and grey. Stock, tools and fixtures are those of the set-up
    sheet; without them there is the path and a thin tool.

    For example:

        toolpace picture part-plan -o part.png
        toolpace picture part-plan --view top --at 12.5s -o part.png
        toolpace picture part-plan --to part.gif --seconds 6s
        toolpace picture part-plan --to part.mp4 --seconds 20s --size 1280x720
        toolpace picture part-plan --view machine --begin 10s --finish 20s --to part.gif
    """
    from toolpace.results.picture.draw import POINTS, ShownPlan, direction_axes

    if (out is None) == (to is None):
        raise UsageError("picture: give one of --out x.png (a picture) and --to x.gif or x.mp4 (an animation)")
    target = file_of(out, (".png",), "--out") if out is not None else file_of(to or "", (".gif", ".mp4"), "--to")
    pixels = sides(size or (STILL if out is not None else MOVING))
    is_video = target.suffix.lower() == ".mp4"
    if is_video:
        video_library()
        refuse_odd(pixels)
    else:
        library()
    direction_axes(view)
    console = new_console()
    steps = Steps(console)
    with steps.step("loading") as step:
        shown = ShownPlan.load(directory, POINTS if out is not None else MOVING_POINTS)
        step.note = shown.workpiece.note
    if out is not None:
        with steps.step("drawing"):
            write_picture(target, shown, moment(at, shown.duration, "--at"), view, pixels)
    else:
        span = moment(begin, shown.duration, "--begin"), moment(finish, shown.duration, "--finish")
        film = Film(shown, span, length(seconds), view, pixels)
        with steps.step("drawing") as step:
            step.note = f"{(write_video if is_video else write_animation)(target, film, step)} pictures"
    console.print(f"written   {printable(str(target))}", soft_wrap=True)
    return 0


def file_of(name: str, suffixes: tuple[str, ...], option: str) -> Path:
    """The file to write. Raises UsageError where its ending is another, or its folder is not there."""
    found = Path(name)
    if found.suffix.lower() not in suffixes:
        raise UsageError(f"{option} {name[:80]}: it ends with {' or '.join(suffixes)}, like part{suffixes[0]}")
    if not found.absolute().parent.is_dir():
        raise UsageError(f"{option} {name[:80]}: its folder does not exist; make it first")
    return found


def sides(text: str) -> tuple[int, int]:
    """Width and height [pixels]. Raises UsageError."""
    wide, cross, tall = text.lower().partition("x")
    if not (cross and wide.isdecimal() and tall.isdecimal() and len(text) < 12):
        raise UsageError(f"--size {text[:40]}: give width and height, like {STILL}")
    found = int(wide), int(tall)
    if not all(SMALLEST <= each <= LARGEST for each in found):
        raise UsageError(f"--size {text[:40]}: give sides from {SMALLEST} to {LARGEST} pixels")
    return found


def refuse_odd(pixels: tuple[int, int]) -> None:
    """Raise UsageError for sides that a video cannot have: its colours are of two pixels each."""
    if pixels[0] % 2 or pixels[1] % 2:
        raise UsageError(f"--size {pixels[0]}x{pixels[1]}: sides of an mp4 are even; give {MOVING}, say")


def moment(text: str, duration: float, option: str) -> float:
    """A time of the motion [s]. Raises UsageError where it has none such."""
    from toolpace.cli import arguments

    if text.strip() in ("start", "0", "0s"):
        return 0.0
    if text.strip() == "end":
        return duration
    found = arguments.time_option(option, text)
    if found > duration * (1.0 + 1e-9):
        raise UsageError(f"{option} {text[:40]}: the motion ends at {duration:.6g} s; give a time before that, or end")
    return min(found, duration)


def length(text: str) -> float:
    """How long an animation plays [s]. Raises UsageError."""
    from toolpace.cli import arguments

    found = arguments.time_option("--seconds", text)
    if not 1.0 / FRAMES_PER_SECOND <= found <= LONGEST:
        raise UsageError(f"--seconds {text[:40]}: give a time up to {LONGEST:g}s")
    return found


def library() -> Any:
    """What writes pictures. Raises UsageError, naming the extra, where it is missing."""
    try:
        from PIL import Image
    except ImportError:
        raise UsageError("pictures are written by Pillow: pip install 'toolpace[picture]'") from None
    return Image


def video_library() -> Any:
    """What writes videos. Raises UsageError, naming the extra, where it is missing."""
    try:
        import av
    except ImportError:
        raise UsageError("videos are written by PyAV: pip install 'toolpace[video]', or --to x.gif") from None
    return av


def write_picture(target: Path, shown: ShownPlan, t: float, view: str, pixels: tuple[int, int]) -> None:
    """Write a picture of a moment [s], whole or not at all."""
    from toolpace.common.files import whole_file
    from toolpace.results.picture.draw import picture

    with whole_file(target) as temporary:
        library().fromarray(picture(shown, t, view, pixels)).save(temporary, format="PNG", optimize=True)


class Film(NamedTuple):
    """A stretch of time of a plan, and how it is drawn."""

    shown: ShownPlan
    span: tuple[float, float]
    """Its begin and end [s]."""
    seconds: float
    """How long it plays [s]."""
    view: str
    pixels: tuple[int, int]

    def pictures(self, frames_per_second: int, progress: Any) -> Iterator[Any]:
        """Its pictures (height, width, 3), evenly spread over the time, one after the other."""
        from toolpace.results.picture.draw import picture

        count = max(math.ceil(self.seconds * frames_per_second), 2)
        begin, end = self.span
        for k in range(count):
            yield picture(self.shown, begin + (end - begin) * k / (count - 1), self.view, self.pixels)
            progress((k + 1) / count)


def write_animation(target: Path, film: Film, progress: Any) -> int:
    """Write a film as GIF, whole or not at all; return how many pictures it has."""
    from toolpace.common.files import whole_file

    image, (width, height) = library(), film.pixels
    frames = [image.fromarray(each) for each in film.pictures(FRAMES_PER_SECOND, progress)]
    count = len(frames)
    # one palette for all: what does not change is then the same in all of them, and takes no room; small things such as
    # the tool keep their colours
    sheet = image.new("RGB", (width, height * SAMPLES))
    for k in range(SAMPLES):
        sheet.paste(frames[(count - 1) * k // (SAMPLES - 1)], (0, height * k))
    palette = sheet.quantize(COLOURS, method=image.Quantize.MAXCOVERAGE)
    drawn = [each.quantize(palette=palette, dither=image.Dither.NONE) for each in frames]
    # the last is looked at for a while
    times = [round(1000 / FRAMES_PER_SECOND)] * (count - 1) + [1500]
    with whole_file(target) as temporary:
        drawn[0].save(
            temporary, format="GIF", save_all=True, append_images=drawn[1:], duration=times, loop=0, optimize=False
        )
    return count


def write_video(target: Path, film: Film, progress: Any) -> int:
    """Write a film as MP4 (H.264), whole or not at all; return how many pictures it has."""
    from toolpace.common.files import whole_file

    av, count = video_library(), 0
    with whole_file(target) as temporary, av.open(str(temporary), "w", format="mp4") as video:
        stream = video.add_stream("libx264", rate=VIDEO_FRAMES_PER_SECOND, options={"crf": QUALITY})
        # what every player shows
        stream.width, stream.height, stream.pix_fmt = *film.pixels, "yuv420p"
        for each in film.pictures(VIDEO_FRAMES_PER_SECOND, progress):
            video.mux(stream.encode(av.VideoFrame.from_ndarray(each, format="rgb24")))
            count += 1
        video.mux(stream.encode())
    return count
