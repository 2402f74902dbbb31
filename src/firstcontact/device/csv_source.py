"""Source for boards that print samples as lines of numbers. It measures their sampling rate."""

from __future__ import annotations

import logging
import math
import time
from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import DeviceError, InputError, Layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import is_same_rate
from firstcontact.core.units import COUNTS, STATE_UNIT, Unit, fit_unit, parse_unit, unit_of_name
from firstcontact.device.columns import (
    LEAP,
    Columns,
    counts_up,
    identify_columns,
    vibration_channels,
)
from firstcontact.device.descriptor import Descriptor
from firstcontact.device.lines import LineReader
from firstcontact.device.opening import SourceOptions
from firstcontact.device.ports import LinkError, SerialTransport, reopen
from firstcontact.device.threaded import LONGEST_PAUSE, ThreadedSource
from firstcontact.recording.settings import LOWEST_RATE

_log = logging.getLogger("firstcontact.device")

#: Default baud rate, for boards with a UART. A board with native USB accepts any.
BAUD = 115_200
#: Longest wait for the first lines, s: many boards restart when their port is opened.
PATIENCE = 5.0
#: Time over which the rate is measured before samples are delivered, s.
MEASURED = 2.0
#: A read of this many bytes or more shows a backlog; the system's buffer holds 4096.
BACKLOG = 2048
#: Longest wait of a read, s.
WAIT = 0.02
#: Number of lines that are needed to identify the columns.
LINES_NEEDED = 20


@dataclass(slots=True)
class SampleCounter:
    """Numbering of printed samples, by the column that counts them or else by counting lines.

    ``restarted`` is True if the board's counter started again before the last line.
    """

    columns: Columns
    last: float | None = None
    number: int = -1
    restarted: bool = False
    _doubted: float | None = None

    def next(self, line: tuple[float, ...], damaged: int) -> int | None:
        """Return the sample number of a line that follows ``damaged`` damaged lines.

        Return None if the counter jumps: the next line shows if it restarted or was damaged.
        """
        self.restarted = False
        if (place := self.columns.counter) is None:
            self.number += 1 + damaged
            return self.number
        count, usual = line[place], self.columns.step
        if self.last is None:
            self.last = count - usual
        step = count - self.last
        if step <= 0:
            # A counter near the end of a width has wrapped. Otherwise it has restarted.
            # Signed numbers wrap from half of the width to its negative.
            for wrap in self.columns.wraps:
                for start in (0.0, wrap / 2):
                    if 0.9 * wrap < self.last + start < wrap and 0 <= count + start <= 0.1 * wrap:
                        step = count - self.last + wrap
        if not 0 < step <= LEAP:
            if self._doubted is None or not 0 < count - self._doubted <= LEAP:
                self._doubted = count
                return None
            self.restarted = True
            step = usual
        self.last, self._doubted = count, None
        self.number += max(1, round(step / usual))
        return self.number


class SteadyArrivals:
    """Arrival times of printed lines, from which the rate is measured.

    Arrivals in the first ``lead`` s, and after a pause, are left out: a buffer held these lines.
    """

    def __init__(self, lead: float) -> None:
        self._lead = self._begin = lead
        self._arrivals: list[tuple[float, int]] = []  # time since the opening, lines until then
        self._gaps: list[float] = []
        self._last = 0.0

    def add(self, age: float, lines: int) -> None:
        gap, self._last = age - self._last, age
        if gap > LONGEST_PAUSE:
            if sum(other > 0.5 * gap for other in self._gaps) < 2:
                self._begin = age + self._lead
            self._gaps.append(gap)
        if age > self._lead:
            self._arrivals.append((age, lines))

    @property
    def steady(self) -> list[tuple[float, int]]:
        """Arrivals since the last pause, as (time since the opening in s, lines until then).

        Empty if they cover less than twice ``lead``.
        """
        steady = self._arrivals[bisect_left(self._arrivals, (self._begin, 0)) :]
        return steady if steady and steady[-1][0] - steady[0][0] >= 2.0 * self._lead else []

    def rate(self) -> float:
        """Return the measured rate, lines per second; 0 if too few lines arrived."""
        arrivals = self.steady or self._arrivals
        if len(arrivals) < 3:
            return 0.0
        times, counts = np.array(arrivals).T
        return float(np.polyfit(times, counts, 1)[0])


