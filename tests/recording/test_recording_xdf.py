"""XDF files, written byte by byte so that tests can damage them."""

import math
import struct
from typing import Any

import numpy as np
import pytest
from import_files import imported

from firstcontact import import_recordings
from firstcontact.core import InputError, VibrationSensor
from firstcontact.recording.settings import LOWEST_RATE

pytest.importorskip("pyxdf")
RATE, SLOW = 4000.0, 100.0
SAMPLES = 8000
MARKS = ((0.5, "eraser; shore_a=40"), (1.25, "foam; shore_a=20"))
Values = np.ndarray[Any, np.dtype[Any]]


def chunk(tag, content):
    return b"\x04" + struct.pack("<IH", len(content) + 2, tag) + content


def stream(number, name, rate, kind, stamps, values, foot=True):
    """Return one stream: header, samples in chunks of 0.1 s, a clock offset and footer."""
    numbers = np.zeros((len(stamps), 1)) if kind == "string" else np.asarray(values)
    numbers = (numbers.reshape(len(stamps), -1) if numbers.size else np.zeros((0, 1))).astype("<f4")
    width = numbers.shape[1]
    samples = np.zeros(len(stamps), [("size", "u1"), ("stamp", "<f8"), ("values", "<f4", (width,))])
    samples["size"], samples["stamp"], samples["values"] = 8, stamps, numbers
    xml = (
        f"<?xml version='1.0'?><info><name>{name}</name><type>x</type><channel_count>{width}"
        f"</channel_count><nominal_srate>{rate}</nominal_srate><channel_format>{kind}"
        "</channel_format><created_at>1</created_at><desc/></info>"
    )
    of = struct.pack("<I", number)
    parts = [chunk(2, of + xml.encode())]
    for start in range(0, len(stamps), 400):
        chunk_range = range(start, min(start + 400, len(stamps)))
        body = of + b"\x04" + struct.pack("<I", len(chunk_range))
        if kind != "string":
            body += samples[start : chunk_range.stop].tobytes()
            parts.append(chunk(3, body))
            continue
        for i in chunk_range:
            text = values[i].encode()
            body += b"\x08" + struct.pack("<d", stamps[i])
            body += b"\x04" + struct.pack("<I", len(text)) + text
        parts.append(chunk(3, body))
    for at in (0.0, 100.0):
        parts.append(chunk(4, of + struct.pack("<dd", at, 0.0)))
    if foot:
        parts.append(
            chunk(6, of + b"<?xml version='1.0'?><info><sample_count>1</sample_count></info>")
        )
    return b"".join(parts)


def times(n, rate, jitter=0.0, begin=50.0):
    rng = np.random.default_rng(1)
    return begin + np.arange(n) / rate + jitter * rng.uniform(-1, 1, n)


def vibration(name="finger", number=1, **changes):
    fields = {"rate": RATE, "kind": "float32", "stamps": times(SAMPLES, RATE, 0.0004)}
    fields |= {"values": np.arange(SAMPLES, dtype=np.float32)} | changes
    return stream(number, name, **fields)


def slow(**changes):
    fields = {"stamps": times(200, SLOW), "values": np.arange(400.0).reshape(200, 2)} | changes
    return stream(2, "grip", SLOW, "float32", **fields)


def marks(number=3, name="marks", texts=MARKS):
    return stream(number, name, 0.0, "string", [50.0 + t for t, _ in texts], [x for _, x in texts])


def xdf(tmp_path, *streams):
    path = tmp_path / "taps.xdf"
    head = chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>")
    path.write_bytes(b"XDF:" + head + b"".join(streams))
    return path


def test_markers_are_contacts_and_slower_streams_go_along(tmp_path):
    dataset = imported(xdf(tmp_path, vibration(), slow(), marks()), tmp_path / "out")
    assert dataset.objects.tolist() == ["eraser", "foam"]
    assert dataset.shore_a.tolist() == [40, 20]
    assert dataset.sessions.tolist() == ["taps", "taps"]
    assert dataset.layout.vibration[0].sensor is VibrationSensor.PIEZO
    for pinch, (at, _) in zip(dataset.pinches, MARKS, strict=True):
        # A line through jittering stamps is right to a fraction of a sample.
        assert pinch.data[pinch.first.sample - pinch.first_sample, 0] == pytest.approx(
            at * RATE, abs=1
        )
        seconds, values = pinch.group("100_hz")
        begin = pinch.first_sample / RATE
        assert values[:, 0] / 2 / SLOW == pytest.approx(begin + seconds, abs=1.1 / SLOW)


