"""Labelling without the page: actions, undo, the journal and the new recordings."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from taps import RATE, taps, write_taps

from firstcontact import import_recordings
from firstcontact.cli.main import main
from firstcontact.collect._label_marks import Action, Mark, Marks, Status
from firstcontact.collect.label_result import Labeller
from firstcontact.collect.label_session import Session, open_recordings
from firstcontact.core import ClosingSpeed, InputError, Label, Role
from firstcontact.core.quantity import QUANTITIES
from firstcontact.recording import load_dataset, read_recording
from processes import full_disk

BY = Labeller("Ada", "2026-01-02", "a test")


def session(tmp_path: Path, n: int = 8) -> Session:
    path = tmp_path / "taps.mcap"
    if not path.exists():
        write_taps(path, n)
    return Session(open_recordings([path]), tmp_path / "out", BY)


def send(labelling: Session, **message: Any) -> dict[str, Any]:
    return labelling.obey(json.dumps(message))


def test_labels_go_into_a_new_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    labelling = session(tmp_path)
    original = (tmp_path / "taps.mcap").read_bytes()
    places = taps(8)
    onsets = labelling.hello()["marks"]
    assert [m["sample"] for m in onsets] == pytest.approx(places, abs=2)
    send(labelling, do="label", number=0, object="eraser", shore_a=40)
    send(labelling, do="label", number=4, object="foam", shore_a=20)
    for number in range(6):
        send(labelling, do="accept", number=number)
    send(labelling, do="reject", number=6)
    send(labelling, do="move", number=5, sample=int(places[5]) + 16)
    send(labelling, do="add", number=0, sample=int(places[7]) + 1000)
    assert labelling.obey('{"ask": "finish"}')["finished"]
    labelling.close()
    assert (tmp_path / "taps.mcap").read_bytes() == original
    dataset = load_dataset(tmp_path / "out" / "taps.mcap")
    firsts = [p.first.sample for p in dataset.pinches if p.first]
    expected = [*onsets[:5], {"sample": places[5] + 16}, {"sample": places[7] + 1000}]
    assert firsts == [m["sample"] for m in expected]
    assert dataset.objects.tolist() == ["eraser"] * 4 + ["foam"] * 3
    assert dataset.shore_a.tolist() == [40] * 4 + [20] * 3
    old, new = (read_recording(p) for p in (tmp_path / "taps.mcap", tmp_path / "out/taps.mcap"))
    assert np.array_equal(old.stretches[0].data, new.stretches[0].data)
    assert np.array_equal(old.groups["100_hz"][0].data, new.groups["100_hz"][0].data)
    assert new.markers[0].text == "begun"
    assert main(["inspect", str(tmp_path / "out" / "taps.mcap")]) == 0
    output = capsys.readouterr().out
    assert "labelled by Ada on 2026-01-02 with a test" in output
    assert "6 accepted (1 of them moved), 1 rejected, 1 not looked at; 1 onset added" in output
    assert "moved by +2.00 ms by Ada" in output
    assert "added by Ada" in output


@pytest.mark.parametrize("name", ["modulus_mpa", "stiffness_n_per_mm"])
def test_a_label_may_state_another_quantity(tmp_path: Path, name: str) -> None:
    labelling = session(tmp_path)
    send(labelling, do="label", number=0, object="spring", **{name: 15})
    for number in range(3):
        send(labelling, do="accept", number=number)
    assert labelling.obey('{"ask": "finish"}')["finished"]
    labelling.close()
    dataset = load_dataset(tmp_path / "out" / "taps.mcap")
    assert dataset.quantity is QUANTITIES[name]
    assert dataset.label_values(dataset.quantity).tolist() == [15] * 3


def test_crash_keeps_every_confirmed_label(tmp_path: Path) -> None:
    labelling = session(tmp_path)
    send(labelling, do="accept", number=0)
    send(labelling, do="reject", number=1)
    labelling.close()
    journal = tmp_path / "out" / "labels.jsonl"
    content = journal.read_bytes()
    for cut in range(len(content.splitlines(keepends=True)[0]), len(content) + 1):
        journal.write_bytes(content[:cut])
        reopened = session(tmp_path)
        lines = content[:cut].count(b"\n") - 1
        assert len(reopened.marks.done) == lines
        send(reopened, do="accept", number=2)
        reopened.close()
        assert len(journal.read_bytes().splitlines()) == lines + 2


FINISH = ["taps.mcap", "--out", "out", "--finish"]


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda raw: bytes(len(raw)), "damaged"),
        (lambda raw: bytes(100) + raw[100:], "damaged|line 1"),
        (lambda raw: raw.replace(b"reject", bytes(6)), "line 3"),
        (lambda raw: raw[: raw.index(b"\n") + 1], "holds no labels"),
        (lambda raw: raw[:20], "holds no labels"),
        (lambda raw: b"", "holds no labels"),
        (lambda raw: None, "holds no labels"),
        (lambda raw: raw + b'{"do": "undo"}\n' * 3, "no onset is labelled"),
    ],
)
def test_finish_without_readable_labels_is_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    damage: Callable[[bytes], bytes | None],
    problem: str,
) -> None:
    labelling = session(tmp_path)
    send(labelling, do="accept", number=0)
    send(labelling, do="reject", number=1)
    send(labelling, do="accept", number=2)
    labelling.close()
    journal = tmp_path / "out" / "labels.jsonl"
    raw = damage(journal.read_bytes())
    if raw is None:
        journal.unlink()
        journal.parent.rmdir()
    else:
        journal.write_bytes(raw)
    monkeypatch.chdir(tmp_path)
    assert main(["label", *FINISH]) == 2
    error = capsys.readouterr().err
    assert re.search(problem, error)
    if raw is None:
        assert not journal.parent.exists()
    else:
        assert [p.name for p in journal.parent.iterdir()] == ["labels.jsonl"]
        assert journal.read_bytes() == raw


def test_labels_before_a_damaged_end_are_preserved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    labelling = session(tmp_path)
    send(labelling, do="accept", number=3)
    labelling.close()
    with (tmp_path / "out" / "labels.jsonl").open("ab") as stream:
        stream.write(bytes(77))
    monkeypatch.chdir(tmp_path)
    assert main(["label", *FINISH]) == 0
    assert "1 labelling step restored" in (output := capsys.readouterr().out)
    assert "labels.jsonl ends in 77 bytes" in output
    assert len(load_dataset(tmp_path / "out" / "taps.mcap")) == 1


def test_journal_of_other_recordings_is_refused(tmp_path: Path) -> None:
    session(tmp_path).close()
    journal = tmp_path / "out" / "labels.jsonl"
    journal.write_text(journal.read_text().replace("taps.mcap", "other.mcap"))
    with pytest.raises(InputError, match=r"labels\.jsonl"):
        session(tmp_path)
    journal.write_text("{}\n")
    with pytest.raises(InputError, match="line 1"):
        session(tmp_path)


MARKS = [Mark(k, 0, 0, 0, 100 * k, 100 * k) for k in range(5)]
ACTIONS = st.builds(
    Action,
    do=st.sampled_from(["accept", "reject", "move", "add", "label", "undo"]),
    number=st.integers(0, 6),
    sample=st.integers(0, 600),
    object=st.sampled_from(["a", "b"]),
)


@given(st.lists(ACTIONS, max_size=20))
def test_undo_reverts_the_last_action_and_order_follows_time(actions: list[Action]) -> None:
    marks = Marks(MARKS, [[500]])
    past = [marks.ordered()]
    for action in actions:
        try:
            marks.act(action)
        except InputError:
            assert marks.ordered() == past[-1]
            continue
        if action.do == "undo":
            past.pop()
            assert marks.ordered() == past[-1]
        else:
            past.append(marks.ordered())
    samples = [m.sample for m in marks.ordered()]
    assert samples == sorted(samples)
    for _ in range(len(marks.done)):
        marks.act(Action("undo"))
    assert marks.ordered() == MARKS
    assert {m.status for m in marks.ordered()} == {Status.FOUND}


@pytest.mark.parametrize(
    "message",
    [
        "",
        "{}",
        "[]",
        '{"do": "dance"}',
        '{"do": "accept", "number": 99}',
        '{"do": "move", "number": 0, "sample": 99999999}',
        '{"do": "move", "number": 0, "sample": -1}',
        '{"do": "label", "number": 0, "shore_a": 101}',
        '{"do": "label", "number": 0, "stiffness_n_per_mm": 0}',
        '{"do": "undo"}',
        '{"ask": "signal", "recording": 9}',
        '{"ask": "signal", "half": 1e9}',
        '{"do": "label", "number": 0, "object": "%s"}' % ("x" * 5000),
    ],
)
def test_invalid_requests_are_refused_and_change_nothing(tmp_path: Path, message: str) -> None:
    labelling = session(tmp_path)
    state = labelling.hello()
    with pytest.raises(InputError):
        labelling.obey(message)
    assert labelling.hello() == state
    labelling.close()


def test_view_is_the_signal_envelope_at_any_zoom(tmp_path: Path) -> None:
    labelling = session(tmp_path)
    data = read_recording(tmp_path / "taps.mcap").stretches[0].data[:, 0] * 0.001
    for half in (0.005, 0.02, 2.0):
        at = int(taps(8)[1])
        view = send(labelling, ask="signal", number=1, sample=at, half=half)["signal"]
        first, step = view["first"], view["step"]
        assert first == max(0, at - round(half * RATE))
        for k, (least, most) in enumerate(zip(view["least"][0], view["most"][0], strict=True)):
            piece = data[first + k * step : first + (k + 1) * step]
            if first + (k + 1) * step <= at + round(half * RATE):
                assert least == pytest.approx(piece.min(), rel=1e-5, abs=1e-9)
                assert most == pytest.approx(piece.max(), rel=1e-5, abs=1e-9)
    labelling.close()


def test_bad_paths_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_taps(tmp_path / "taps.mcap", 2)
    out = str(tmp_path / "out")
    assert main(["label", str(tmp_path / "none.mcap"), "--out", out]) == 2
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "taps.mcap").write_bytes(b"")
    assert main(["label", str(path), "--out", out, "--finish"]) == 2
    assert "never overwritten" in capsys.readouterr().err
    assert (tmp_path / "out" / "taps.mcap").read_bytes() == b""
    for port in ("99999", "-1"):
        assert main(["label", str(path), "--out", str(tmp_path / "new"), "--port", port]) == 2
        assert f"port {port} " in capsys.readouterr().err
    assert main(["label", str(path), str(path), "--out", str(tmp_path / "new")]) == 2
    assert "two recordings are called taps.mcap" in capsys.readouterr().err


def test_action_is_undone_if_the_disk_is_full(tmp_path: Path) -> None:
    labelling = session(tmp_path)
    send(labelling, do="accept", number=0)
    state, journal = labelling.hello(), tmp_path / "out" / "labels.jsonl"
    with full_disk(journal.stat().st_size + 5), pytest.raises(InputError, match=r"labels\.jsonl"):
        send(labelling, do="reject", number=1)
    assert labelling.hello() == state
    send(labelling, do="accept", number=2)
    labelling.close()
    reopened = session(tmp_path)
    assert [a.number for a in reopened.marks.done] == [0, 2]
    reopened.close()


def test_folder_in_use_is_refused(tmp_path: Path) -> None:
    labelling = session(tmp_path)
    send(labelling, do="accept", number=0)
    with pytest.raises(InputError, match=r"labels\.jsonl"):
        session(tmp_path)
    send(labelling, do="accept", number=1)
    labelling.close()
    reopened = session(tmp_path)
    assert len(reopened.marks.done) == 2
    reopened.close()


def test_finish_writes_all_recordings_or_none(tmp_path: Path) -> None:
    paths = [write_taps(tmp_path / name, 2) for name in ("a.mcap", "b.mcap")]
    out = tmp_path / "out"
    labelling = Session(open_recordings(paths), out, BY)
    send(labelling, do="accept", number=0)
    (out / "b.mcap").write_bytes(b"of somebody else")
    with pytest.raises(InputError, match=r"b\.mcap"):
        send(labelling, ask="finish")
    assert not labelling.written
    assert sorted(p.name for p in out.iterdir()) == ["b.mcap", "labels.jsonl"]
    (out / "b.mcap").unlink()
    send(labelling, do="accept", number=1)
    send(labelling, ask="finish")
    labelling.close()
    assert [len(read_recording(p).pinches) for p in labelling.written] == [2, 0]


def test_two_onsets_at_one_sample_are_written(tmp_path: Path) -> None:
    labelling = session(tmp_path)
    at = labelling.hello()["marks"][2]["sample"]
    send(labelling, do="accept", number=2)
    for sample in (at, at, at + 1):
        send(labelling, do="add", number=2, sample=sample)
    send(labelling, ask="finish")
    labelling.close()
    dataset = load_dataset(tmp_path / "out" / "taps.mcap")
    assert [p.first.sample for p in dataset.pinches if p.first] == [at, at, at, at + 1]


@pytest.mark.parametrize("seconds", [1.0, 6.0])
@pytest.mark.parametrize("taps_of_pinch", [1, 2])
def test_a_pinch_of_any_length_keeps_its_label(
    tmp_path: Path, seconds: float, taps_of_pinch: int
) -> None:
    signal = np.random.default_rng(0).normal(0, 0.002, (2, round(seconds * RATE), 1))
    ring = np.exp(-np.arange(100) / 20) * np.sin(np.arange(100))
    for at in (4000, 6000)[:taps_of_pinch]:
        signal[:, at : at + 100, 0] += ring
    labels = [
        Label("pear", 20.0, 3, "pear-1", "monday", Role.TEST),
        Label("apple", 30.0, 1, "apple-7", "monday", Role.TRAIN),
    ]
    columns = {name: [v.to_json()[name] for v in labels] for name in Label().to_json()}
    np.savez(
        tmp_path / "x.npz",
        piezo=signal.astype(np.float32),
        sample_rate_hz=RATE,
        piezo_unit="V",
        closing_speed=[0.1, 0.2],
        closing_speed_error=[0.01, 0.02],
        **columns,
    )
    import_recordings(tmp_path / "x.npz", tmp_path / "original")
    labelling = Session(open_recordings([tmp_path / "original"]), tmp_path / "out", BY)
    assert len(labelling.marks) == 2 * taps_of_pinch
    for mark in labelling.marks.ordered():
        send(labelling, do="accept", number=mark.number)
    send(labelling, do="label", number=taps_of_pinch, object="plum")
    send(labelling, ask="finish")
    labelling.close()
    pinches = load_dataset(tmp_path / "out").pinches
    renamed = Label("plum", None, None, "plum", "monday", Role.TRAIN)
    assert [p.label for p in pinches] == [
        label for label in (labels[0], renamed) for _ in range(taps_of_pinch)
    ]
    # With two contacts it is unknown before which of them the speed was measured.
    speeds = (
        [ClosingSpeed(0.1, 0.01), ClosingSpeed(0.2, 0.02)] if taps_of_pinch == 1 else [None] * 4
    )
    assert [p.closing_speed for p in pinches] == speeds
