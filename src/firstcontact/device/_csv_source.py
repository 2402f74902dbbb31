"""Boards that print numbers in lines as a source: columns found, rate measured, losses counted."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstcontact.core import FINGERTIP_RATE, Channel, ChannelKind, Finger, InputError, Layout
from firstcontact.device._number_lines import BELIEVED, LEAP, Columns, LineReader, columns_of
from firstcontact.device._opening import SourceOptions
from firstcontact.device._source import Descriptor
from firstcontact.device._threaded import ThreadedSource
from firstcontact.device._transport import FAULTS, LinkError, why_not

#: Of boards with a UART, unless another is named; one with USB of its own takes any.
BAUD = 115_200
#: The first lines are waited for so long, s: many boards restart when they are opened.
PATIENCE = 5.0
#: The rate is measured over so long before samples are given, s ...
MEASURED = 2.0
#: ... and a rate so near to the models' is taken for theirs: a share of it.
ALIKE = 0.01
#: Below this no contact can be told, Hz.
LEAST_RATE = 500.0
#: A counter that has wrapped has at least so many bits.
WRAPS = (8, 16, 32)
#: Waits between attempts to open a port that is gone, s.
RETRY = 0.2


@dataclass(slots=True)
class _Counter:
    """Numbers of samples, from a column that counts them, or from how many lines there were."""

    place: int | None
    last: float | None = None
    number: int = -1
    restarted: bool = False
    _doubted: float | None = None

    def next(self, line: tuple[float, ...], damaged: int) -> int | None:
        """Number of this sample; ``damaged`` lines came since the last one.

        Without a counter each damaged line stands for a sample. With one, a line that counts back
        or leaps is taken for damaged (None), unless the next goes on from it.
        """
        self.restarted = False
        if self.place is None:
            self.number += 1 + damaged
            return self.number
        told = line[self.place]
        if self.last is None:
            self.last = told - 1.0
        step = told - self.last
        if step <= 0:
            # It wrapped where it was near the end of a width, and began anew otherwise.
            wrap = next((2.0**b for b in WRAPS if 0.9 * 2.0**b < self.last < 2.0**b), None)
            if wrap is not None and told <= 0.1 * wrap:
                step += wrap
        if not 0 < step <= LEAP:
            if self._doubted is None or not 0 < told - self._doubted <= LEAP:
                self._doubted = told
                return None
            self.restarted = True
            step = 1.0
        self.last, self._doubted = told, None
        self.number += max(1, round(step))
        return self.number


class CsvSource(ThreadedSource):
    """A board on a serial port that prints its samples as lines of numbers.

    The rate is measured by the host's clock over the first 2 s, and samples are brought to the
    models' rate. What a board lost it can only tell by a column that counts; without one what is
    lost on the way is not known, but for lines that come damaged.

    Parameters
    ----------
    port
        Its path or name.
    columns
        Signals, by header or position; none for all that are neither time nor count.
    baud
        Of the port.
    rate
        Of the samples that come out, Hz.
    measured
        How long the rate is measured, s.

    Raises
    ------
    InputError
        On entering: no such port, no lines of numbers, or too slow.
    """

    def __init__(
        self,
        port: str,
        columns: tuple[str, ...] = (),
        baud: int = BAUD,
        rate: float = FINGERTIP_RATE,
        measured: float = MEASURED,
    ) -> None:
        super().__init__(f"csv:{port}")
        self.port = port
        self._named, self._baud, self._rate, self._measured = columns, baud, rate, measured
        self._serial: Any = None
        self._lines = LineReader()
        self._columns: Columns | None = None

    def _open(self) -> Descriptor:
        self._serial = self._opened()
        try:
            self._columns, rate = self._look()
        except LinkError as gone:
            self._shut()
            raise InputError(f"{self.port} went away while it was opened: plug it in") from gone
        except BaseException:
            self._shut()
            raise
        delay = self._resample(rate, self._rate)
        count = self._columns.counter
        told = (
            "losses not known: no column counts" if count is None else f"column {count + 1} counts"
        )
        fingers = [None] if len(self._columns.signals) == 1 else list(Finger)
        signals = tuple(
            Channel(f"column {name}", ChannelKind.VIBRATION, finger, "counts")
            for name, finger in zip(self._columns.names, fingers, strict=True)
        )
        self._note(losses_known=count is not None)
        return Descriptor(
            Layout(signals, self._rate),
            firmware=f"lines of numbers, {rate:.1f} Hz measured, {told}",
            sensor=f"columns {', '.join(self._columns.names)} of {self.port}",
            source="real",
            dtype="float32",
            delay=delay,
        )

    def _opened(self) -> Any:
        import serial

        try:
            return serial.Serial(self.port, self._baud, timeout=0.02, exclusive=True)
        except FAULTS as error:
            raise InputError(why_not(self.port, error)) from error

    def _read(self) -> bytes:
        try:
            data: bytes = self._serial.read(1)
            return data + self._serial.read(self._serial.in_waiting) if data else data
        except (OSError, TypeError, ValueError) as error:
            raise LinkError(f"{self.port}: {error}") from error

    def _look(self) -> tuple[Columns, float]:
        """Columns and rate, from the first lines."""
        opened = began = time.monotonic()
        lines: list[tuple[float, ...]] = []
        arrived: list[tuple[float, int]] = []
        while (now := time.monotonic()) - began < self._measured or len(lines) < BELIEVED:
            if len(lines) < BELIEVED and now - opened > PATIENCE:
                raise InputError(
                    f"{self.port}: no lines of numbers came in {PATIENCE:g} s (and "
                    f"{self._lines.bad} of something else): check its baud rate (csv:PORT@BAUD) "
                    "and that the board prints"
                )
            new = [line for line in self._lines.feed(self._read()) if line]
            if new and not lines:
                began = time.monotonic()  # what waited in buffers came at once
            lines += new
            if new:
                arrived.append((time.monotonic(), len(lines)))
        columns = columns_of(lines, self._lines.header, self._named, self.port)
        # The first arrivals may be what had waited; of the rest a line by least squares.
        later = np.array([a for a in arrived if a[0] - began > 0.25 * self._measured])
        rate = float(np.polyfit(later[:, 0] - began, later[:, 1], 1)[0]) if len(later) > 2 else 0.0
        if columns.counter is not None:
            whole = [n for n in lines if len(n) == columns.width]
            steps = np.diff([n[columns.counter] for n in whole])
            steps = steps[(steps > 0) & (steps <= LEAP)]
            rate *= max(1.0, float(steps.mean())) if len(steps) else 1.0
        if abs(rate - self._rate) <= ALIKE * self._rate:
            rate = self._rate  # as its timer is set; how far it is off is its clock's drift
        if rate < LEAST_RATE:
            raise InputError(
                f"{self.port} gives {rate:.0f} lines a second, and a contact needs {LEAST_RATE:g} "
                "or more: raise the baud rate, print fewer columns, or sample faster"
            )
        return columns, rate

    def _work(self) -> None:
        assert self._columns is not None
        counter, epoch, damaged = _Counter(self._columns.counter), 0, 0
        self._lines.bad = 0
        while not self._closing.is_set():
            try:
                found = self._lines.feed(self._read())
            except LinkError:
                found = self._back()
                epoch, damaged = epoch + 1, 0
                counter = _Counter(self._columns.counter)
            now = time.monotonic()
            run: list[tuple[float, ...]] = []
            numbers: list[int] = []
            for line in found:
                if line is None or len(line) != self._columns.width:
                    damaged += 1
                    self._lines.bad += line is not None
                    continue
                number = counter.next(line, damaged)
                if number is None:
                    damaged += 1
                    self._lines.bad += 1
                    continue
                damaged = 0
                if counter.restarted:
                    self._give_lines(run, numbers, epoch, now)
                    run, numbers = [], []
                    epoch += 1
                    counter.number = number = 0
                run.append(line)
                numbers.append(number)
            self._give_lines(run, numbers, epoch, now)
            if found:
                self._note(bad_frames=self._lines.bad)
            if damaged:
                self._drop(counter.number + 1 + damaged, epoch)
            elif not found:
                self._wait()

    def _give_lines(
        self, lines: list[tuple[float, ...]], numbers: list[int], epoch: int, now: float
    ) -> None:
        assert self._columns is not None
        signals = np.array(lines).reshape(-1, self._columns.width)[:, list(self._columns.signals)]
        self._give(signals, np.array(numbers, np.int64), epoch, now)

    def _back(self) -> list[tuple[float, ...] | None]:
        """Wait until the port is there again; nothing when closed before that."""
        self._note(connected=False)
        self._shut()
        self._lines = LineReader(self._lines.bad, self._lines.header)
        while not self._closing.wait(RETRY):
            with suppress(InputError):
                self._serial = self._opened()
                break
        return []

    def _shut(self) -> None:
        if self._serial is not None:
            with suppress(OSError):
                self._serial.close()


def from_name(name: str, options: SourceOptions) -> CsvSource:
    """The board that a person names: csv:PORT, csv:PORT@BAUD, csv:PORT#COLUMN,COLUMN."""
    options.check_own_speed(name)
    rest, _, columns = name.removeprefix("csv:").partition("#")
    port, _, baud = rest.partition("@")
    if not port:
        raise InputError(f"{name} names no port: as in csv:/dev/ttyACM0@115200#piezo")
    # So many digits at most: the system has no room for more.
    if baud and not (baud.isdecimal() and len(baud) <= 8 and int(baud) > 0):
        raise InputError(f"{name} has no baud rate behind the @: as in csv:{port}@{BAUD}")
    wanted = tuple(word for word in columns.split(",") if word)
    return CsvSource(port, wanted, int(baud) if baud else BAUD)
