"""Numbers in text: plain notation is accepted, Python's extensions are refused."""

from __future__ import annotations

import pytest

from firstcontact.core import parse_float, parse_int


@pytest.mark.parametrize(
    ("text", "value"), [("1", 1.0), (" -2.5 ", -2.5), ("+.5e-3", 5e-4), ("1e-05", 1e-5)]
)
def test_plain_numbers(text: str, value: float) -> None:
    assert parse_float(text) == value


def test_whole_numbers_are_exact() -> None:
    assert parse_int(str(2**63 + 1)) == 2**63 + 1


@pytest.mark.parametrize("text", ["1_0", "1_000.5", "１２", "٣", "", " ", "0x10", "1,5", "9_9e1"])
def test_ambiguous_numbers_are_refused(text: str) -> None:
    for parse in (parse_float, parse_int):
        with pytest.raises(ValueError, match="which is not a"):
            parse(text)


@pytest.mark.parametrize("text", ["nan", "inf", "-Infinity", "1e999"])
def test_infinity_is_refused_by_default(text: str) -> None:
    with pytest.raises(ValueError, match="finite"):
        parse_float(text)
    assert str(parse_float(text, finite=False)) in ("nan", "inf", "-inf")
