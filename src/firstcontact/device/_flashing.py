"""Transfer of a model to a device that runs it. The device uses a model once it is complete."""

from __future__ import annotations

import struct
import time
import zlib
from contextlib import closing

from firstcontact.core import InputError
from firstcontact.device._decoder import Decoder
from firstcontact.device._handshake import Greeting, read_greeting, refusal
from firstcontact.device._protocol import VERSION, Frame, FrameError, FrameType
from firstcontact.device._transport import LinkError, SerialTransport

#: Largest number of model bytes in a frame.
CHUNK = 200
#: Time without an answer after which a frame is repeated, s, and time after which the host gives
#: up.
REPEAT_AFTER = 1.0
PATIENCE = 5.0
_BEGIN = struct.Struct("<III")
#: Format in the head of a model image.
_FORMAT = struct.Struct("<4xI")
_OFFSET = struct.Struct("<I")
_STATE = struct.Struct("<BBI")
KEPT, REFUSED = 1, 2
_SILENT = "no device answers on this port: check that it is the fingertip"
_TAKES_NONE = (
    "the device takes no models: flash the firmware that runs models, of this version of "
    "firstcontact"
)
#: Largest number of consecutive requests for the same piece.
MOST_REPEATS = 10


def _answers_kind(answer: Frame, kind: FrameType) -> bool:
    """Return True if ``answer`` is for a frame of this kind, not for an earlier frame."""
    return answer.type != FrameType.MODEL_STATE or answer.payload[1:2] == bytes([kind])


class _Link:
    """Connection to a device. It sends frames and waits for the answers."""

    def __init__(self, port: str) -> None:
        self.port = port
        self._transport = SerialTransport(port)
        self._decoder = Decoder()

    def close(self) -> None:
        self._transport.close()

    def ask(self, kind: FrameType, payload: bytes, answer: FrameType) -> Frame | None:
        """Send a frame again and again until the device answers it. Return the answer, or None."""
        deadline = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < deadline:
                self._transport.send(kind, payload)
                repeat_at = time.monotonic() + REPEAT_AFTER
                while time.monotonic() < repeat_at:
                    for frame in self._decoder.feed(self._transport.read()):
                        if frame.type == FrameType.REFUSED:
                            raise refusal(frame.payload)
                        if frame.type == answer and _answers_kind(frame, kind):
                            return frame
        except LinkError as error:
            raise InputError(
                f"{self.port}: the device was unplugged ({error}): plug it in and start again; "
                "the device keeps its old model"
            ) from error
        return None

    def stop(self) -> None:
        """Make the device stop its samples."""
        if self.ask(FrameType.STOP, b"", FrameType.STOPPED) is None:
            raise InputError(
                f"{self.port}: the device does not stop sending samples: reset it and start again"
            )

    def hello(self) -> bytes:
        """Request the device's descriptor. Return the payload of the descriptor frame."""
        answer = self.ask(FrameType.HELLO, bytes([VERSION]), FrameType.DESCRIPTOR)
        if answer is None:
            raise InputError(f"{self.port}: {_SILENT}")
        return answer.payload

    def greeting(self) -> Greeting:
        try:
            return read_greeting(self.hello())
        except FrameError as error:
            raise InputError(f"{self.port}: {error}: start again") from error

    def send(self, data: bytes) -> int:
        """Send a model in pieces. Return :data:`KEPT` if the device kept it, else another state."""
        head = _BEGIN.pack(*_FORMAT.unpack_from(data), len(data), zlib.crc32(data))
        _, received = self._model(FrameType.MODEL_BEGIN, head, 0, len(data))
        best = received  # requests for earlier pieces are no progress
        pieces, repeats = 2 * (len(data) // CHUNK + MOST_REPEATS), 0
        while received < len(data):
            chunk = _OFFSET.pack(received) + data[received : received + CHUNK]
            _, received = self._model(FrameType.MODEL_CHUNK, chunk, received, len(data))
            pieces -= 1
            repeats = 0 if received > best else repeats + 1
            best = max(best, received)
            if repeats == MOST_REPEATS or not pieces:
                raise InputError(
                    f"{self.port}: the device repeatedly asks for the same pieces of the model "
                    f"(it has {best} of {len(data)} bytes): check its cable and start again; the "
                    "device keeps its old model"
                )
        state, _ = self._model(FrameType.MODEL_END, b"", received, len(data))
        return state

    def _model(
        self, kind: FrameType, payload: bytes, received: int, length: int
    ) -> tuple[int, int]:
        """Send a frame of a transfer. Return the device's state and its number of stored bytes."""
        frame = self.ask(kind, payload, FrameType.MODEL_STATE)
        if frame is None:
            # A device that answers other frames does not know this one.
            if kind == FrameType.MODEL_BEGIN and self.hello():
                raise InputError(f"{self.port}: {_TAKES_NONE}")
            raise InputError(
                f"{self.port}: the device fell silent after {received} of {length} bytes of the "
                "model: check its cable, reset it and start again"
            )
        answer = frame.payload
        if len(answer) < _STATE.size:
            raise InputError(
                f"{self.port}: the device's answer is too short: run the command again"
            )
        state, _, stored = _STATE.unpack_from(answer)
        if state == REFUSED:
            raise _refused(self.port, answer[_STATE.size :].decode(errors="replace"))
        if stored > length:
            raise InputError(
                f"{self.port}: the device reports {stored} received bytes of the model, which has "
                f"{length}: reset the device and start again"
            )
        return int(state), int(stored)


def _refused(port: str, why: str) -> InputError:
    return InputError(
        f"{port}: the device refuses the model ({why}) and keeps its old one: use the version of "
        "firstcontact that the firmware belongs to"
    )


def check_model_fits(port: str, data: bytes) -> None:
    """Raise an error for a model that the device cannot take. Nothing changes on the device.

    Parameters
    ----------
    port, data
        See :func:`flash_model`.

    Raises
    ------
    InputError
        The device takes no models, cannot take this one, or does not answer.
    """
    with closing(_Link(port)) as link:
        hello = link.hello()
    try:
        slot = read_greeting(hello).descriptor.model_slot
    except (FrameError, InputError):
        return  # a stored model that damages the descriptor can still be replaced
    if slot is None:
        raise InputError(f"{port}: {_TAKES_NONE}")
    (form,) = _FORMAT.unpack_from(data)
    if slot.format != form:
        raise _refused(
            port,
            f"the firmware takes models of format {slot.format}, and this model has format {form}",
        )
    if slot.room < len(data):
        raise _refused(port, f"the model has {len(data)} bytes, and there is room for {slot.room}")


def flash_model(port: str, data: bytes) -> str:
    """Send a model to a device and make it the active one.

    Parameters
    ----------
    port
        Port of the device.
    data
        Model image; see :mod:`firstcontact.chain`.

    Returns
    -------
    str
        Digest of the active model, as the device states it.

    Raises
    ------
    InputError
        The device refuses the model, does not answer or is unplugged. It then keeps its old model.
    """
    with closing(_Link(port)) as link:
        link.hello()  # not parsed: a stored model that damages the descriptor can be replaced
        link.stop()
        state = link.send(data)
        predictor = link.greeting().descriptor.predictor
    if state != KEPT or predictor is None:
        raise InputError(f"{port}: the device did not store the model: run the command again")
    return predictor.model
