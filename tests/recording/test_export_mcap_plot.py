"""Export for plotting tools, checked with a reader that knows only ROS 2 message definitions."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import Block, Channel, ChannelKind, Group, Layout
from firstcontact.recording import EXPORTERS, export

mcap_ros2 = pytest.importorskip("mcap_ros2.reader")
SLOW = Layout((Channel("grip", ChannelKind.FORCE, None, "N", 0.5),), 100.0)


def test_every_channel_is_a_topic_of_numbers(shore, tmp_path):
    layout = replace(shore.layout, groups=(Group("100_hz", SLOW),))
    pinches = []
    for pinch in shore.pinches[:3]:
        first = int(np.ceil(pinch.first_sample * 100 / layout.rate))
        n = int(len(pinch.data) * 100 / layout.rate)
        values = np.arange(n).astype(pinch.data.dtype)[:, None]
        groups = {"100_hz": Block(values, first)}
        pinches.append(replace(pinch, layout=layout, groups=groups))
    dataset = replace(shore, pinches=tuple(pinches))
    path = tmp_path / "plot.mcap"
    export(dataset, EXPORTERS.find("mcap-plot"), path)
    topics: dict[str, list[tuple[int, object]]] = {}
    for message in mcap_ros2.read_ros2_messages(str(path)):
        number = message.ros_msg.data
        topics.setdefault(message.channel.topic, []).append((message.log_time_ns, number))
    kinds = [c.kind for c in layout.column_channels]
    for k, (kind, name) in enumerate(zip(kinds, layout.column_names, strict=True)):
        expected = np.concatenate([layout.physical(p.data, (k,))[:, 0] for p in pinches])
        times, values = zip(*topics[f"/{kind}/{name}"], strict=True)
        assert np.array_equal(values, expected)
        assert list(times) == sorted(set(times))
        steps = np.diff(times[: len(pinches[0].data)])
        assert steps == pytest.approx(1e9 / layout.rate, abs=1)
    slow = [0.5 * i for p in pinches for i in range(len(p.groups["100_hz"].data))]
    assert [value for _, value in topics["/100_hz/grip"]] == slow
    assert len(topics["/contacts"]) == sum(len(p.truth) for p in pinches)
    assert "Shore A" in str(topics["/contacts"][0][1])


def test_recordings_are_readable_as_ros_2_messages(shore, tmp_path):
    from firstcontact.recording import Header, RecordingWriter

    path = tmp_path / "a.mcap"
    pinch = shore.pinches[0]
    with RecordingWriter(path, Header(pinch.layout, "synthetic", str(pinch.data.dtype))) as writer:
        writer.pinch(pinch)
    messages = [m.ros_msg for m in mcap_ros2.read_ros2_messages(str(path), topics=["/samples"])]
    assert np.array_equal(np.concatenate([m.data for m in messages]), pinch.data.reshape(-1))
    assert main(["export", str(path), "--to", "mcap-plot", "--out", str(tmp_path / "b.mcap")]) == 0
