"""Frames out of bytes that come in any pieces, whatever was lost in between."""

from __future__ import annotations

from firstcontact.device.protocol import LONGEST, Frame, FrameError, decode


class Decoder:
    """Cuts a stream of bytes at its zeros and decodes what lies between.

    What is between two zeros and is no frame counts as one damaged piece: of a
    burst of errors as much as of a single flipped bit. A flip that makes a zero
    cuts a frame into two damaged pieces, one that takes a zero away joins two
    frames into one; how many frames are lost is told by their counters, exactly.
    The first piece after the beginning may be the end of a frame that was under way
    and is not counted.
    """

    def __init__(self) -> None:
        #: Damaged pieces so far.
        self.bad = 0
        self._rest = bytearray()
        self._first = True
        self._too_long = False

    def feed(self, data: bytes) -> list[Frame]:
        """Take the next bytes: the frames that they complete, in order."""
        pieces = (bytes(self._rest) + data).split(b"\0")
        self._rest = bytearray(pieces.pop())
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
            self._rest.clear()
            self._too_long = True
        return frames


def _frame(piece: bytes) -> Frame | None:
    try:
        return decode(piece)
    except FrameError:
        return None
