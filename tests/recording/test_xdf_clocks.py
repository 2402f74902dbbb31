"""XDF streams whose clocks differ from their stated rates, and from each other."""

import numpy as np
import pytest
from test_recording_xdf import RATE, SLOW, marks, slow, stream, times, vibration, xdf

from firstcontact import import_recordings
from firstcontact.core import InputError

pytest.importorskip("pyxdf")
SECONDS = 8.0


def clock(rate, begin=0.0, end=SECONDS):
    """Return the seconds of a stream's samples after the vibration's first sample."""
    seconds = np.arange(round(SECONDS * 1.1 * rate)) / rate
    return seconds[(seconds >= begin) & (seconds < end)]


def timed(rate, begin=0.0, end=SECONDS):
    """Return a vibration whose samples are their times, s."""
    seconds = clock(rate, begin, end)
    return vibration(stamps=50.0 + seconds, values=seconds)


def timed_slow(*stretches, rate=SLOW):
    """Return a slow stream with samples in stretches of time; the samples are their times, s."""
    seconds = np.concatenate([clock(rate, *stretch) for stretch in stretches])
    return slow(stamps=50.0 + seconds, values=np.column_stack([seconds, seconds]))


def contact_times(dataset):
    """Return the true time of each contact, s, which is the sample there."""
    return np.array([p.data[p.first.sample - p.first_sample, 0] for p in dataset if p.first])


@pytest.mark.parametrize("share", [0.992, 1 - 5e-5, 1.0, 1 + 5e-5, 1.008])
@pytest.mark.parametrize("gap", [False, True])
@pytest.mark.parametrize("given", ["markers", "events"])
def test_contacts_and_samples_do_not_drift(tmp_path, share, gap, given):
    seconds = clock(RATE * share)
    if gap:
        seconds = seconds[(seconds < 3.0) | (seconds > 4.0)]
    touches = [0.5, 2.9, 4.1, 7.9]
    finger = vibration(stamps=50.0 + seconds, values=seconds)
    path = xdf(tmp_path, finger, marks(texts=[(touch, "foam") for touch in touches]))
    table = tmp_path / "events.csv"
    table.write_text("\n".join(["onset_s", *map(str, touches)]))
    dataset = import_recordings(path, tmp_path / "out", events=table if given == "events" else None)
    assert contact_times(dataset) == pytest.approx(touches, abs=0.6 / RATE)
    loaded = import_recordings(xdf(tmp_path, finger), tmp_path / "whole")
    assert np.concatenate([p.data[:, 0] for p in loaded]).tolist() == seconds.astype("f4").tolist()


@pytest.mark.parametrize("jitter", [0.0, 0.002])
@pytest.mark.parametrize("lost", [0.02, 0.4])
def test_short_losses_move_no_contact(tmp_path, jitter, lost):
    seconds = clock(RATE)
    seconds = seconds[(seconds < 4.0) | (seconds >= 4.0 + lost)]
    stamps = 50.0 + seconds + jitter * np.random.default_rng(1).standard_normal(len(seconds))
    touches = [0.5, 3.5, 4.0 + lost / 2, 4.5, 7.5]
    texts = [(touch, f"{touch}") for touch in touches]
    finger = vibration(stamps=stamps, values=seconds)
    dataset = import_recordings(xdf(tmp_path, finger, marks(texts=texts)), tmp_path / "out")
    assert contact_times(dataset) == pytest.approx(
        np.delete(touches, 2), abs=0.1 * jitter + 0.6 / RATE
    )
    assert all(np.diff(pinch.data[:, 0]).max() < 1.5 / RATE for pinch in dataset)
    assert any("1 gaps" in note for note in dataset.notes)


def test_many_losses_are_refused(tmp_path):
    seconds = clock(RATE)
    lossy = np.delete(seconds, np.arange(3, len(seconds), 10))
    path = xdf(tmp_path, vibration(stamps=50.0 + lossy, values=lossy))
    with pytest.raises(InputError, match="finger"):
        import_recordings(path, tmp_path / "out")


@pytest.mark.parametrize("stated_share", [0.992, 1 - 6e-5, 1.0, 1 + 6e-5, 1.008])
@pytest.mark.parametrize("slow_share", [0.992, 1.0, 1.008])
def test_slower_samples_are_the_nearest_in_time(tmp_path, stated_share, slow_share):
    streams = [timed(RATE * stated_share), timed_slow((0.0, SECONDS), rate=SLOW * slow_share)]
    (pinch,) = import_recordings(xdf(tmp_path, *streams), tmp_path / "out")
    seconds, values = pinch.group("100_hz")
    beside = np.rint(seconds * RATE).astype(int)
    assert len(values) == np.ceil(len(pinch.data) / RATE * SLOW)
    distances = np.abs(values[:, 0] - pinch.data[beside, 0]) * SLOW * slow_share
    assert distances[:-1].max() <= 0.51
    assert distances[-1] <= 1.5  # the slower stream may end before the vibration


@pytest.mark.parametrize(
    "stretches",
    [
        [(0.0, SECONDS - 0.2)],
        [(0.2, SECONDS)],
        [(0.0, 3.0), (5.0, SECONDS)],
        [(0.3, 3.0), (5.0, SECONDS - 0.7)],
    ],
)
def test_vibration_is_kept_where_the_slower_stream_has_samples(tmp_path, stretches):
    path = xdf(tmp_path, timed(RATE), timed_slow(*stretches))
    dataset = import_recordings(path, tmp_path / "out")
    assert len(dataset) == len(stretches)
    for pinch, (begin, end) in zip(dataset, stretches, strict=True):
        assert pinch.data[[0, -1], 0] == pytest.approx([begin, end], abs=3 / SLOW)
        seconds, values = pinch.group("100_hz")
        beside = pinch.data[np.rint(seconds * RATE).astype(int), 0]
        assert values[:, 0] == pytest.approx(beside, abs=2.6 / SLOW)
    assert any("left out" in note for note in dataset.notes)


def test_streams_of_seconds_go_along(tmp_path):
    warmth = stream(2, "warmth", 1.0, "float32", times(8, 1.0), np.arange(8.0))
    (pinch,) = import_recordings(xdf(tmp_path, timed(RATE), warmth), tmp_path / "out")
    _, values = pinch.group("1_hz")
    assert values[:, 0].tolist() == list(range(8))
