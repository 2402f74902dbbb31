"""Text: numbers in messages, percentages, numbers that people type, summaries of errors."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core.text import counted, parse_float, parse_int, percent, summarize_error


@pytest.mark.parametrize(
    ("number", "noun", "expected"),
    [
        (1, "pinch", "1 pinch"),
        (0, "pinch", "0 pinches"),
        (2, "stretch", "2 stretches"),
        (2, "epoch", "2 epochs"),
        (1200, "WAV file", "1,200 WAV files"),
        (2, "policy", "2 policies"),
        (2, "day", "2 days"),
        (3, "Shore A level", "3 Shore A levels"),
    ],
)
def test_one_is_singular(number, noun, expected):
    assert counted(number, noun) == expected


@pytest.mark.parametrize(
    ("share", "decimals", "expected"),
    [
        (1.0, 1, "100.0 %"),
        (0.972, 1, "97.2 %"),
        (0.99966, 1, "99.97 %"),
        (0.99999, 1, "99.99 %"),
        (0.996, 0, "99.6 %"),
        (0.4, 0, "40 %"),
        (1.2, 0, "120 %"),
    ],
)
def test_percent_has_useful_decimals(share, decimals, expected):
    assert percent(share, decimals) == expected


@given(st.floats(0, 1, exclude_max=True), st.integers(0, 2))
def test_percent_is_never_rounded_up_to_100(share, decimals):
    text = percent(share, decimals)
    assert float(text.removesuffix(" %")) < 100
    assert len(text) <= len("99.99 %")


@pytest.mark.parametrize(
    ("text", "value"), [("1", 1.0), (" -2.5 ", -2.5), ("+.5e-3", 5e-4), ("1e-05", 1e-5)]
)
def test_plain_numbers(text, value):
    assert parse_float(text) == value


@pytest.mark.parametrize("text", ["1_0", "1_000.5", "１２", "٣", "", " ", "0x10", "1,5", "9_9e1"])
def test_ambiguous_numbers_are_refused(text):
    for parse in (parse_float, parse_int):
        with pytest.raises(ValueError, match="which is not a"):
            parse(text)


@pytest.mark.parametrize("text", ["nan", "inf", "-Infinity", "1e999"])
def test_infinity_is_refused_by_default(text):
    with pytest.raises(ValueError, match="finite"):
        parse_float(text)
    assert str(parse_float(text, finite=False)) in ("nan", "inf", "-inf")


def test_errors_are_summarized_in_one_line():
    assert summarize_error(ValueError("a\n  b")) == "ValueError: a b"
    assert summarize_error(SystemExit()) == "SystemExit"