class CsvSource(ThreadedSource):
    """Source for a board on a serial port that prints its samples as lines of numbers."""

    def __init__(
        self,
        port: str,
        columns: tuple[str, ...] = (),
        baud: int = BAUD,
        rate: float = FINGERTIP_RATE,
        measured: float = MEASURED,
        unit: Unit | None = None,
    ) -> None:
        super().__init__(f"csv:{port}")
        self.port = port
        self.named, self.baud = columns, baud
        self._rate, self._measured = rate, measured
        self._unit, self._units = unit, [COUNTS]
        self._port: SerialTransport | None = None
        self._lines = LineReader()
        self._columns: Columns | None = None
        self._header: tuple[str, ...] = ()

    def _open(self) -> Descriptor:
        self._port = SerialTransport(self.port, self.baud)
        try:
            self._columns, rate = self._identify(self._port)
        except LinkError as error:
            self._shut()
            raise DeviceError(
                f"{self.port} was unplugged while it was opened: plug it in"
            ) from error
        except BaseException:
            self._shut()
            raise
        delay = self._resample(rate, self._rate)
        count = self._columns.counter
        losses = "losses unknown" if count is None else f"counter in column {count + 1}"
        columns = [{"label": f"column {n}"} for n in self._columns.names]
        self._note(losses_known=count is not None)
        return Descriptor(
            Layout(vibration_channels(columns, self._units), self._rate),
            firmware=f"lines of numbers, {rate:.1f} Hz measured, {losses}",
            sensor=f"columns {', '.join(self._columns.names)} of {self.port}",
            source="real",
            dtype="float32",
            delay=delay,
        )

    def _identify(self, port: SerialTransport) -> tuple[Columns, float]:
        opened = began = now = time.monotonic()
        lines: list[tuple[float, ...]] = []
        arrivals = SteadyArrivals(0.25 * self._measured)
        while (
            now - began < self._measured
            or len(lines) < LINES_NEEDED
            or (not arrivals.steady and now - opened < PATIENCE)
        ):
            if len(lines) < LINES_NEEDED and now - opened > PATIENCE:
                raise DeviceError(
                    f"{self.port} sent no lines of numbers in {PATIENCE:g} s ({self._lines.bad} "
                    "lines were not numbers): check that the board prints numbers, and its baud "
                    "rate (csv:PORT@BAUD)"
                )
            new = [line for line in self._lines.feed(port.read(WAIT)) if line]
            now = time.monotonic()
            if new:
                began = began if lines else now  # buffered lines arrive together
                lines += new
                arrivals.add(now - began, len(lines))
        columns = identify_columns(lines, self._lines.header, self.named, self.name)
        self._header = self._lines.header if len(self._lines.header) == columns.width else ()
        rate = arrivals.rate()
        if columns.counter is not None:
            complete_lines = [n for n in lines if len(n) == columns.width]
            steps = np.diff([n[columns.counter] for n in complete_lines]) / columns.step
            steps = steps[(steps > 0) & (steps <= LEAP)]
            rate *= max(1.0, float(steps.mean())) if len(steps) else 1.0
        table = np.array([line for line in lines if len(line) == columns.width])
        units = zip(columns.names, columns.signals, strict=True)
        self._units = [self._unit_of(n, table[:, k : k + 1]) for n, k in units]
        if is_same_rate(rate, self._rate):
            rate = self._rate  # assume the exact rate: the difference is clock drift
        if rate < LOWEST_RATE:
            raise DeviceError(
                f"{self.port} gives {rate:.0f} lines a second, but contact detection needs "
                f"{LOWEST_RATE:g} or more: raise the baud rate, print fewer columns or sample "
                "faster"
            )
        _log.info("%s: %.1f Hz measured", self.name, rate)
        return columns, rate

    def _unit_of(self, name: str, values: NDArray[np.float64]) -> Unit:
        """Return the unit of a column.

        It is the unit that the user gave, or else the one at the end of ``name``, or else ADC
        counts. Raises DeviceError if the ``values`` cannot have the unit that is stated.
        """
        if (stated := self._unit or unit_of_name(name)) is not None:
            return fit_unit(f"column {name} of {self.name}", stated, values, error=DeviceError)
        try:
            return fit_unit(name, COUNTS, values, error=DeviceError)
        except InputError:
            return Unit("counts")

    def _work(self) -> None:
        assert self._columns is not None
        counter, epoch, damaged = SampleCounter(self._columns), 0, 0
        unchecked: list[tuple[float, ...] | None] = []
        self._lines.bad = 0
        while not self._closing.is_set():
            try:
                data = b"" if self._port is None else self._port.read(WAIT)
                self._behind = len(data) >= BACKLOG
                lines = self._lines.feed(data)
            except LinkError:
                self._reconnect()
                lines, unchecked = [], [None]
                epoch, damaged = epoch + 1, 0
                counter = SampleCounter(self._columns)
            # The names may come long after the first lines of a board that was plugged in again.
            names = self._lines.header
            if names != self._header and sorted(names) == sorted(self._header):
                raise self._other_columns()
            if unchecked:
                unchecked += lines
                if sum(line is not None for line in unchecked) < LINES_NEEDED:
                    self._note(bad_frames=self._lines.bad)
                    self._wait()
                    continue
                lines = unchecked[1:]
                unchecked = []
                self._check_columns([line for line in lines if line])
            now = time.monotonic()
            run: list[tuple[float, ...]] = []
            numbers: list[int] = []
            for line in lines:
                if line is None or len(line) != self._columns.width:
                    damaged += 1
                    self._lines.bad += line is not None
                    continue
                number = counter.next(line, damaged)
                if number is None:
                    damaged += 1
                    self._lines.bad += 1
                    continue
                if counter.restarted:
                    self._give_lines(run, numbers, epoch, now)
                    # The first lines after the restart were not believed, so they are lost.
                    self._drop(number + damaged, epoch)
                    run, numbers = [], []
                    epoch += 1
                    counter.number = number = 0
                damaged = 0
                run.append(line)
                numbers.append(number)
            self._give_lines(run, numbers, epoch, now)
            if lines:
                self._note(bad_frames=self._lines.bad)
            if damaged:
                self._drop(counter.number + 1 + damaged, epoch)
            elif not lines:
                self._wait()

    def _give_lines(
        self, lines: list[tuple[float, ...]], numbers: list[int], epoch: int, now: float
    ) -> None:
        assert self._columns is not None
        signals = np.array(lines).reshape(-1, self._columns.width)[:, list(self._columns.signals)]
        for column, unit in enumerate(self._units):
            if unit.bits is not None:  # what the converter cannot give is no sample
                half = 2.0 ** (unit.bits - 1)
                middle = half - 0.5 if unit.offset else -0.5
                is_beyond = np.abs(signals[:, column] - middle) > half
                # One alone is damage. Two in a row are of another converter.
                if unit.is_assumed and (is_beyond[1:] & is_beyond[:-1]).any():
                    raise DeviceError(
                        f"{self.name} gives {signals[is_beyond, column][0]:g}, but a converter of "
                        f"{unit.bits} bits, which is assumed, gives 0 to {2 * half - 1:g}: state "
                        f"its bits, as in csv:{self.port}=12bits"
                    )
                signals[is_beyond, column] = math.nan
        self._give(signals, np.array(numbers, np.int64), epoch, now)

    def _reconnect(self) -> None:
        assert self._port is not None
        self._note(connected=False)
        self._shut()
        self._lines.restart()
        self._port = reopen(self._port, self._closing, self.baud)

    def _check_columns(self, lines: list[tuple[float, ...]]) -> None:
        """Raise DeviceError if a reconnected board does not print the same columns as before."""
        assert self._columns is not None
        former = self._columns
        complete_lines = [line for line in lines if len(line) == former.width]
        if len(complete_lines) < 0.8 * len(lines) or (
            former.counter is not None and not counts_up(complete_lines, former.counter)
        ):
            raise self._other_columns()

    def _other_columns(self) -> DeviceError:
        assert self._columns is not None
        return DeviceError(
            f"{self.name} came back with other columns than before "
            f"({', '.join(self._header) or self._columns.width}): start the command again"
        )

    def _shut(self) -> None:
        if self._port is not None:
            self._port.close()


def from_name(name: str, options: SourceOptions) -> CsvSource:
    options.check_own_speed(name)
    address, _, columns = name.removeprefix("csv:").partition("#")
    address, stated, text = address.partition("=")
    unit = parse_unit(text)
    if stated and unit is None:
        raise DeviceError(f"{name} has no unit after the =: {STATE_UNIT}, as in csv:PORT=12bits")
    port, _, baud = address.partition("@")
    if not port:
        raise DeviceError(f"{name} names no port: give one, as in csv:/dev/ttyACM0@115200#piezo")
    # At most 8 digits: the system cannot store more.
    if baud and not (baud.isdecimal() and len(baud) <= 8 and int(baud) > 0):
        raise DeviceError(f"{name} has no baud rate after the @: give one, as in csv:{port}@{BAUD}")
    names = tuple(word for word in columns.split(",") if word)
    return CsvSource(port, names, int(baud) if baud else BAUD, unit=unit)
