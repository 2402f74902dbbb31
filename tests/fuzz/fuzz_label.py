"""Damaged messages of the label page, and damaged journals."""

import json
from contextlib import closing, suppress
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import fuzz_mutate as mutate
import numpy as np

from firstcontact.collect.label_result import Labeller
from firstcontact.collect.label_session import Session
from firstcontact.core import Block, Channel, ChannelKind, InputError, Layout
from firstcontact.recording import Header, Recording, RecordingWriter, read_recording

RATE = 4000.0
#: Onsets of the recording that is labelled, s.
ONSETS = (0.3, 0.5, 0.7, 0.9)
BY = Labeller("Ada", "2026-01-02", "the fuzzer")


def _write(path: Path) -> None:
    """Write a recording of a few knocks."""
    rng = np.random.default_rng(3)
    signal = 0.01 * rng.standard_normal(4800)
    t = np.arange(200) / RATE
    for at in ONSETS:
        signal[round(at * RATE) :][:200] += np.exp(-t / 0.01) * np.sin(2 * np.pi * 400 * t)
    layout = Layout((Channel("disc", ChannelKind.VIBRATION, None, "V"),), RATE)
    with RecordingWriter(path, Header(layout, "real", dtype="float32")) as writer:
        writer.write(Block(signal.astype(np.float32)[:, None], 0))


@cache
def _recording() -> Recording:
    """Return the recording of a few knocks, read once."""
    with TemporaryDirectory() as folder:
        _write(Path(folder) / "knocks.mcap")
        return read_recording(Path(folder) / "knocks.mcap")


def _message(rng: Random) -> bytes:
    """Return an action of the page, or a request, sometimes with a damaged field."""
    tree: dict[str, object]
    if rng.random() < 0.3:
        tree = {
            "ask": rng.choice(("signal", "signal", "signal", "finish")),
            "number": 1, "recording": rng.choice((0, 0, 0, 1)), "stretch": rng.choice((0, 0, 0, 1)),
            "sample": rng.choice((0, 1200, 4799, 4800, 2**40)),
            "half": rng.choice((0.005, 0.02, 2.0, 0.0, 9.0)),
        }  # fmt: skip
    else:
        tree = {
            "do": rng.choice(("accept", "reject", "move", "add", "label", "undo")),
            "number": rng.choice((0, 1, 2, 3, 4, 2**40)),
            "sample": rng.choice((0, 1200, 4799, 4800)),
            "object": rng.choice(("eraser", "", "é\x1b[2J", '"ask": 1')),
            "shore_a": rng.choice((None, 0.0, 40.0, 100.0, 101.0)),
        }
    return mutate.tree(rng, tree) if rng.random() < 0.4 else json.dumps(tree).encode()


def labels(rng: Random, folder: Path) -> None:
    """Check that a refused message changes nothing, and that every accepted action is stored."""
    session = Session([_recording()], folder / "labelled", BY)
    with closing(session):
        for _ in range(rng.randrange(1, 30)):
            original = session.state()
            data = _message(rng)
            message: str | bytes = data
            if rng.random() < 0.5:
                message = data.decode(errors="replace")
            try:
                answer = session.obey(message)
            except InputError:
                assert session.state() == original, "a refused message changed something"
                continue
            json.dumps(answer, allow_nan=False).encode()
            if session.written:
                return
        finished = session.state()
    again = Session([_recording()], folder / "labelled", BY)
    with closing(again):
        assert again.state() == finished, "an answered action is lost"


def journal(rng: Random, folder: Path) -> None:
    """Check that a damaged journal is refused unchanged, or read from its beginning."""
    session = Session([_recording()], folder / "labelled", BY)
    with closing(session):
        for _ in range(rng.randrange(1, 12)):
            with suppress(InputError):
                session.obey(json.dumps({"do": rng.choice(("accept", "reject")), "number": 1}))
        finished = list(session.marks.done)
    path = folder / "labelled" / "labels.jsonl"
    raw = path.read_bytes()
    cut = rng.randrange(len(raw) + 1)
    end = rng.randrange(cut, len(raw) + 1)
    # Power cuts leave an end that is missing, zeros, or both.
    kind = rng.randrange(4)
    damaged = (raw[:cut], raw[:cut] + bytes(len(raw) - cut), bytes(len(raw)))[min(kind, 2)]
    if kind == 3:
        damaged = raw[:cut] + bytes(end - cut) + raw[end:]
    path.write_bytes(damaged)
    try:
        again = Session([_recording()], folder / "labelled", BY, is_new_allowed=rng.random() < 0.5)
    except InputError:
        assert path.read_bytes() == damaged, "a refused journal is another one"
        return
    with closing(again):
        assert damaged.strip(bytes(1)) or not damaged, "zeros are taken for a new journal"
        assert again.marks.done == finished[: len(again.marks.done)], "an action that was not done"
