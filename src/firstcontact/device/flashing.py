"""Transfer of a model to a device, which runs the model once it was stored completely."""

from __future__ import annotations

import struct
import time
import zlib
from contextlib import closing

from firstcontact.core import DeviceError, InputError
from firstcontact.device.descriptor import read_greeting, refusal
from firstcontact.device.ports import LinkError, SerialTransport
from firstcontact.device.protocol import VERSION, Decoder, FrameError, FrameType

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
#: Half the number of pieces that a device may request beyond twice the pieces of the model.
MORE_PIECES = 10


class _Link:
    """Connection to a device for the transfer of a model."""

    def __init__(self, port: str) -> None:
        self.port = port
        self._transport = SerialTransport(port)
        self._decoder = Decoder()

    def close(self) -> None:
        self._transport.close()

    def ask(self, kind: FrameType, payload: bytes, answer: FrameType) -> bytes | None:
        """Repeat a frame until the device answers with a frame of the type ``answer``.

        Return the payload of the answer, or None if none came within 5 s.
        """
        deadline = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < deadline:
                self._transport.send(kind, payload)
                repeat_at = time.monotonic() + REPEAT_AFTER
                while time.monotonic() < repeat_at:
                    for frame in self._decoder.feed(self._transport.read()):
                        if frame.type == FrameType.REFUSED:
                            raise refusal(frame.payload)
                        # A model's state also names the type of frame that it answers.
                        is_late = frame.payload[1:2] != bytes([kind])
                        if frame.type == answer and not (
                            answer == FrameType.MODEL_STATE and is_late
                        ):
                            return frame.payload
        except LinkError as error:
            raise self.error(
                f"the device was unplugged ({error}): plug it in and start again; the device keeps "
                "its old model"
            ) from error
        return None

    def error(self, message: str) -> InputError:
        return DeviceError(f"{self.port}: {message}")

    def hello(self) -> bytes:
        answer = self.ask(FrameType.HELLO, bytes([VERSION]), FrameType.DESCRIPTOR)
        if answer is None:
            raise self.error(_SILENT)
        return answer

    def send(self, data: bytes) -> int:
        """Send a model image in pieces. Return :data:`KEPT` if the device stored it."""
        head = _BEGIN.pack(*_FORMAT.unpack_from(data), len(data), zlib.crc32(data))
        _, received = self._send_piece(FrameType.MODEL_BEGIN, head, 0, len(data))
        for _ in range(2 * (len(data) // CHUNK + MORE_PIECES)):
            if received == len(data):
                break
            chunk = _OFFSET.pack(received) + data[received : received + CHUNK]
            _, received = self._send_piece(FrameType.MODEL_CHUNK, chunk, received, len(data))
        else:
            raise self.error(
                "the device repeatedly asks for the same pieces of the model (it has "
                f"{received} of {len(data)} bytes): check its cable and start again; the device "
                "keeps its old model"
            )
        state, _ = self._send_piece(FrameType.MODEL_END, b"", received, len(data))
        return state

    def _send_piece(
        self, kind: FrameType, payload: bytes, received: int, length: int
    ) -> tuple[int, int]:
        """Send one frame of a transfer. Return the device's state and its number of stored bytes.

        The model has ``length`` bytes. Before this frame, ``received`` of them are on the device.
        Raises DeviceError if the device refuses the model or falls silent.
        """
        answer = self.ask(kind, payload, FrameType.MODEL_STATE)
        if answer is None:
            # A device that answers other frames does not know this one.
            if kind == FrameType.MODEL_BEGIN and self.hello():
                raise self.error(_TAKES_NONE)
            raise self.error(
                f"the device fell silent after {received} of {length} bytes of the model: check "
                "its cable, reset it and start again"
            )
        if len(answer) < _STATE.size:
            raise self.error("the device's answer is too short: run the command again")
        state, _, stored = _STATE.unpack_from(answer)
        if state == REFUSED:
            raise self.refused(answer[_STATE.size :].decode(errors="replace"))
        if stored > length:
            raise self.error(
                f"the device reports {stored} received bytes of the model, which has {length}: "
                "reset the device and start again"
            )
        return int(state), int(stored)

    def refused(self, reason: str) -> InputError:
        return self.error(
            f"the device refuses the model ({reason}) and keeps its old one: use the version of "
            "firstcontact that the firmware belongs to"
        )


def check_model_fits(port: str, data: bytes) -> None:
    """Raise DeviceError if the device on ``port`` cannot store the model image ``data``.

    The check changes nothing on the device.
    """
    with closing(_Link(port)) as link:
        hello = link.hello()
    try:
        slot = read_greeting(hello)[1].model_slot
    except (FrameError, InputError):
        return  # a stored model that damages the descriptor can still be replaced
    if slot is None:
        raise link.error(_TAKES_NONE)
    (form,) = _FORMAT.unpack_from(data)
    if slot.format != form:
        raise link.refused(
            f"the firmware takes models of format {slot.format}, and this model has format {form}"
        )
    if slot.room < len(data):
        raise link.error(
            f"the model has {len(data)} bytes, but the device can store {slot.room}: export a "
            "smaller model"
        )


def flash_model(port: str, data: bytes) -> str:
    """Store the model image ``data`` on the device on ``port``. Return the digest it reports.

    Raises DeviceError if the transfer fails. The device then keeps its old model.
    """
    with closing(_Link(port)) as link:
        link.hello()  # not parsed: a stored model that damages the descriptor can be replaced
        if link.ask(FrameType.STOP, b"", FrameType.STOPPED) is None:
            raise link.error("the device does not stop sending samples: reset it and start again")
        state = link.send(data)
        try:
            predictor = read_greeting(link.hello())[1].predictor
        except FrameError as error:
            raise link.error(f"{error}: start again") from error
    if state != KEPT or predictor is None:
        raise link.error("the device did not store the model: run the command again")
    return predictor.model
