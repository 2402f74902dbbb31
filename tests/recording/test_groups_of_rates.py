"""A layout may hold groups of different rates: 2200 Hz and 100 Hz, as a BioTac has them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Contact,
    Finger,
    Group,
    InputError,
    Layout,
    Pinch,
    VibrationSensor,
)
from firstcontact.device import ReplaySource
from firstcontact.recording import (
    Header,
    RecordingWriter,
    load_dataset,
    read_recording,
    write_dataset,
)
from firstcontact.signal import resample_dataset

SLOW = Layout(
    tuple(Channel(f"e{k}", ChannelKind.FORCE, Finger.INDEX, "", 0.5, taxel=k) for k in range(3)),
    100.0,
)
PAC = Channel("pac", ChannelKind.VIBRATION, Finger.INDEX, "", sensor=VibrationSensor.HYDROPHONE)
LAYOUT = Layout((PAC,), 2200.0, groups=(Group("electrodes", SLOW),))


def fast(first: int, n: int) -> Block:
    return Block(np.arange(first, first + n, dtype=np.int16)[:, None], first)


def slow(first: int, n: int) -> Block:
    return Block(np.arange(first, first + n, dtype=np.int16)[:, None].repeat(3, 1), first)


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """Two seconds as they come, and a pinch of half a second without the group."""
    path = tmp_path / "biotac.mcap"
    with RecordingWriter(path, Header(LAYOUT, "real")) as writer:
        for tenth in range(20):
            writer.write(fast(220 * tenth, 220))
            writer.write(slow(10 * tenth, 10), "electrodes")
        truth = (Contact(Finger.INDEX, 4600, 4600),)
        writer.pinch(Pinch(fast(4400, 1100).data, LAYOUT, first_sample=4400, truth=truth))
    return path


def test_each_group_comes_back_at_its_rate(recorded: Path) -> None:
    recording = read_recording(recorded)
    assert recording.header.layout == LAYOUT
    assert recording.skipped == ()
    (its,) = recording.groups["electrodes"]
    assert np.array_equal(its.data, slow(0, 200).data)
    assert recording.samples == 5500


def test_a_pinch_has_the_group_in_its_time(tmp_path: Path) -> None:
    first, n = 2201, 1099
    pinch = Pinch(
        fast(first, n).data, LAYOUT, first_sample=first, groups={"electrodes": slow(101, 49)}
    )
    with RecordingWriter(tmp_path / "a.mcap", Header(LAYOUT)) as writer:
        writer.pinch(pinch)
    dataset = load_dataset(tmp_path / "a.mcap")
    for there in (dataset, resample_dataset(dataset, 4400.0)):
        times, values = there.pinches[0].group("electrodes")
        assert times[0] == pytest.approx(1.01 - first / 2200)
        assert np.diff(times) == pytest.approx(0.01)
        assert np.array_equal(values, 0.5 * slow(101, 49).data)
    # And on into recordings of their own.
    (tmp_path / "b").mkdir()
    write_dataset(dataset, tmp_path / "b", Header(LAYOUT))
    again = load_dataset(tmp_path / "b").pinches[0]
    assert np.array_equal(again.groups["electrodes"].data, slow(101, 49).data)


def test_of_a_group_that_is_not_whole_nothing_is_given(recorded: Path) -> None:
    assert "electrodes" not in load_dataset(recorded).pinches[0].groups


def test_a_damaged_first_chunk_costs_no_group(recorded: Path) -> None:
    data = bytearray(recorded.read_bytes())
    at = data.index(b"/samples/electrodes")
    data[at] ^= 1
    recorded.write_bytes(data)
    recording = read_recording(recorded)
    assert recording.skipped != ()
    assert sum(len(s.data) for s in recording.groups["electrodes"]) == 200


def test_what_a_writer_of_groups_refuses(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.mcap", Header(LAYOUT)) as writer:
        with pytest.raises(InputError, match="no group 'other'"):
            writer.write(slow(0, 10), "other")
        with pytest.raises(InputError, match="3 columns"):
            writer.write(fast(0, 10), "electrodes")


@pytest.mark.parametrize(
    "groups",
    [
        (Group("a", SLOW), Group("a", SLOW)),
        (Group("a", SLOW), Group("b", SLOW)),
        (Group("a", replace(SLOW, rate=5000.0)),),
        (Group("a", replace(SLOW, channels=())),),
        (Group("a", LAYOUT),),
    ],
)
def test_groups_that_cannot_be_are_refused(groups: tuple[Group, ...]) -> None:
    with pytest.raises(ValueError, match="layout has"):
        Header(replace(LAYOUT, groups=groups))


def test_people_see_the_groups(recorded: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(recorded)]) == 0
    assert "electrodes: 3 channels at 100 Hz, 200 samples" in capsys.readouterr().out
    out = recorded.with_suffix(".csv")
    assert main(["export", str(recorded), "--to", "csv", "--out", str(out)]) == 0
    assert "electrodes are left out" in capsys.readouterr().out
    with ReplaySource(recorded, float("inf")) as source:
        assert source.descriptor.layout == replace(LAYOUT, groups=())
