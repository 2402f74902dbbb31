"""Frames out of bytes that come in any pieces, whatever was lost in between."""

from __future__ import annotations

from firstcontact.device._protocol import LONGEST, Frame, FrameError, decode


class Decoder:
    """Cuts a stream of bytes at its zeros and decodes what lies between.

    What lies between two zeros and is no frame counts as one damaged piece, a burst
    of errors as much as a single flipped bit. Pieces are not frames: a flip that
    makes a zero cuts one frame into two damaged pieces, and one that takes a zero
    away joins two frames into one. How many frames are lost is told by
    their counters, exactly. The first piece after the beginning may be the end of
    a frame that was under way: it is not counted. A piece longer than any frame
    is thrown away as it comes, so that a line without zeros costs no memory.

    Attributes
    ----------
    bad
        Damaged pieces so far.
    """

    def __init__(self) -> None:
        self.bad = 0
        self.restart()

    def restart(self) -> None:
        """Begin anew in the middle of anything, as after a lost port; the count stays."""
        self._rest = b""
        self._first = True
        self._too_long = False

    def feed(self, data: bytes) -> list[Frame]:
        """Take the next bytes: the frames that they complete, in order."""
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
