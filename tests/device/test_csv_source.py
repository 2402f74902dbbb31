"""Tests of boards that print numbers, over a real pseudo terminal, and of their lines."""

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from printing_board import PrintingBoard

from firstcontact.core import InputError
from firstcontact.device import Arrival, csv_source
from firstcontact.device.columns import identify_columns
from firstcontact.device.csv_source import CsvSource, from_name
from firstcontact.device.lines import LineReader
from firstcontact.device.opening import SourceOptions, source_kind

MEASURED = 0.6
#: Longest time until trouble is reported, s: one to three, and what a busy machine adds.
SOON = 20.0
SAME = csv_source.is_same_rate


@pytest.fixture(autouse=True)
def _busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take any measured rate as the nominal one, because a busy machine measures a rate poorly.

    At another rate samples are filtered, and each gap costs more samples than the board lost.
    """
    monkeypatch.setattr(csv_source, "is_same_rate", lambda rate, other: True)


@pytest.fixture
def _measured_rate(_busy_machine: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the measured rate, as users do."""
    monkeypatch.setattr(csv_source, "is_same_rate", SAME)


def until(source: CsvSource, is_sufficient: Callable[[list[Arrival]], bool]) -> list[Arrival]:
    arrivals: list[Arrival] = []
    while not is_sufficient(arrivals):
        arrivals += source.read(5.0)
    return arrivals


def samples(n: int) -> Callable[[list[Arrival]], bool]:
    return lambda arrivals: sum(len(a.block.data) for a in arrivals) >= n


def numbered_line(number: int) -> bytes:
    return b"%d,%d,%d\r\n" % (number, 512 + number % 7, number % 1000)


@contextmanager
def reading(
    folder: Path, line: Callable[[int], bytes], columns: tuple[str, ...] = ("2",)
) -> Iterator[tuple[PrintingBoard, CsvSource]]:
    """Run a board that prints lines, and a source that reads it."""
    with (
        PrintingBoard(folder / "port", line) as board,
        CsvSource(board.port, columns, measured=MEASURED) as source,
    ):
        yield board, source


class Trouble:
    """Trouble of a board that begins only once its source is open, however busy the machine is."""

    def __init__(self) -> None:
        self._begins = False
        self._start = sys.maxsize

    def begin(self) -> None:
        """Begin some lines after the next one that the board prints."""
        self._begins = True

    def lines_since(self, number: int) -> int:
        """Return the number of lines since the trouble began. It is negative before that.

        The board calls it for each line, in its own thread, so no line is printed meanwhile.
        """
        if self._begins:
            self._begins, self._start = False, number + 500
        return number - self._start


def test_counter_column_is_detected_and_reveals_losses(tmp_path: Path) -> None:
    trouble, lost_lines = Trouble(), {*range(13), 1000}

    def line(number: int) -> bytes:
        return b"" if trouble.lines_since(number) in lost_lines else numbered_line(number)

    with reading(tmp_path, line) as (_, source):
        trouble.begin()
        arrivals = until(source, lambda _: source.health.lost_samples >= len(lost_lines))
        arrivals += until(source, samples(100))
    assert source.health.lost_samples == len(lost_lines)
    values = np.concatenate([a.block.data for a in arrivals])[:, 0]
    numbers = np.concatenate([np.arange(a.block.first_sample, a.block.end) for a in arrivals])
    # Every sample is where the board counted it: what it printed follows from its number.
    shift = {(int(v) - 512 - int(n)) % 7 for v, n in zip(values, numbers, strict=True)}
    assert len(shift) == 1


def test_losses_are_unknown_without_a_counter(tmp_path: Path) -> None:
    with reading(tmp_path, lambda n: b"%d\n" % (n % 300 * (n % 3)), ()) as (_, source):
        until(source, samples(100))
    assert not source.health.losses_known


@pytest.mark.parametrize(
    "damaged",
    [
        (b"\xff\xfe12,,x", b"N,", b"12\x0034"),
        (b"1e300,512,0", b"99N,512,0", b"-3,512,0", b"7,512,0"),
    ],
    ids=["words", "counts"],
)
def test_damaged_line_costs_one_sample_and_starts_no_epoch(
    damaged: Sequence[bytes], tmp_path: Path
) -> None:
    trouble = Trouble()

    def line(number: int) -> bytes:
        number += 100_000  # far from 65,536, where a count of 7 would be a wrap
        place, lines_after = divmod(trouble.lines_since(number), 400)
        if lines_after == 0 and 0 <= place < len(damaged):
            return damaged[place].replace(b"N", b"%d" % number) + b"\n"
        return numbered_line(number)

    with reading(tmp_path, line) as (_, source):
        trouble.begin()
        arrivals = until(source, lambda _: source.health.lost_samples >= len(damaged))
    assert {a.block.epoch for a in arrivals} == {0}
    assert source.health.bad_frames == source.health.lost_samples == len(damaged)


