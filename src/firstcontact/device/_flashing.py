"""A model over the wire onto a device that answers by itself: whole and checked, or not at all."""

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

#: Most bytes of a model in a frame.
CHUNK = 200
#: What is not answered for so long is said again, s, and after so long nothing answers.
AGAIN = 1.0
PATIENCE = 5.0
_BEGIN = struct.Struct("<IIII")
_OFFSET = struct.Struct("<I")
_STATE = struct.Struct("<BBI")
KEPT, REFUSED = 1, 2
_SILENT = "what is on this port does not answer: check that it is the fingertip"
_TAKES_NONE = (
    "the device takes no models: flash a firmware that answers by itself, of this version of "
    "firstcontact"
)
#: So often in a row a piece may be asked for again.
MOST_AGAIN = 10


def _is_of(answer: Frame, kind: FrameType) -> bool:
    """Whether it is an answer to such a frame, and not a late one to the one before."""
    return answer.type != FrameType.MODEL_STATE or answer.payload[1:2] == bytes([kind])


class _Link:
    """Frames to a device, and its answers."""

    def __init__(self, port: str) -> None:
        self.port = port
        self._transport = SerialTransport(port)
        self._decoder = Decoder()

    def close(self) -> None:
        self._transport.close()

    def ask(self, kind: FrameType, payload: bytes, answer: FrameType) -> Frame | None:
        """Say something until it is answered; None where it is not."""
        until = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < until:
                self._transport.send(kind, payload)
                again = time.monotonic() + AGAIN
                while time.monotonic() < again:
                    for frame in self._decoder.feed(self._transport.read()):
                        if frame.type == FrameType.REFUSED:
                            raise refusal(frame.payload)
                        if frame.type == answer and _is_of(frame, kind):
                            return frame
        except LinkError as error:
            raise InputError(
                f"{self.port}: the device went away ({error}): plug it in and start again; it has "
                "its old model"
            ) from error
        return None

    def stop(self) -> None:
        """Stop the samples."""
        if self.ask(FrameType.STOP, b"", FrameType.STOPPED) is None:
            raise InputError(f"{self.port}: the device does not stop")

    def hello(self) -> bytes:
        """What the device says of itself, as it says it."""
        answer = self.ask(FrameType.HELLO, bytes([VERSION]), FrameType.DESCRIPTOR)
        if answer is None:
            raise InputError(f"{self.port}: {_SILENT}")
        return answer.payload

    def greeting(self) -> Greeting:
        try:
            return read_greeting(self.hello())
        except FrameError as error:
            raise InputError(f"{self.port}: {error}: start again") from error

    def send(self, data: bytes, form: int, sizes: int) -> int:
        """Send a model in pieces. Return the state of the device."""
        head = _BEGIN.pack(form, sizes, len(data), zlib.crc32(data))
        _, received = self._model(FrameType.MODEL_BEGIN, head, 0, len(data))
        most = received  # a device that goes back makes no progress
        pieces, again = 2 * (len(data) // CHUNK + MOST_AGAIN), 0
        while received < len(data):
            chunk = _OFFSET.pack(received) + data[received : received + CHUNK]
            _, received = self._model(FrameType.MODEL_CHUNK, chunk, received, len(data))
            pieces -= 1
            again = 0 if received > most else again + 1
            most = max(most, received)
            if again == MOST_AGAIN or not pieces:
                raise InputError(
                    f"{self.port}: the device asks for the same pieces of the model again and "
                    f"again (it has {most} of {len(data)} bytes): check its cable and start "
                    "again; it has its old model"
                )
        state, _ = self._model(FrameType.MODEL_END, b"", received, len(data))
        return state

    def _model(
        self, kind: FrameType, payload: bytes, received: int, length: int
    ) -> tuple[int, int]:
        """Send a frame. Return the state of the device and the bytes of the model that it has."""
        frame = self.ask(kind, payload, FrameType.MODEL_STATE)
        if frame is None:
            # One that answers to other frames does not know this one.
            if kind == FrameType.MODEL_BEGIN and self.hello():
                raise InputError(f"{self.port}: {_TAKES_NONE}")
            raise InputError(
                f"{self.port}: the device fell silent after {received} of {length} bytes of the "
                "model: check its cable, reset it and start again"
            )
        answer = frame.payload
        if len(answer) < _STATE.size:
            raise InputError(f"{self.port}: the device's answer is too short: start again")
        state, _, now = _STATE.unpack_from(answer)
        if state == REFUSED:
            raise _refused(self.port, answer[_STATE.size :].decode(errors="replace"))
        if now > length:
            raise InputError(
                f"{self.port}: the device says that it has {now} of {length} bytes of the model: "
                "reset it and start again"
            )
        return int(state), int(now)


def _refused(port: str, why: str) -> InputError:
    return InputError(
        f"{port}: the device refuses the model ({why}) and keeps its old one: export it with the "
        "version of firstcontact that the firmware is of, or smaller with a lower --budget-us"
    )


def check_model_fits(port: str, form: int, sizes: int, length: int) -> None:
    """Ask a device whether it takes such a model, before anything else is done for it.

    Parameters
    ----------
    port, form, sizes
        As of :func:`flash_model`.
    length
        Of the image, bytes.

    Raises
    ------
    InputError
        It takes no models, or not this one, or does not answer.
    """
    with closing(_Link(port)) as link:
        hello = link.hello()
    try:
        models = read_greeting(hello).descriptor.model_slot
    except (FrameError, InputError):
        return  # a model that spoilt what it says of itself can still be replaced
    if models is None:
        raise InputError(f"{port}: {_TAKES_NONE}")
    if models.format != form:
        raise _refused(port, f"it takes format {models.format}, and this is {form}")
    if models.sizes != sizes:
        raise _refused(port, "it is for kernels of other sizes than the firmware has")
    if models.room < length:
        raise _refused(port, f"{length} bytes, and there is room for {models.room}")


def flash_model(port: str, data: bytes, form: int, sizes: int) -> str:
    """Send a model and have it answer.

    Parameters
    ----------
    port
        Of the device.
    data
        The image.
    form, sizes
        Its format, and the CRC of the sizes that it needs: refused before anything is sent where
        the device has others.

    Returns
    -------
    str
        Digest of the model that answers now, as the device says.

    Raises
    ------
    InputError
        The device refuses it, does not answer or goes away: then it has its old model.
    """
    with closing(_Link(port)) as link:
        link.hello()  # whatever it says of itself: a model that spoilt that can still be replaced
        link.stop()
        state = link.send(data, form, sizes)
        answers = link.greeting().descriptor.predictor
    if state != KEPT or answers is None:
        raise InputError(f"{port}: the device did not keep the model: start again")
    return answers.model
