"""The options of controller files, by language.

What an option does is told where it is read, and in the built-in files; a test holds both sides together.
"""

from __future__ import annotations

from toolpace.common.errors import did_you_mean

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
            *("offsets_are_absolute", "offsets_turn", "rapids_vary", "reference_without_axes_is_all"),
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


def fault(language: str, name: str, value: bool | float | str) -> str:
    """What is wrong with an option, and the cure; empty where nothing is."""
    known = OPTIONS[language]
    if language == "heidenhain" and name.endswith(OF_WORDS):
        kind: Kind | None = TEXT
    else:
        kind = known.get(name)
    said = f"option {name[:40]} = {f'{value:g}' if type(value) is float else repr(value)[:40]}"
    if kind is None:
        return f"option {name[:40]} is not known: {did_you_mean(name[:40], sorted(known))}"
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
