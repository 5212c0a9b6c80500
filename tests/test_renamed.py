"""Names of the release before still work, and say what they are called now."""

from __future__ import annotations

import pytest

import toolpace as tp


@pytest.mark.parametrize(
    "old, new",
    [
        ("AimedOff", "BendingCompensation"), ("Haste", "SpeedWeights"), ("aim_off", "compensate_bending"),
        ("deflect", "deflection"),
    ],
)  # fmt: skip
def test_an_old_name_is_the_new_object_and_warns(old: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"toolpace.{old} is called toolpace.{new} now"):
        assert getattr(tp, old) is getattr(tp, new)
    assert old not in tp.__all__ and new in tp.__all__
