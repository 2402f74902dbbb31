"""Output for the viewer Foxglove: samples, force grids and events, by ``foxglove.sdk.v1``."""

from __future__ import annotations

import re
import time
from typing import Any, get_args

import msgspec
import numpy as np
from msgspec import inspect

from firstcontact.core import ArgumentError, ChannelKind, Finger, finger_name
from firstcontact.core.installation import require_modules
from firstcontact.device import Arrival, Descriptor
from firstcontact.device.clock import DeviceClock
from firstcontact.streaming._sinks import Update
from firstcontact.streaming.events import Event
from firstcontact.streaming.json_lines import FailedLine, MarkerLine, json_line
from firstcontact.streaming.outputs import OutputKind, OutputOptions
from firstcontact.streaming.session import LiveSession

require_modules("foxglove", "foxglove")

#: Messages that wait for a slow viewer; then the oldest are dropped. 8 s of the fingertip.
BACKLOG = 40_000
#: Little-endian CDR, the encoding of ROS 2.
_CDR = b"\x00\x01\x00\x00"
_PLAIN = {inspect.BoolType: "boolean", inspect.FloatType: "number", inspect.IntType: "integer"}
#: Side of a force cell, and distance between two grids, in the 3D panel, m.
CELL, APART = 0.005, 0.02