def test_reset_starts_an_epoch_after_its_header(tmp_path: Path) -> None:
    trouble = Trouble()

    def line(number: int) -> bytes:
        since = trouble.lines_since(number)
        head = b"123n,piezo,ramp\r\n" if since == 0 else b""
        return head + numbered_line(number if since < 0 else since)

    with reading(tmp_path, line) as (_, source):
        arrivals = until(source, samples(10))
        trouble.begin()
        arrivals += until(source, lambda arrivals: any(a.block.epoch == 1 for a in arrivals))
    assert {a.block.epoch for a in arrivals} == {0, 1}
    assert source.health.reconnects == 1
    # Lost are the line that the reset cut, and the first line that counts back: only the next one
    # proves the reset.
    assert source.health.lost_samples == source.health.bad_frames == 2


def test_reconnected_port_continues_in_another_epoch(tmp_path: Path) -> None:
    def line(number: int) -> bytes:
        return b"noise\xff\n" if number % 400 == 399 else numbered_line(number)

    with reading(tmp_path, line) as (board, source):
        until(source, lambda _: source.health.bad_frames > 1)
        bad_frames = source.health.bad_frames
        board.unplug()
        while source.health.connected:
            source.read(0.05)
        board.plug()
        arrivals = until(
            source,
            lambda arrivals_so_far: bool(arrivals_so_far) and arrivals_so_far[-1].block.epoch == 1,
        )
        assert source.health.connected
        assert source.health.bad_frames >= bad_frames
    assert len(arrivals[-1].block.data)


