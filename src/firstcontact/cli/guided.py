"""The terminal of a guided recording: plain lines, and one that is written over on a tty."""

from __future__ import annotations

import select
import sys
from typing import Self

from firstcontact.cli.output import reader_gone
from firstcontact.cli.sensor_words import is_tapped
from firstcontact.collect import Guide, Judged
from firstcontact.core import InputError, Label
from firstcontact.device import LinkNews, Source

#: Without a closing for so long, it is said what is waited for, s of the device's time.
REMIND = 10.0
#: A noise this far above its floor keeps closings from being seen.
NOISY = 1.4


def entered() -> bool:
    """Whether Enter was pressed since the last call; does not wait for it.

    Raises
    ------
    InputError
        Nobody can press it.
    """
    try:
        if not select.select([sys.stdin], [], [], 0)[0]:
            return False
        line = sys.stdin.readline()
    except OSError:  # the terminal was closed
        line = ""
    if not line:
        raise InputError(
            "someone has to press Enter here, and standard input has ended: do it in a terminal, "
            "or without what has to be changed by hand"
        )
    return True


class Terminal:
    """Says how the recording goes; asks for Enter where objects have to be changed.

    Parameters
    ----------
    source, guide
        What it is about.
    asks
        Whether a person changes the objects.
    """

    def __init__(self, source: Source, guide: Guide, asks: bool) -> None:
        self._source = source
        self._guide = guide
        self._asks = asks
        self._tapped = is_tapped(guide.layout)
        self._live = sys.stdout.isatty()
        self._width = 0
        self._told_at = source.health.samples
        self._link = LinkNews(source.health)
        self._lost_before = source.health.lost_samples
        self._deserted = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        health = self._source.health
        for line in self._link.lines(health, last=True):
            self._line(line)
        self._say(
            f"link: {health.samples} samples, {health.lost} lost, "
            f"{health.bad_frames} damaged frames, {health.reconnects} reconnects; "
            f"{self._guide.left_out} {'taps' if self._tapped else 'closings'} did not count"
        )
        lost = health.lost_samples - self._lost_before
        if lost:
            self._say(
                f"warning: the recording has gaps, {lost} samples are missing from it; a pinch "
                "with a gap in it does not count and is asked for again"
            )

    def next_object(self, label: Label, done: int, wanted: int) -> bool:
        """Say what is to be pinched now; False where the person must first put it there.

        Raises
        ------
        InputError
            The person must, and cannot be told.
        """
        shore = "" if label.shore_a is None else f", {label.shore_a:g} Shore A"
        self._say(
            f"next: {label.object}{shore}, specimen {label.specimen}, "
            f"{wanted - done} of {wanted} pinches to go"
            + (": put it in place and press Enter" if self._asks else "")
        )
        if self._asks and reader_gone():
            raise InputError(
                "someone has to be told here what comes next, and nobody reads standard output any "
                "more: do it in a terminal, or without what has to be changed by hand"
            )
        return not self._asks

    def in_place(self) -> bool:
        """Whether Enter was pressed; InputError when nobody can press it."""
        return entered()

    def judged(self, judged: Judged) -> None:
        """Say how a closing went."""
        name = judged.label.object
        if judged.faults:
            self._say(f"{name}: does not count: {'; '.join(judged.faults)}")
            return
        said = [f"{name} {judged.k}/{judged.wanted}: contact"]
        if judged.disagreement is not None:
            said.append(f"strip and piezo agree to {abs(judged.disagreement) * 1e3:.1f} ms")
        if judged.offset is not None:
            said.append(f"offset {judged.offset * 1e3:.1f} ms")
        said.append(f"noise {judged.noise:.2f} x floor")
        said.append(f"{self._source.health.lost_samples} samples lost so far")
        self._say(", ".join(said))

    def going_on(self) -> None:
        """Refresh the status; remind of what is waited for, and say what the link does."""
        health, guide = self._source.health, self._guide
        for line in self._link.lines(health):
            self._line(line)
        waited = (health.samples - self._told_at) / guide.layout.rate
        noise = f"noise {guide.noise:.2f} x floor"
        if waited >= REMIND and not guide.paused:
            event, place = "the hand to close", "hand"
            if self._tapped:
                event, place = "a tap", "surroundings"
            advice = f": calibrate again, or quieten the {place}" if guide.noise > NOISY else ""
            self._say(f"waiting for {event}; {noise}{advice}")
        if self._live:
            line = (
                f"{health.samples / guide.layout.rate:.0f} s, {noise}, {health.lost_samples} lost"
            )
            self._width = max(self._width, len(line))
            print(f"\r{line.ljust(self._width)}", end="", flush=True)

    def _say(self, line: str) -> None:
        """Say something of the hand; what is waited for need not be said again so soon."""
        self._line(line)
        self._told_at = self._source.health.samples

    def _line(self, line: str) -> None:
        start = "\r" if self._live else ""
        print(start + line.ljust(self._width), flush=True)
        if reader_gone() and not self._deserted:
            self._deserted = True
            print(
                "firstcontact: nobody reads standard output any more; what can be done without it "
                "goes on",
                file=sys.stderr,
            )
