"""What a reader passes over, takes for granted and refuses."""

from __future__ import annotations

import pytest

from toolpace.common.errors import ProgramError
from toolpace.programs.reading.findings import MOST_LISTED, Findings, Refusal
from toolpace.programs.reading.source import Source

SOURCE = Source.from_text("one\ntwo\nthree\n", "part.apt")


def test_ignored_words_are_counted_and_sentences_said_once():
    findings = Findings()
    for word in ("PAINT", "SET", "PAINT"):
        findings.ignored(word)
    for sentence in ("b", "a", "b"):
        findings.assumed(sentence)
    assert findings.skipped == {"PAINT": 2, "SET": 1} and findings.assumptions == ("b", "a")
    findings.raise_if_refused(SOURCE)


def test_refusals_are_grouped_by_word_in_the_order_of_their_first_lines():
    findings = Findings()
    findings.refused("G68", 3, "remove it")
    findings.refused("G51", 2, "scale it in the CAM system")
    findings.refused("G68", 1, "another cure")
    assert findings.refusals == (
        Refusal("G68", 1, 2, "remove it"),
        Refusal("G51", 2, 1, "scale it in the CAM system"),
    )
    with pytest.raises(ProgramError) as caught:
        findings.raise_if_refused(SOURCE)
    assert str(caught.value) == (
        "part.apt: 2 kinds of words are not read: G68 (first line 1, 2 times): remove it; "
        "G51 (first line 2): scale it in the CAM system"
    )


def test_one_kind_is_told_at_its_line():
    findings = Findings()
    findings.refused("G68", 2, "remove it")
    with pytest.raises(ProgramError) as caught:
        findings.raise_if_refused(SOURCE)
    assert str(caught.value) == "part.apt:2: G68 is not read: remove it in 'two'"
    findings.refused("G68", 3, "remove it")
    with pytest.raises(ProgramError, match=r"^part\.apt:2: .*\(it stands 2 times\)"):
        findings.raise_if_refused(SOURCE)


def test_skipped_refusals_become_assumptions():
    findings = Findings()
    findings.refused("G68", 2, "remove it")
    findings.refused("G51", 3, "remove it")
    findings.refused("G51", 3, "remove it")
    findings.raise_if_refused(SOURCE, skip_unknown=True)
    assert findings.assumptions == ("skipped G68 (first line 2, 1 time)", "skipped G51 (first line 3, 2 times)")


def test_a_file_of_too_many_kinds_is_told_in_a_message_of_bounded_length():
    findings = Findings()
    for number in range(MOST_LISTED + 5):
        findings.refused(f"W{number}", number, "remove it")
    with pytest.raises(ProgramError, match=f"{MOST_LISTED + 5} kinds.*; and 5 more$"):
        findings.raise_if_refused(SOURCE)


def test_what_is_found_can_be_printed():
    findings = Findings()
    findings.ignored("PAINT\x1b")
    findings.assumed("tool \u2028 is long")
    findings.refused("FEDRAT/\x1a", 1, "remove it")
    assert [*findings.skipped, *findings.assumptions, *(each.word for each in findings.refusals)] == [
        "PAINT\\x1b", "tool \\u2028 is long", "FEDRAT/\\x1a",
    ]  # fmt: skip


def test_long_words_are_cut_short():
    findings = Findings()
    findings.ignored("P" * 5000)
    findings.refused("Q" * 5000, 1, "remove it")
    assert list(findings.skipped) == ["P" * 80 + "..."] and findings.refusals[0].word == "Q" * 80 + "..."


def test_words_with_one_cure_are_listed_together():
    findings = Findings()
    for line, (word, cure) in enumerate([("G7", "remove it"), ("G8", "let it be"), ("G9", "remove it")], start=1):
        findings.refused(word, line, cure)
    with pytest.raises(ProgramError) as caught:
        findings.raise_if_refused(SOURCE)
    assert str(caught.value) == (
        "part.apt: 3 kinds of words are not read: G7 (first line 1), G9 (first line 3): remove it; "
        "G8 (first line 2): let it be"
    )
