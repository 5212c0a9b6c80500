"""A controller, from its TOML file, and the options that a file may set, by language.

What an option does is told where it is read, and in the built-in files; a test holds both sides together.
"""

from __future__ import annotations

import functools
import re
import warnings
from pathlib import Path
from typing import TypeVar

import msgspec

from toolpace.common.errors import UsageError, did_you_mean, in_short
from toolpace.common.files.toml import toml_text
from toolpace.programs.reading.controllers.tool_rules import ToolRule

Kind = bool | float | str | tuple[str, ...]
"""A value of the kind: a switch, a number, a text; or the texts that it may be."""
SWITCH, NUMBER, TEXT = False, 0.0, ""
MOST = 10_000.0
"""Of a number: seconds, millimetres, and numbers of variables."""
TURNING = ("xyz", "vector")

WORD_ADDRESS: dict[str, Kind] = {
    **dict.fromkeys(
        (
            *("compensation_ends_before_stops", "compensation_in_xy"),
            *("angles_to_360", "arc_turns", "changes_elsewhere", "remainder_of_whole_numbers", "values_are_rounded"),
            *("assignments_last", "blanks_mean_nothing", "corner_words", "cycle_without_r", "cycles_are_a_group"),
            *("cycles_go_back_to_initial", "empty_variables", "feed_before_units", "feed_kept"),
            *("fanuc_checks", "feed_mode_forgets_feed", "indexed_words", "inverse_seconds", "inverse_time_by_radius"),
            *("last_of_group_rules", "length_with_tool", "length_word_stays", "local_shift_is_position"),
            *("local_variables_begin_at_zero", "logic_on_bits", "named_system_variables", "nested_comments"),
            *("offsets_are_absolute", "offsets_turn", "planner_by_r", "rapids_vary", "reference_without_axes_is_all"),
            *("repeats_in_program_number", "scales_by_axis", "rotation_adds", "rotation_centre_is_absolute"),
            *("rotary_varies", "rs274_checks", "rs274_cycles", "second_tool_is_next", "semicolon_ends_block"),
            *("starts_with_rapid", "tip_frame_where_switched", "tip_mode_at_start", "tip_mode_in_planes"),
            "unknown_m_stops",
            "whole_numbers_vary",
        ),
        SWITCH,
    ),
    **dict.fromkeys(
        (
            *("arc_radii_inch", "arc_radii_mm", "arc_radii_percent", "arc_radii_times", "arc_radius_least_mm"),
            *("arc_reach_mm", "chip_break_mm", "deepest_calls", "dwell_point_s", "dwell_whole_s"),
            *("last_variable", "local_variables", "offset_group", "peck_clearance_mm", "scale_of_whole"),
            "system_variables_from",
        ),
        NUMBER,
    ),
    "compensation": ("", "linuxcnc", "type A", "type B", "type C", "type C as B"),
    "compensation_corners": ("lines", "arcs"),
    "compensation_said": TEXT,
    "arc_centre": ("by mode", "fitting"),
    "arc_without_centre": ("refused", "straight"),
    "boring_shift": ("first", "first negative", "second", "second negative"),
    "extended_offsets": ("", "G54.1", "G154"),
    "first_offset": TEXT,
    "lengths_move": ("", "with the block", "refused"),
    "letter_along_tool": ("", *"UVW"),
    "peck_words": ("", "shorter", "clearance"),
    "offset_zero": ("in force", "external", "local"),
    "repeats": ("K", "L"),
    "roll_pitch_yaw": ("", "fixed", "moving"),
    "rotary": ("as written", "shortest"),
    "turning": TURNING,
    "units": ("mm", "inch"),
    "variable_letter": TEXT,
    "whole_numbers": ("as written", "least increment"),
}
SINUMERIK: dict[str, Kind] = {
    **dict.fromkeys(("arc_radii_mm", "arc_radii_percent"), NUMBER),
    "base_unit": ("program", "mm", "inch"),
    "feed_turning": TURNING,
    "strict_cycles": SWITCH,
    "toframe_mode": ("2000", "2001", "2002"),
}
HEIDENHAIN: dict[str, Kind] = {
    "arc_radii_mm": NUMBER,
    "builder_functions": ("ignored", "refused"),
    "cycle_11_axes": ("all", "plane"),
    "cycle_19_angles": ("spatial", "axes"),
    "feed_when_turning": TURNING,
    "inch_feed": ("header", "tenth", "inch"),
    "part_frame_where_switched": SWITCH,
    "shortest_rotary": SWITCH,
}
OPTIONS: dict[str, dict[str, Kind]] = {
    "word-address": WORD_ADDRESS,
    "sinumerik": SINUMERIK,
    "heidenhain": HEIDENHAIN,
}
OF_WORDS = "_means"
"""Ending of options of Klartext that are a sentence on a word: M92_means."""
FOLDER = Path(__file__).parent / "builtin"
LANGUAGES = ("word-address", "sinumerik", "heidenhain")
Option = TypeVar("Option", bool, float, str)
LONGEST = 1 << 20
"""Most characters of a controller's file."""


