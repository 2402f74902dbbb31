"""Simulated device that receives a model and can send any answer."""

import struct
from collections.abc import Callable
from dataclasses import replace

from numbered import DESCRIPTOR

from firstcontact.device import Descriptor
from firstcontact.device.descriptor import DevicePredictor
from firstcontact.device.flashing import KEPT, REPEAT_AFTER
from firstcontact.device.protocol import FrameType
from firstcontact.device.responder import Responder

MODEL = "0123456789abcdef"
TAKER = replace(DESCRIPTOR, predictor=DevicePredictor(MODEL))

#: Kind of the host's frame and how many bytes are there to what the device says is there, or to
#: the payload of its answer; None for no answer.
Says = Callable[[FrameType, int], int | bytes | None]


class HostClock:
    """Clock of the host that stands still, so that no answer is late on a busy machine."""

    def __init__(self) -> None:
        self._now = 0.0
        self._calls = 0  # until the clock advances

    def monotonic(self) -> float:
        self._calls -= 1
        if self._calls == 0:
            self._now += REPEAT_AFTER
        return self._now

    def skip(self) -> None:
        """Advance by the time after which the host repeats a frame, at the second next call.

        The next one may be that with which the host notes when it sent the frame.
        """
        self._calls = 2


class ModelTaker(Responder):
    """Device that receives a model and can send any answer.

    Parameters
    ----------
    says
        Function that chooses the answer to a frame. Its arguments are the frame's type and the
        number of bytes received so far. If it returns this number, the answer is right.
    clock
        Clock of the host. It advances with each frame that gets no answer.
    """

    def __init__(
        self, descriptor: Descriptor, boot: int, room: int, says: Says, clock: HostClock
    ) -> None:
        super().__init__(descriptor, boot, room)
        self.says = says
        self._clock = clock
        self.model = b""
        self.pieces = 0

    def handle(self, kind: int, payload: bytes) -> None:
        if kind not in (FrameType.MODEL_BEGIN, FrameType.MODEL_CHUNK, FrameType.MODEL_END):
            super().handle(kind, payload)
            return
        if kind == FrameType.MODEL_BEGIN:
            self.model = b""
        elif kind == FrameType.MODEL_CHUNK:
            self.pieces += 1
            (at,) = struct.unpack_from("<I", payload)
            self.model += payload[4:] if at == len(self.model) else b""
        reply = self.says(FrameType(kind), len(self.model))
        if isinstance(reply, int):
            state = KEPT if kind == FrameType.MODEL_END else 0
            reply = struct.pack("<BBI", state, kind, reply)
        if reply in (None, b""):  # an answer without a frame type answers nothing
            self._clock.skip()
        if reply is not None:
            self._reply = FrameType.MODEL_STATE, reply
