"""Long sound files with a table of their contacts, or an Audacity label track."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from import_files import npz
from scipy.io import wavfile

import firstcontact as fc
from firstcontact import import_recordings
from firstcontact.cli.main import main
from firstcontact.core import Finger
from firstcontact.recording import load_dataset
from firstcontact.recording.events import AFTER, BEFORE
from firstcontact.recording.sound import import_events

RATE = 8000
SAMPLES = 20_000


@pytest.fixture
def folder(tmp_path):
    """Write two long files in which each sample is its number, so a cut pinch shows its place."""
    (tmp_path / "in").mkdir()
    count = np.arange(SAMPLES, dtype=np.int16)
    wavfile.write(tmp_path / "in" / "mono.wav", RATE, count)
    wavfile.write(tmp_path / "in" / "stereo.wav", RATE, np.stack([count, -count], axis=1))
    return tmp_path / "in"


def table(folder, *lines):
    path = folder / "events.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_seconds_and_samples_give_the_same_contacts(folder, tmp_path):
    contacts = []
    for name, cells in (("onset_s", ("0.25", "1.5")), ("onset_sample", ("2000", "12000"))):
        events = table(folder, f"{name},shore_a", *(f"{cell},20" for cell in cells))
        out = tmp_path / name
        words = ["--events", str(events), "--sensor", "piezo", "--source", "real"]
        assert main(["import", str(folder / "mono.wav"), "--out", str(out), *words]) == 0
        dataset = load_dataset(out)
        contacts.append([(p.data[:, 0].tolist(), p.first) for p in dataset.pinches])
        for pinch, onset in zip(dataset.pinches, (2000, 12_000), strict=True):
            assert pinch.first.finger is Finger.INDEX
            assert pinch.data[pinch.first.sample - pinch.first_sample, 0] == onset
            assert len(pinch.data) == (BEFORE + AFTER) * RATE
    assert contacts[0] == contacts[1]
    assert dataset.layout.rate == RATE
    assert set(dataset.sessions) == {"mono"}


@given(st.lists(st.integers(0, SAMPLES - 1), min_size=1, max_size=12, unique=True))
def test_cuts_contain_their_contact_and_do_not_overlap(onsets):
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "long.wav"
        wavfile.write(path, RATE, np.arange(SAMPLES, dtype=np.int16))
        events = table(Path(place), "onset_sample", *map(str, onsets))
        dataset = import_events(path, events=events)
    used_samples: list[int] = []
    for pinch, onset in zip(dataset.pinches, onsets, strict=True):
        samples = pinch.data[:, 0].tolist()
        assert samples[pinch.first.sample - pinch.first_sample] == onset
        assert onset - BEFORE * RATE <= samples[0] <= samples[-1] < onset + AFTER * RATE
        used_samples += samples
    assert len(used_samples) == len(set(used_samples))


def test_one_of_many_channels_is_selected(folder, tmp_path, check_refused):
    many = np.stack([np.arange(SAMPLES, dtype=np.int16) + k for k in range(4)], axis=1)
    wavfile.write(folder / "many.wav", RATE, many)
    path = folder / "many.wav"
    check_refused(path, "4 channels", "column 'channel'")
    events = table(folder, "onset_sample", "9000")
    check_refused(path, "column 'channel'", events=events)
    events = table(folder, "onset_sample,channel", "9000,3")
    (pinch,) = import_events(folder / "many.wav", events=events).pinches
    assert pinch.data[pinch.first.sample - pinch.first_sample].tolist() == [9003]


def test_channel_column_selects_the_channel(folder):
    events = table(
        folder,
        "file,onset_sample,channel,object,hardness_class",
        "stereo.wav,9000,1,mat,soft",
        "mono.wav,9000,0,table,hard",
    )
    dataset = import_events(folder, events=events)
    assert [p.data[640, 0] for p in dataset.pinches] == [-9000, 9000]
    assert dataset.objects.tolist() == ["mat", "table"]
    assert dataset.sessions.tolist() == ["stereo", "mono"]
    assert dataset.hardness_rank.tolist() == [0, 2]


def test_skipped_rows_and_files_are_counted(folder):
    rows = ("file,onset_sample,channel,remark", "mono.wav,9000,0,loud", "stereo.wav,9000,0,")
    events = table(folder, *rows)
    notes = " ".join(import_events(folder / "mono.wav", events=events).notes)
    assert "1 contacts of the table are in other files" in notes
    assert "remark" in notes
    notes = " ".join(import_events(folder, events=table(folder, *rows[:2])).notes)
    assert "1 sound files have no contact in events.csv" in notes


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (("file,object", "mono.wav,mat"), ("onset_s", "onset_sample")),
        (("file,onset_s,onset_sample", "mono.wav,1,8000"), ("onset_s and onset_sample",)),
        (("file,onset_s", "mono.wav,soon"), ("'onset_s' of line 2", "soon", "not a number")),
        (("file,onset_s", "mono.wav,2.5"), ("line 2", "outside mono.wav", "2.49987 s")),
        (("file,onset_sample", "mono.wav,-1"), ("line 2", "outside mono.wav", "19999")),
        (("file,onset_sample", "mono.wav,12.5"), ("line 2", "whole number")),
        (("file,onset_sample", "other.wav,12"), ("line 2", "other.wav", "is not in")),
        (("onset_sample", "12"), ("no column 'file'",)),
        (("file,onset_sample", "mono.wav,9", "mono.wav,9"), ("line 2 and line 3", "same contact")),
        (("file,onset_sample,channel", "mono.wav,9,1"), ("'channel' of line 2", "has 1")),
        (("file,onset_sample,first_contact", "mono.wav,9,1"), ("first_contact",)),
        (("file,onset_sample", "mono.wav,9", "stereo.wav,9"), ("2 channels", "1 of int16")),
        (("file,onset_sample,shore_a", "mono.wav,9,200"), ("'shore_a' of line 2", "200")),
    ],
)
def test_invalid_event_table_is_refused(folder, check_refused, lines, words):
    check_refused(folder, *words, events=table(folder, *lines))


def test_events_are_for_sound_files_only(folder, check_refused, tmp_path):
    events = table(folder, "onset_s", "1")
    (tmp_path / "some.npz").write_bytes(b"")
    check_refused(tmp_path / "some.npz", "events", events=events)
    check_refused(folder / "mono.wav", "none.csv", events=tmp_path / "none.csv")
    other_events = table(folder, "file,onset_s", "stereo.wav,1")
    check_refused(folder / "mono.wav", "no row is for", "mono.wav", events=other_events)


def taps(folder, *names):
    """Write sound files of three taps each, in both channels within 20 ms."""
    folder.mkdir()
    rng = np.random.default_rng(0)
    tap = 0.5 * np.exp(-np.arange(240) / 40) * np.sin(np.arange(240))
    for name in names:
        signal = rng.normal(0, 1e-3, (SAMPLES, 2))
        for onset in TAPS:
            signal[onset : onset + 240, 0] += tap
            signal[onset + 150 : onset + 390, 1] += tap
        wavfile.write(folder / name, RATE, signal.astype(np.float32))
    return folder


TAPS = (4000, 9000, 15000)


def test_each_tap_found_becomes_a_pinch_that_nobody_confirmed(tmp_path):
    folder = taps(tmp_path / "in", "eraser.wav", "foam.wav")
    dataset = fc.import_recordings(folder, tmp_path / "own", find=True)
    assert dataset.objects.tolist() == ["eraser"] * 3 + ["foam"] * 3
    assert [pinch.truth for pinch in dataset] == [()] * 6
    table(folder, "file,shore_a", "eraser.wav,40", "foam.wav,20").rename(folder / "labels.csv")
    dataset = fc.import_recordings(folder, tmp_path / "labelled", find=True)
    assert dataset.shore_a.tolist() == [40.0] * 3 + [20.0] * 3
    contacts = fc.detect(dataset)
    assert {round(c.sample - p.first_sample, -2) for c, p in zip(contacts, dataset, strict=True)
            if c is not None} == {600}  # fmt: skip
    one = fc.import_recordings(folder / "foam.wav", tmp_path / "one", find=True)
    assert len(one) == 3


@pytest.mark.parametrize("kind", ["npz", "events", "silence"])
def test_contacts_are_only_searched_in_sounds_that_have_some(tmp_path, kind):
    folder = taps(tmp_path / "in", "eraser.wav")
    path, options = folder / "eraser.wav", {}
    if kind == "npz":
        path = npz(tmp_path)
    elif kind == "events":
        options = {"events": table(tmp_path, "onset_s", "1")}
    else:
        wavfile.write(path, RATE, np.zeros(SAMPLES, np.int16))
    with pytest.raises(fc.InputError) as refused:
        fc.import_recordings(path, tmp_path / "own", find=True, **options)
    assert refused.value.parameter == ("" if kind == "silence" else "find")


def flac(tmp_path, subtype="PCM_16"):
    soundfile = pytest.importorskip("soundfile")
    path = tmp_path / f"{subtype}.flac"
    soundfile.write(path, np.arange(SAMPLES, dtype=np.int16), RATE, subtype)
    return path


def track(tmp_path, text):
    path = tmp_path / "labels.txt"
    path.write_bytes(text.encode(errors="surrogateescape"))
    return path


LABELS = (
    "0.250000\t0.250000\teraser; shore_a=40; session=monday\n\\\t100\t200\n"
    "0,5\t0,75\tshore_a=20; object=foam; session=monday\r\n"
)


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24"])
def test_flac_imports_like_its_wav(folder, tmp_path, subtype):
    events = track(tmp_path, LABELS)
    from_wav = import_recordings(folder / "mono.wav", tmp_path / "wav", events=events)
    from_flac = import_recordings(flac(tmp_path, subtype), tmp_path / "flac", events=events)
    for a, b in zip(from_wav.pinches, from_flac.pinches, strict=True):
        assert np.array_equal(a.vibration(), b.vibration())
        assert a.truth == b.truth
    assert from_wav.objects.tolist() == ["eraser", "foam"]
    assert from_wav.shore_a.tolist() == [40, 20]
    assert [p.data[p.first.sample - p.first_sample, 0] for p in from_wav] == [2000, 4000]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ("no labels",)),
        ("one two three\n", ("line 1", "no label")),
        ("0.5\t0.25\tback\n", ("line 1",)),
        ("nan\tnan\tx\n", ("line 1",)),
        ("2.5\t2.5\tx\n", ("line 1", "outside")),
        ("0.1\t0.1\tsize=3\n", ("line 1", "size=3")),
        ("0.1\t0.1\tshore_a=3\n0.2\t0.2\tfoam\n", ("line 2", "shore_a")),
        ("0.1\t0.1\tshore_a=300\n", ("'shore_a' of line 1",)),
        ("0.1\t0.1\n0.1\t0.1\n", ("same contact",)),
        ("\udcff", ("UTF-8",)),
    ],
)
def test_invalid_label_track_is_refused(folder, tmp_path, check_refused, text, words):
    check_refused(folder / "mono.wav", *words, events=track(tmp_path, text))


def test_a_damaged_flac_is_refused(tmp_path, check_refused):
    content = flac(tmp_path).read_bytes()
    events = track(tmp_path, LABELS)
    for name, raw in (("cut", content[:-4000]), ("none", b""), ("noise", bytes(range(256)) * 20)):
        path = tmp_path / f"{name}.flac"
        path.write_bytes(raw)
        check_refused(path, path.name, events=events)