class FoxgloveSink:
    """WebSocket server for Foxglove, which sends each sample, force grids, and each event as JSON.

    The constructor opens the port, so that a busy port is reported early. The SDK cannot refuse
    origins: any web page in a browser on this computer can read along.
    """

    name = "foxglove"
    every = 0.02
    is_prompt = True

    def __init__(self, address: str = "127.0.0.1:8766") -> None:
        import foxglove

        host, _, port = address.rpartition(":")

        self._sdk: Any = foxglove
        self._context = foxglove.Context()
        try:
            self._server = foxglove.start_server(
                name="firstcontact",
                host=host.strip("[]"),
                port=int(port),
                context=self._context,
                message_backlog_size=BACKLOG,
            )
        except Exception as error:  # the SDK exports no class of its errors
            raise ArgumentError(
                f"Foxglove cannot be served at {address!r} ({error}): give an address and a free "
                "port, such as 127.0.0.1:8766, or port 0 for any free one"
            ) from error
        #: Address to open in Foxglove.
        self.url = f"ws://{host}:{self._server.port}"

    def open(self, descriptor: Descriptor) -> None:
        layout = self._layout = descriptor.layout
        self._columns = tuple(range(layout.width))
        self._clock = DeviceClock(layout.rate)
        self._shift = time.time() - time.monotonic()
        names = [re.sub(r"\W+", "_", n.lower(), flags=re.ASCII) for n in layout.column_names]
        if len({*names, "sample", "epoch"}) < len(names) + 2 or not all(
            name[:1].isalpha() for name in names
        ):
            names = [f"column_{k}" for k in self._columns]
        fields = ["uint64 sample", "uint32 epoch", *(f"float32 {name}" for name in names)]
        self._row = np.dtype(
            [("cdr", "V4"), ("sample", "<u8"), ("epoch", "<u4"), ("values", "<f4", layout.width)]
        )
        text = "\n".join(fields).encode()
        schema = self._sdk.Schema(name="firstcontact/msg/Sample", encoding="ros2msg", data=text)
        self.samples = self._channel("/samples", schema=schema, message_encoding="cdr")
        self.events = {}
        for kind in (*get_args(Event), MarkerLine, FailedLine):
            tag = str(kind.__struct_config__.tag)
            schema = {"title": tag, **_schema(inspect.type_info(kind))}
            self.events[tag] = self._channel(f"/{tag}", schema=schema)
        self._grids = []
        for finger in (*Finger, None):
            columns = layout.columns(ChannelKind.FORCE, finger)
            ordered = sorted(columns, key=lambda c: layout.column_channels[c].taxel or 0)
            if ordered:
                topic = f"/force/{finger_name(finger)}"
                channel = self._sdk.channels.GridChannel(topic, context=self._context)
                self._grids.append((channel, tuple(ordered)))

    def take(self, update: Update) -> None:
        for arrival in update.arrivals:
            self._send(arrival)
        now = time.monotonic()
        for name, reason in update.failed.items():
            self._log(FailedLine(name, reason), now)
        for event in update.events:
            self._log(event, self._clock.host_time(event.known_sample, event.epoch))

    def close(self) -> None:
        """Disconnect all viewers and release the port. A second call does nothing."""
        self._server.stop()

    def _send(self, arrival: Arrival) -> None:
        block = arrival.block
        if len(block.data):
            stamps = self._nanoseconds(self._clock.stamps(block, arrival.host))
            if self.samples.has_sinks():
                rows = np.empty(len(block.data), self._row)
                rows["cdr"] = np.void(_CDR)
                rows["sample"] = np.arange(block.first_sample, block.end)
                rows["epoch"] = block.epoch
                rows["values"] = self._layout.physical(block.data, self._columns)
                for stamp, row in zip(stamps.tolist(), rows, strict=True):
                    self.samples.log(row.tobytes(), log_time=stamp)
            for place, (channel, columns) in enumerate(self._grids):
                if channel.has_sinks():
                    force = self._layout.physical(block.data, columns).mean(axis=0)
                    channel.log(
                        self._force_grid(force, place, int(stamps[-1])), log_time=int(stamps[-1])
                    )
        for marker in arrival.markers:
            line = MarkerLine(marker.sample, marker.epoch, marker.text)
            self._log(line, self._clock.host_time(marker.sample, marker.epoch))

    def _force_grid(self, force: Any, place: int, stamp: int) -> Any:
        """Return a Foxglove grid with the forces on a finger. Its first row is on top.

        ``place`` is the number of the grid, from left to right, and ``stamp`` its time since 1970,
        ns.
        """
        kinds = self._sdk.messages
        across = 1 if len(force) % 2 else 2
        position = kinds.Vector3(x=place * APART)
        number = kinds.PackedElementFieldNumericType.Float32
        return kinds.Grid(
            timestamp=kinds.Timestamp(*divmod(stamp, 10**9)),
            frame_id="hand",
            pose=kinds.Pose(position=position, orientation=kinds.Quaternion(w=1.0)),
            column_count=across,
            cell_size=kinds.Vector2(x=CELL, y=CELL),
            row_stride=4 * across,
            cell_stride=4,
            fields=[kinds.PackedElementField(name="force", type=number)],
            data=force.astype("<f4").reshape(-1, across)[::-1].tobytes(),
        )

    def _log(self, line: msgspec.Struct, host: float) -> None:
        tag = str(line.__struct_config__.tag)
        self.events[tag].log(json_line(line), log_time=int(self._nanoseconds(host)))

    def _nanoseconds(self, host: Any) -> Any:
        """Convert times of ``time.monotonic()``, s, into times since 1970, ns."""
        return np.int64(np.round((host + self._shift) * 1e9))

    def _channel(self, topic: str, **options: Any) -> Any:
        return self._sdk.Channel(topic, context=self._context, **options)


def _schema(kind: inspect.Type) -> dict[str, Any]:
    """Return the JSON schema of a type of event, without references.

    Viewers cannot read references.
    """
    if isinstance(kind, inspect.UnionType):
        return _schema(next(t for t in kind.types if not isinstance(t, inspect.NoneType)))
    if isinstance(kind, inspect.StructType | inspect.DataclassType):
        return {"type": "object", "properties": {f.name: _schema(f.type) for f in kind.fields}}
    if isinstance(kind, inspect.VarTupleType):
        return {"type": "array", "items": _schema(kind.item_type)}
    if isinstance(kind, inspect.EnumType) and issubclass(kind.cls, int):
        return {"type": "integer"}
    return {"type": _PLAIN.get(type(kind), "string")}


def _make(session: LiveSession, options: OutputOptions) -> FoxgloveSink:
    sink = FoxgloveSink(options.foxglove_address)
    session.notify(f"foxglove: {sink.url}")
    return sink


FOXGLOVE = OutputKind("foxglove", _make)
