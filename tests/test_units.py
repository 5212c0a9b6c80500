from __future__ import annotations

import math

import pytest

from toolpace.common import units
from toolpace.common.errors import UsageError


@pytest.mark.parametrize(
    ("parse", "text", "value"),
    [
        (units.parse_length, "0.01mm", 1e-5),
        (units.parse_length, "1in", 0.0254),
        (units.parse_length, " 10 um ", 1e-5),
        (units.parse_length, "10µm", 1e-5),
        (units.parse_length, "0mm", 0.0),
        (units.parse_angle, "0.05deg", math.radians(0.05)),
        (units.parse_angle, "1e-3rad", 1e-3),
        (units.parse_time, "1ms", 1e-3),
        (units.parse_time, "2 min", 120.0),
        (units.parse_feed, "3000mm/min", 0.05),
        (units.parse_feed, "120in/min", 120 * 0.0254 / 60),
        (units.parse_feed, "50MM/S", 0.05),
        (units.parse_percent, "120%", 1.2),
    ],
)
def test_parses_what_people_type(parse, text, value):
    assert parse(text) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("parse", "text", "says"),
    [
        (units.parse_length, "0.01", "has no unit: write it like 0.01mm"),
        (units.parse_length, "thick", "is not a length"),
        (units.parse_length, "", "is not a length"),
        (units.parse_length, "nanmm", "is not a length"),
        (units.parse_length, "1furlong", "use one of um, mm, cm, m, in, inch"),
        (units.parse_length, "-1mm", "must be zero or more"),
        (units.parse_length, "1e999mm", "finite"),
        (units.parse_angle, "5mm", "'mm' is not a unit of angle"),
        (units.parse_time, "0s", "must be above zero"),
        (units.parse_feed, "0mm/min", "must be above zero"),
        (units.parse_feed, "300", "like 3000mm/min"),
    ],
)
def test_says_what_to_type_instead(parse, text, says):
    with pytest.raises(UsageError, match=r"^[^\n]*$") as caught:
        parse(text)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (units.format_time(1078.7), "17 min 58.7 s"),
        (units.format_time(3.608), "3.61 s"),
        (units.format_time(0.0123), "12.3 ms"),
        (units.format_time(59.999), "1 min 00.0 s"),
        (units.format_time(3599.97), "1 h 00 min 00 s"),
        (units.format_time(3723.4), "1 h 02 min 03 s"),
        (units.format_time(math.inf), "inf"),
        (units.format_figure(999.4), "999"),
        (units.format_figure(3241.7), "3242"),
        (units.format_figure(0.01234), "0.0123"),
        (units.format_length(0.0123456), "12.3456 mm"),
        (units.format_length(3.2e-6), "3.2 µm"),
        (units.format_length(0.0), "0 mm"),
        (units.format_angle(math.pi / 2), "90 deg"),
        (units.format_angle(1e-8), "5.73e-07 deg"),
    ],
)
def test_shows_what_people_read(text, shown):
    assert text == shown
