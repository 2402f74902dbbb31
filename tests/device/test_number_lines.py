"""Tests of lines of numbers: complete lines are read, and no input causes an error."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.device._number_lines import LineReader


@settings(max_examples=60)
@given(st.lists(st.binary(max_size=200), max_size=20))
def test_any_bytes_give_finite_numbers_or_none(pieces: list[bytes]) -> None:
    reader = LineReader()
    for piece in pieces:
        for line in reader.feed(piece):
            assert line is None or all(abs(v) < float("inf") for v in line)


@settings(max_examples=60)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=40))
def test_reads_split_anywhere_give_the_same_lines(sizes: list[int]) -> None:
    text = b"junk\nn,piezo\r\n" + b"".join(b"%d,%d\r\n" % (k, k * k % 97) for k in range(60))
    expected = LineReader().feed(text)
    reader, parts, place = LineReader(), [], 0
    while place < len(text):
        size = sizes[place % len(sizes)]
        parts += reader.feed(text[place : place + size])
        place += size
    assert parts == expected
    assert reader.header == ("n", "piezo")
    assert [line for line in parts if line] == [(float(k), float(k * k % 97)) for k in range(60)]


def test_plotter_lines_have_names() -> None:
    reader = LineReader()
    assert reader.feed(b"x\nleft:1,right:2\n") == [(1.0, 2.0)]
    assert reader.header == ("left", "right")


def test_python_only_number_formats_are_damaged_lines() -> None:
    reader = LineReader()
    assert reader.feed("x\n1,1_0\n１,2\n1,2\n".encode()) == [None, None, (1.0, 2.0)]
    assert reader.bad == 2