def test_a_table_names_the_stream_and_its_column(tmp_path):
    columns = np.stack([np.zeros(SAMPLES), np.arange(SAMPLES)], axis=1)
    path = xdf(tmp_path, vibration(values=columns), marks())
    with pytest.raises(InputError, match="channels"):
        import_recordings(path, tmp_path / "out")
    table = tmp_path / "channels.csv"
    table.write_text("variable,sensor,column\nfinger,microphone,1\n")
    pinch = import_recordings(path, tmp_path / "out", channels=table)[0]
    assert pinch.layout.vibration[0].sensor is VibrationSensor.MICROPHONE
    assert pinch.data[0, 0] > 0


@pytest.mark.parametrize("column", ["onset_s", "onset_sample"])
@pytest.mark.parametrize("late", [False, True])
def test_event_times_start_at_the_vibration(tmp_path, column, late):
    # Behind a gap, and where the part before it is left out: another stream began later.
    stamps = times(SAMPLES, RATE)
    stamps[SAMPLES // 2 :] += 3.0
    behind = stamps[SAMPLES // 2] - stamps[0]
    streams = [vibration(stamps=stamps)]
    if late:
        begin = float(stamps[SAMPLES // 2]) - 0.1
        streams.append(slow(stamps=times(200, SLOW, begin=begin)))
    table = tmp_path / "events.csv"
    expected = SAMPLES // 2 + round(0.5 * RATE)
    table.write_text(f"{column}\n{behind + 0.5 if column == 'onset_s' else expected}\n")
    (pinch,) = import_recordings(xdf(tmp_path, *streams), tmp_path / "out", events=table)
    assert pinch.data[pinch.first.sample - pinch.first_sample, 0] == pytest.approx(expected, abs=1)


def test_markers_outside_the_kept_samples_are_skipped_with_a_note(tmp_path):
    # The first half is left out, since the other stream began behind the gap.
    stamps = times(SAMPLES, RATE)
    stamps[SAMPLES // 2 :] += 3.0
    late = slow(stamps=times(200, SLOW, begin=float(stamps[SAMPLES // 2]) - 0.1))
    texts = ((0.5, "left out"), (2.5, "in the gap"), (4.5, "kept"))
    path = xdf(tmp_path, vibration(stamps=stamps), late, marks(texts=texts))
    dataset = import_recordings(path, tmp_path / "out")
    assert dataset.objects.tolist() == ["kept"]
    assert any("2 of 3 contacts" in note for note in dataset.notes)
    for lost in (texts[:2], ((9.0, "beyond"),)):
        path = xdf(tmp_path, vibration(stamps=stamps), late, marks(texts=lost))
        with pytest.raises(InputError, match=path.name):
            import_recordings(path, tmp_path / "none")


def test_numbers_without_a_rate_are_left_out_with_a_note(tmp_path):
    codes = stream(4, "triggers", 0.0, "float32", [50.5, 51.0], [5.0, 6.0])
    seldom = stream(5, "seldom", 0.5, "float32", times(2, 0.5), np.zeros(2))
    path = xdf(tmp_path, vibration(), marks(), codes, seldom)
    notes = import_recordings(path, tmp_path / "out").notes
    assert any("triggers" in note and "seldom" in note for note in notes)


def test_without_markers_the_file_is_one_pinch_to_label(tmp_path):
    (pinch,) = import_recordings(xdf(tmp_path, vibration()), tmp_path / "out")
    assert pinch.first is None
    assert len(pinch.data) == SAMPLES


BACKWARDS = times(SAMPLES, RATE)
BACKWARDS[4000:] -= 0.5
TOO_FEW = times(SAMPLES, 1.1 * RATE)
NO_TIME = times(SAMPLES, RATE)
NO_TIME[7] = np.nan
STANDING = np.full(SAMPLES, 50.0)
HOLED = np.arange(SAMPLES, dtype=np.float32)
HOLED[9] = np.nan


@pytest.mark.parametrize(
    "stale",
    [
        vibration(number=9, stamps=[], values=np.zeros((0, 1))),
        vibration("old", 9, stamps=[], values=np.zeros((0, 1))),
        marks(9, texts=()),
    ],
)
@pytest.mark.parametrize("is_first", [False, True])
def test_an_empty_stream_leaves_its_name_to_another(tmp_path, stale, is_first):
    streams = [vibration(), marks()]
    path = xdf(tmp_path, *([stale, *streams] if is_first else [*streams, stale]))
    dataset = imported(path, tmp_path / "out")
    assert dataset.objects.tolist() == ["eraser", "foam"]
    assert any("without samples" in note for note in dataset.notes)


def test_streams_of_one_name_are_told_apart_by_their_number(tmp_path):
    channels = tmp_path / "channels.csv"
    channels.write_text("variable,sensor,finger\nfinger #2,piezo,thumb\n")
    negative = -np.arange(SAMPLES, dtype=np.float32)
    path = xdf(tmp_path, vibration(), vibration(number=2, values=negative), marks())
    dataset = imported(path, tmp_path / "out", "--channels", str(channels))
    assert (dataset[0].data < 0).all()


@pytest.mark.parametrize("stated", [0, 2000, RATE])
def test_the_measured_rate_replaces_a_wrong_one(tmp_path, stated):
    channels = tmp_path / "channels.csv"
    channels.write_text("variable,sensor,rate_hz\nfinger,piezo,4400\n")
    path = xdf(tmp_path, vibration(rate=stated, stamps=TOO_FEW), marks())
    dataset = imported(path, tmp_path / "out", "--channels", str(channels))
    assert dataset.layout.rate == 1.1 * RATE


def test_a_file_may_have_any_rate_that_live_accepts(tmp_path):
    stamps = times(1000, LOWEST_RATE)
    slowest = vibration(rate=LOWEST_RATE, stamps=stamps, values=np.arange(1000.0))
    path = xdf(tmp_path, slowest, marks())
    assert imported(path, tmp_path / "out").layout.rate == LOWEST_RATE


@pytest.mark.parametrize(
    ("streams", "words"),
    [
        ((vibration(), vibration(number=2)), ("finger #1, finger #2", "--channels")),
        (
            (vibration(), vibration("slower", 2, rate=RATE / 2)),
            ("2 streams of numbers", "--channels"),
        ),
        ((vibration(), vibration("other", 2)), ("2 streams of numbers", "--channels")),
        ((vibration(stamps=BACKWARDS), marks()), ("go back by 0.5 s", "sample 4000")),
        ((vibration(stamps=TOO_FEW), marks()), ("4000 Hz", "4400 Hz")),
        ((vibration(stamps=NO_TIME), marks()), ("finger", "sample 7")),
        ((vibration(), marks(texts=((1e30, "far"),))), ("marks", "1e+30")),
        ((vibration(stamps=STANDING), marks()), ("4000 Hz", "do not advance")),
        ((vibration(rate=math.nan), marks()), ("finger", "nan Hz")),
        ((vibration(values=HOLED), marks()), ("NaN", "(9, 0)")),
        ((vibration(), marks(), marks(4, "more")), ("more", "--events")),
        ((vibration(), marks(texts=((5.0, "late"),))), ("marker 1",)),
        ((vibration(), marks(texts=((0.5, "weight=3"),))), ("marker 1", "weight=3")),
        ((), ("0 streams",)),
    ],
)
def test_invalid_streams_are_refused(tmp_path, check_refused, streams, words):
    check_refused(xdf(tmp_path, *streams), *words)


def test_truncated_file_is_refused_or_noted(tmp_path):
    path = xdf(tmp_path, vibration(), marks())
    content = path.read_bytes()
    for place, keep in enumerate((0, 3, 50, 3000, len(content) // 2, len(content) - 30)):
        path.write_bytes(content[:keep])
        try:
            notes = import_recordings(path, tmp_path / f"out{place}").notes
        except InputError:
            assert not (tmp_path / f"out{place}").exists()
        else:
            assert any("finger" in note for note in notes)