@pytest.mark.usefixtures("_measured_rate")
@pytest.mark.parametrize(
    ("line", "rate", "columns", "problem"),
    [
        (lambda n: b"hello world 1\n", 4936.0, (), "csv:PORT@BAUD"),
        (lambda n: bytes([n % 251]) * 3, 4936.0, (), "csv:PORT@BAUD"),
        (numbered_line, 4936.0, ("5",), "'5'.*1, 2, 3"),
        (numbered_line, 200.0, ("2",), r"\b500\b"),
    ],
    ids=["words", "bytes", "column", "slow"],
)
def test_unusable_board_is_refused(
    line: Callable[[int], bytes],
    rate: float,
    columns: tuple[str, ...],
    problem: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if problem == "csv:PORT@BAUD":  # no line of numbers ever comes
        monkeypatch.setattr(csv_source, "PATIENCE", 0.5)
    with (
        PrintingBoard(tmp_path / "port", line, rate) as board,
        pytest.raises(InputError, match=problem),
    ):
        CsvSource(board.port, columns, measured=MEASURED).__enter__()


@pytest.mark.usefixtures("_measured_rate")
def test_other_rate_is_measured_and_resampled(tmp_path: Path) -> None:
    with (
        PrintingBoard(tmp_path / "port", numbered_line, rate=2000.0) as board,
        CsvSource(board.port, ("2",)) as source,
    ):
        assert float(source.descriptor.firmware.split()[3]) == pytest.approx(2000.0, rel=0.2)
        until(source, samples(1000))
        assert 0 < source.descriptor.delay <= 0.0005


def test_device_name_has_port_baud_and_columns() -> None:
    source = from_name("csv:/dev/ttyUSB0@230400#a,b", SourceOptions())
    assert (source.port, source.baud, source.named) == ("/dev/ttyUSB0", 230400, ("a", "b"))
    assert source_kind("csv:/dev/ttyUSB0").name == "csv"
    with pytest.raises(InputError, match="csv:"):
        from_name("csv:", SourceOptions())
    for baud in ("0", "fast", "9" * 20):
        with pytest.raises(InputError, match="@"):
            from_name(f"csv:/dev/ttyUSB0@{baud}", SourceOptions())
    with pytest.raises(InputError, match="none"):
        CsvSource("/dev/none").__enter__()


def test_counter_that_runs_back_is_reported_and_counted(tmp_path: Path) -> None:
    trouble = Trouble()

    def line(number: int) -> bytes:
        return numbered_line(number - 2 * max(trouble.lines_since(number), 0))

    with reading(tmp_path, line) as (board, source):
        opened, began = board.printed, time.monotonic()
        until(source, samples(2000))
        trouble.begin()
        while source.health.connected:
            source.read(0.05)
        assert time.monotonic() - began < SOON
        # All that the board printed since the source was opened is counted sooner or later.
        printed = board.printed
        until(source, lambda _: counted(source) >= printed - opened)
        assert counted(source) <= board.printed
        assert source.health.lost_samples > 4000


def counted(source: CsvSource) -> int:
    """Return the number of samples that were received or lost."""
    return source.health.samples + source.health.lost_samples


@pytest.mark.parametrize(
    ("header", "wanted", "counting", "counter", "signals"),
    [
        (("index", "thumb"), (), None, None, (0, 1)),
        (("index", "thumb"), (), 0, 0, (1,)),
        (("Index", "n", "Thumb"), (), 1, 1, (0, 2)),
        (("index", "piezo"), ("index", "piezo"), None, None, (0, 1)),
        (("index", "piezo"), (), 0, 0, (1,)),
        (("index", "n", "piezo"), ("1",), 1, 1, (0,)),
        (("n", "index"), ("n", "index"), None, None, (1, 0)),
        (("thumb", "index"), (), None, None, (1, 0)),
        (("thumb", "ms", "n", "piezo"), (), 2, 2, (3, 0)),
        (("n", "a", "a"), ("3", "a 2"), 0, 0, (2, 1)),
        ((), ("1", "2"), None, None, (0, 1)),
        ((), ("1", "2"), 0, None, (0, 1)),
        ((), (), 0, 0, (1,)),
    ],
)
def test_columns_are_identified(
    header: tuple[str, ...],
    wanted: tuple[str, ...],
    counting: int | None,
    counter: int | None,
    signals: tuple[int, ...],
) -> None:
    width = len(header) or 2
    lines = [tuple(float(n if k == counting else n % 3) for k in range(width)) for n in range(30)]
    columns = identify_columns(lines, header, wanted, "csv:port")
    assert (columns.counter, columns.signals) == (counter, signals)


COUNTED = [(float(n), 1.0, 2.0) for n in range(30)]


@pytest.mark.parametrize(
    ("lines", "header", "wanted", "problem"),
    [
        *((COUNTED, ("n", "a", "a"), (w,), "n, a 2, a 3") for w in ("9" * 5000, "0", "-1", "a")),
        (COUNTED, ("n", "a", "a"), ("\u0663",), "n, a 2, a 3"),
        (COUNTED, ("n", "a", "a"), ("2", "2"), "n, a 2, a 3"),
        ([(1.0, 2.0, 3.0)] * 30, (), (), "csv:port#1"),
        ([(1.0, 2.0), (1.0,)] * 15, (), (), "1 to 2 numbers"),
        ([(-n, 5.0, 1.0) for n, *_ in COUNTED], ("count", "piezo", "x"), ("piezo",), "'count'"),
        ([(1e300, n, 1.0) for n, *_ in COUNTED], ("count", "piezo", "x"), ("piezo",), "'count'"),
        ([(5.0, n % 3) for n, *_ in COUNTED], ("index", "piezo"), (), r"'index'.*#index"),
    ],
)
def test_unclear_columns_are_refused(
    lines: list[tuple[float, ...]], header: tuple[str, ...], wanted: tuple[str, ...], problem: str
) -> None:
    with pytest.raises(InputError, match=problem):
        identify_columns(lines, header, wanted, "csv:port")


def test_arrivals_after_a_pause_are_ignored() -> None:
    arrivals = csv_source.SteadyArrivals(0.5)
    for k in range(1, 300):
        age = 0.01 * k + (0.4 if k > 80 else 0.0)
        arrivals.add(age, 20 * k - (500 if k > 80 else 0))  # the pause lost 500 lines
    assert arrivals.rate() == pytest.approx(2000.0, rel=1e-6)


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


@pytest.mark.parametrize(
    "text", [b"# 23.5 C, battery 3.71 V", b"overrun? no", b"vbat=3.71", b"vbat:3.71", b"23.5 degC"]
)
def test_lines_of_text_are_no_samples(text: bytes) -> None:
    reader = LineReader()
    lines = reader.feed(b"\n1\n2\n" + text + b"\n3\n4x\n5\n")
    assert lines == [(1.0,), (2.0,), (3.0,), None, (5.0,)]
    assert reader.bad == 1


def test_names_before_numbers_are_columns() -> None:
    reader = LineReader()
    assert reader.feed(b"\n" + b"piezo:5,force:7\n" * 3) == [(5.0, 7.0)] * 2
    assert reader.header == ("piezo", "force")


@pytest.mark.parametrize("clock", [lambda n: 203 * n + n % 3, lambda n: n // 5], ids=["us", "ms"])
def test_a_clock_is_left_out_and_counted_steps_are_one(
    clock: Callable[[int], int], caplog: pytest.LogCaptureFixture
) -> None:
    lines = [(clock(n), 512.0 + n % 3, 4.0 * n % 1000) for n in range(900)]
    found = identify_columns(lines, ("when", "piezo", "n"), (), "csv:port")
    assert (found.signals, found.counter, found.step) == ((1,), 2, 4.0)
    assert "when" in caplog.text
    counter = csv_source.SampleCounter(found)
    assert [counter.next(line, 0) for line in lines] == list(range(900))  # wraps at 1000


@pytest.mark.parametrize(
    ("name", "line", "scale"),
    [
        ("", lambda n: b"%d\n" % (512 + n % 7), 3.3 / 1024),
        ("", lambda n: b"%d\n" % (2048 + n % 7), 1.0),
        ("=12bits", lambda n: b"%d\n" % (2048 + n % 7), 3.3 / 4096),
        ("=mV", lambda n: b"%d\n" % (n % 7 - 3), 1e-3),
    ],
)
def test_a_unit_is_stated_or_assumed(
    name: str, line: Callable[[int], bytes], scale: float, tmp_path: Path
) -> None:
    with PrintingBoard(tmp_path / "port", line) as board:
        with from_name(f"csv:{board.port}{name}", SourceOptions()) as source:
            (channel,) = source.descriptor.layout.channels
        assert channel.scale == pytest.approx(scale)
        assert channel.unit == ("counts" if scale == 1.0 else "V")
        with pytest.raises(InputError, match="bits"):
            from_name(f"csv:{board.port}=2bits", SourceOptions()).__enter__()


@pytest.mark.parametrize("every", [5, 1000])
def test_columns_that_change_places_are_refused(tmp_path: Path, every: int) -> None:
    names = [b"force,piezo"]

    def line(number: int) -> bytes:
        head = names[0] + b"\n" if number % every == 0 else b""
        return head + b"%d,%d\n" % (512 + number % 7, 512 + number % 5)

    with reading(tmp_path, line, ("piezo",)) as (board, source):
        until(source, samples(100))
        board.unplug()
        while source.health.connected:
            source.read(0.05)
        names[0] = b"piezo,force"
        board.plug()
        with pytest.raises(InputError, match="other columns"):
            until(source, lambda _: False)


def test_a_port_that_comes_back_under_another_name_is_named(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with (
        PrintingBoard(tmp_path / "ttyACM0", numbered_line) as board,
        CsvSource(board.port, ("2",), measured=MEASURED) as source,
    ):
        until(source, samples(100))
        board.unplug()
        board.link = tmp_path / "ttyACM1"
        board.plug()
        while "by-id" not in caplog.text:
            source.read(0.05)
    assert str(tmp_path / "ttyACM1") in caplog.text


@pytest.mark.parametrize(
    ("start", "text", "damaged"),
    [
        (b"512,500", b"None,501\novf,502.0\nMAX 503", 2),
        (b"index,thumb\n512,500", b"READY\nx: 5\nSensor ready, ok now\n512,ovf", 1),
        (b"a:1,b:2\na:1,b:2", b"x:1,b:2\na:1,b:2\na:ovf,b:2\na:1,:2\nlow battery", 3),
        (b"512 500", b"Done\nlow battery now\nNone 501", 1),
    ],
    ids=["words", "status", "plotter", "spaces"],
)
def test_a_sample_with_a_word_is_lost_and_a_status_changes_no_header(
    start: bytes, text: bytes, damaged: int
) -> None:
    reader = LineReader()
    reader.feed(b"\n" + start + b"\n")
    header = reader.header
    lines = reader.feed(text + b"\n")
    assert (lines.count(None), reader.bad, reader.header) == (damaged, damaged, header)


def came_back(lines: list[tuple[float, ...]]) -> CsvSource:
    """Check columns n and piezo after a new start, in which a board printed this."""
    source = CsvSource("port")
    source._header = ("n", "piezo")
    source._columns = csv_source.Columns(("piezo",), (1,), 0, 2)
    source._check_columns(lines)
    return source


def test_hum_is_no_other_columns() -> None:
    for shift in range(50):
        angles = [2 * math.pi * (50 * n / 4936 + shift / 50) for n in range(20)]
        lines = [(float(n), 512.0 + round(16 * math.sin(a))) for n, a in enumerate(angles)]
        came_back(lines)
    came_back([])
    for other in ([(1.0, 2.0, 3.0)] * 20, [(5.0, float(n)) for n in range(20)]):
        with pytest.raises(InputError, match="other columns"):
            came_back(other)


def test_numbers_beyond_assumed_bits_end_the_session() -> None:
    source = came_back([])
    source._units = [csv_source.COUNTS]
    with pytest.raises(InputError, match="=12bits"):
        source._give_lines([(0.0, 620.0), (1.0, 1030.0), (2.0, 1100.0)], [0, 1, 2], 0, 0.0)
