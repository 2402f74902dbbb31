"""Text: numbers in messages, percentages, numbers that people type, summaries of errors."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core.text import counted, parse_float, parse_int, percent, summarize_error


@pytest.mark.parametrize("expected", ["1 pinch", "0 pinches", "2 stretches", "2 epochs", "2 days"])
def test_one_is_singular(expected):
    number, noun = expected.split()
    singular = noun.removesuffix("s") if noun in ("epochs", "days") else noun.removesuffix("es")
    assert counted(int(number), singular) == expected


def test_nouns_in_y_and_large_numbers():
    assert counted(2, "policy") == "2 policies"
    assert counted(1200, "WAV file") == "1,200 WAV files"


def test_percent_has_useful_decimals():
    shares = [(1.0, 1), (0.972, 1), (0.99966, 1), (0.99999, 1), (0.996, 0), (0.4, 0), (1.2, 0)]
    expected = "100.0 %, 97.2 %, 99.97 %, 99.99 %, 99.6 %, 40 %, 120 %"
    assert ", ".join(percent(*share) for share in shares) == expected


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