def fault(language: str, name: str, value: bool | float | str) -> str:
    """What is wrong with an option, and the cure; empty where nothing is."""
    allowed = OPTIONS[language]
    if language == "heidenhain" and name.endswith(OF_WORDS):
        kind: Kind | None = TEXT
    else:
        kind = allowed.get(name)
    said = f"option {name[:40]} = {f'{value:g}' if type(value) is float else repr(value)[:40]}"
    if kind is None:
        return f"option {name[:40]} is not known: {did_you_mean(name[:40], sorted(allowed))}"
    if isinstance(kind, tuple):
        if value in kind:
            return ""
        return f"{said}: use one of {', '.join(map(repr, kind))}"
    if isinstance(kind, float) and isinstance(value, int | float) and not isinstance(value, bool):
        return "" if 0.0 <= value <= MOST else f"{said} must be from 0 to {MOST:g}: correct it"
    if type(value) is not type(kind):
        return f"{said} must be {_KINDS[type(kind)]}"
    return ""


_KINDS = {bool: "true or false", float: "a number", str: "a text"}


class Sign(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Something in a program that tells its controller."""

    pattern: str
    """Regular expression, matched line by line, in capitals."""
    reason: str
    """What it is, in words: "G43.4 is Fanuc's tool-centre-point mode"."""
    comments: bool = False
    """Whether it is looked for in comments too, as what a post says of itself."""
    weight: float = 1.0


class Controller(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What differs from controller to controller of one language."""

    name: str
    language: str = ""
    """How its programs are written; may be left out where it is like another."""
    like: str = ""
    """A built-in controller whose words and options hold where this file says nothing; its signs are this one's too."""
    note: str = ""
    suffixes: tuple[str, ...] = ()
    """Endings of names that tell it, where nothing in the program does: ".mpf"."""
    signs: tuple[Sign, ...] = ()
    meanings: dict[str, str] = {}
    """Word (G43.4, M6, TRAORI) to what it does: a name that the language knows, such as "tip mode on"."""
    ignored: tuple[str, ...] = ()
    """Words that move nothing: they are counted."""
    refused: dict[str, str] = {}
    """Words that may move something and are not read, with the cure."""
    options: dict[str, bool | float | str] = {}
    """What else differs: names that the language knows."""
    tools: tuple[ToolRule, ...] = ()
    """How names of tools and comments tell the shapes of tools."""
    time: dict[str, bool | int | float | str | dict[str, float | list[float] | dict[str, float | list[float]]]] = {}
    """How fast it goes through a program: the model that `toolpace time` takes, its figures and their uncertainty."""
    source: str = ""

    @staticmethod
    def names() -> tuple[str, ...]:
        """Names of the built-in controllers."""
        return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))

    @classmethod
    def load(cls, name_or_path: str | Path) -> Controller:
        """A built-in controller by name, or one from a TOML file. Raises UsageError."""
        name = str(name_or_path)
        return _built_in(name) if name in cls.names() else cls.from_toml(cls.text_of(name), name)

    @classmethod
    def text_of(cls, name_or_path: str | Path) -> str:
        """The text of its file, with the comments. Raises UsageError."""
        name = str(name_or_path)
        path = FOLDER / f"{name}.toml" if name in cls.names() else Path(name)
        try:
            with path.open(encoding="utf-8-sig") as stream:
                return stream.read(LONGEST)
        except (OSError, ValueError) as error:
            if path.suffix == ".toml":
                reason = getattr(error, "strerror", None) or "not a text file (UTF-8)"
                raise UsageError(f"controller file {name}: {reason}") from None
            near = did_you_mean(name, cls.names())
            raise UsageError(
                f"controller '{name[:200]}' is not known: {near}; or give the path of a .toml file"
            ) from None

    @classmethod
    def from_toml(cls, text: str, source: str = "controller file") -> Controller:
        """A controller from the text of a file. Raises UsageError."""
        try:
            found = msgspec.toml.decode(text, type=cls)
            with warnings.catch_warnings(action="error", category=FutureWarning):
                for pattern in [*(sign.pattern for sign in found.signs), *(rule.pattern for rule in found.tools)]:
                    re.compile(pattern)
        except (FutureWarning, msgspec.DecodeError, re.error, ValueError, OverflowError, RecursionError) as error:
            cure = "see `toolpace controllers fanuc --toml` for an example"
            unknown = re.search(r"unknown field `(\w{1,40})`", str(error))
            fields = [name for struct in (cls, Sign, ToolRule) for name in struct.__struct_fields__]
            near = f", {did_you_mean(unknown[1], fields)}" if unknown else ""
            raise UsageError(f"{source}: {in_short(error)}{near}; {cure}") from None
        if found.like:
            found = _upon(found, source)
        if found.language not in LANGUAGES:
            raise UsageError(
                f"{source}: language '{found.language[:40]}' is not known: use one of {', '.join(LANGUAGES)}"
            )
        for wrong in filter(None, (rule.fault() for rule in found.tools)):
            raise UsageError(f"{source}: {wrong}")
        for name, value in found.options.items():
            if wrong := fault(found.language, name, value):
                raise UsageError(f"{source}: {wrong}")
        return msgspec.structs.replace(found, source=source)

    def to_toml(self) -> str:
        """The text of a file that loads to this controller, with all that it has from the one that it is like."""
        fields = {
            key: value for key, value in msgspec.to_builtins(self).items() if value and key not in ("source", "like")
        }
        return toml_text(fields)

    def option(self, name: str, default: Option) -> Option:
        """The option, or the default, which is of its kind."""
        value = self.options.get(name, default)
        if isinstance(default, float):
            value = float(value)
        assert isinstance(value, type(default)), name
        return value


