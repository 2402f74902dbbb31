"""``firstcontact pretrain``: it trains a network, and reuses finished parts."""

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.models.model_file import read_card
from firstcontact_lab.rigs import FAMILIES
from ringing import ringing
from saved import load_network
from trainings import run

pytestmark = pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")


def test_a_small_one_from_nothing_and_the_same_again(
    tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from firstcontact_lab.pretraining import examples
    from firstcontact_lab.pretraining.pretrain import Size

    monkeypatch.setattr(examples, "THINGS", 6)
    monkeypatch.setattr(examples, "CONTEXT", (4, 6))
    few = Size(calibration=10, judgement=2, held_out=2, steps=3)
    monkeypatch.setattr(
        Size,
        "resized",
        lambda size, rigs, epochs, teachers: replace(
            few, rigs=rigs, epochs=epochs, teachers=teachers
        ),
    )
    words = (
        "--rigs",
        "10",
        "--epochs",
        "2",
        "--teachers",
        "2",
        "--workers",
        "1",
        "--work",
        tmp_path / "work",
    )
    assert run("pretrain", "--out", tmp_path / "a", *words) == 0
    output = capsys.readouterr().out
    assert "network 2 of 2" in output
    states = {f: f.stat().st_mtime_ns for f in (tmp_path / "work").glob("training-*")}
    assert len(states) == 2
    record = read_card(tmp_path / "a").predictors[0].record
    assert "10 random simulated rigs" in record.training["trained"]
    assert len(record.scores) == 2 * (1 + len(FAMILIES)) + 1
    answers = load_network(tmp_path / "a").predict_touches(ringing(10)[0])
    assert np.isfinite(answers.value).all()
    # No pass of the full network is made again, and the weights are the same.
    assert run("pretrain", "--out", tmp_path / "b", *words) == 0
    assert all(f.stat().st_mtime_ns == at for f, at in states.items())
    both = [(tmp_path / name / "weights.safetensors").read_bytes() for name in "ab"]
    assert both[0] == both[1]


@pytest.mark.parametrize("words", [("--rigs", "9"), ("--seed", "-1")])
def test_what_cannot_be_asked_for_is_refused(
    tmp_path: Path, capsys: Any, words: tuple[str, str]
) -> None:
    out = ("--out", tmp_path / "m", "--work", tmp_path / "w")
    assert run("pretrain", *out, *words) == 2
    assert words[0] in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
