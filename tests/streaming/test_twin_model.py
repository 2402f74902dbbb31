"""Tests of the model of the simulated hand."""

from __future__ import annotations

from pathlib import Path

import pytest

import firstcontact as fc
from firstcontact.streaming import default_model, twin_model
from firstcontact.streaming._twin import SHIPPED_HAND


def test_the_default_hand_has_a_model_without_training(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    model = fc.load_model(twin_model(*SHIPPED_HAND))
    assert list(tmp_path.iterdir()) == []
    # Objects of the same hand: the model knows its blocks only.
    unseen = fc.simulate(tmp_path / "objects", pinches_per_block=0, pinches_per_object=2)
    for evaluation in fc.evaluate(model, unseen):
        (group,) = evaluation.groups
        assert group.title == "not seen in training"
        assert group.constant is not None
        assert max(group.rmse.values()) < group.constant


def test_python_takes_the_twins_model_as_the_command_line_does() -> None:
    """The package's model, which knows no rig, is the default for other sources only."""
    with fc.open("twin", speed=8.0, objects="block 43") as source:
        (final,) = [
            event
            for event in fc.live(source, pinches=1)
            if isinstance(event, fc.Estimate) and event.final
        ]
    assert final.model == default_model(source).estimators[0] == "combined"
    assert final.low < 43 < final.high