@functools.cache
def _built_in(name: str) -> Controller:
    """A built-in controller, which is frozen, made once of its file."""
    return Controller.from_toml(Controller.text_of(name), name)


def _upon(own: Controller, source: str) -> Controller:
    """The controller with all that the one it is like has, and it does not say itself. Raises UsageError."""
    if own.like not in Controller.names() or own.like == own.name:
        others = [name for name in Controller.names() if name != own.name]
        raise UsageError(
            f"{source}: like = '{own.like[:40]}' is no built-in controller; {did_you_mean(own.like, others)}"
        )
    base = Controller.load(own.like)
    if own.language not in ("", base.language):
        raise UsageError(f"{source}: language '{own.language[:40]}' is not that of {base.name}; leave the line out")
    said = {*own.meanings, *own.ignored, *own.refused}
    return msgspec.structs.replace(
        own,
        language=base.language,
        signs=(*base.signs, *own.signs),
        tools=(*own.tools, *base.tools),
        meanings={word: meaning for word, meaning in base.meanings.items() if word not in said} | own.meanings,
        ignored=(*(word for word in base.ignored if word not in said), *own.ignored),
        refused={word: cure for word, cure in base.refused.items() if word not in said} | own.refused,
        options=base.options | own.options,
        time=base.time | own.time,
    )
