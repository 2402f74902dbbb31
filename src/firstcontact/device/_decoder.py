"""Decoder of frames from a stream of bytes with losses."""

from __future__ import annotations

from typing import NamedTuple

from firstcontact.core import kernels
from firstcontact.device._protocol import LONGEST, Frame, FrameError, decode


class NextSamples(NamedTuple):
    """Number of columns, and numbers in the head of the next samples frame (modulo 2^32)."""

    width: int
    counter: int
    first_sample: int
    overflow: int


class Decoder:
    """Decoder that splits a stream of bytes at its zeros into frames.

    A piece between two zeros that is not a frame counts as one damaged piece, whether one bit is
    wrong or many. Damaged pieces are not lost frames: a wrong bit can split one frame into two
    pieces or join two frames. The frame counters give the exact number of lost frames.

    The first piece of the stream is not counted, because it may be the end of an earlier frame. A
    piece longer than any frame is discarded, so that bytes without zeros do not fill the memory.

    Attributes
    ----------
    bad
        Number of damaged pieces so far.
    """

    def __init__(self) -> None:
        self.bad = 0
        self.restart()

    def restart(self) -> None:
        """Discard an incomplete frame. Keep the count of damaged pieces."""
        self._rest = b""
        self._first = True
        self._too_long = False

    def feed_samples(self, data: bytes, expected: NextSamples) -> tuple[int, bytes]:
        """Add bytes. Decode the samples frames at the beginning that follow without a loss.

        Call :meth:`feed` afterwards: it decodes the remaining bytes. :meth:`feed` alone gives the
        same frames, but ten times slower.

        Returns
        -------
        frames : int
            Number of processed frames; 0 without compiled kernels.
        samples : bytes
            Encoded samples of these frames.
        """
        self._rest += data
        module = kernels()
        if module is None or self._too_long:
            return 0, b""
        frames: int
        samples: bytes
        used, frames, samples = module.decode_samples(self._rest, *expected)
        if used:
            self._rest = self._rest[used:]
            self._first = False
        return frames, samples

    def feed(self, data: bytes) -> list[Frame]:
        """Process the next bytes. Return the frames that they complete, in order."""
        *pieces, self._rest = (self._rest + data).split(b"\0")
        frames = []
        for piece in pieces:
            if piece or self._too_long:
                frame = None if self._too_long else _frame(piece)
                if frame is not None:
                    frames.append(frame)
                elif not self._first:
                    self.bad += 1
            self._first = self._too_long = False
        if len(self._rest) > LONGEST:
            self._rest = b""
            self._too_long = True
        return frames


def _frame(piece: bytes) -> Frame | None:
    try:
        return decode(piece)
    except FrameError:
        return None
