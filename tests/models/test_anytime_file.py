"""Network models on disk: round trips, and damaged, foreign or hostile files."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.models.card import TrainingRecord
from firstcontact.models.model_file import pretrained, pretrained_folder, read_card
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from ringing import ringing
from saved import CARD, WEIGHTS, edit, load_arrays, load_network, replace_arrays, save_network

KNOWN, SHORE_A, _ = ringing(40)
MODEL = pretrained().conditioned_on({Rig.ANY: Rig.fit(KNOWN, SHORE_A), 1: Rig.fit(KNOWN, SHORE_A)})
Arrays = dict[str, Any]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return save_network(MODEL, tmp_path / "model", record=TrainingRecord(pinches=40))


def _same(one: RigModel, other: RigModel) -> bool:
    first, second = (m.predict_touches(KNOWN) for m in (one, other))
    return all(
        np.allclose(getattr(first, n), getattr(second, n), atol=1e-3)
        for n in ("value", "spread", "low", "high", "out_of_range")
    )


def test_a_model_is_the_same_after_saving(folder: Path) -> None:
    again = load_network(folder)
    assert _same(MODEL, again)
    assert sorted(again.rigs) == [Rig.ANY, 1]
    assert again.rigs[Rig.ANY].speeds is None
    [part] = read_card(folder).predictors
    assert (part.record.pinches, part.kind) == (40, MODEL.kind)
    assert sorted(p.name for p in folder.iterdir()) == [CARD, WEIGHTS]


def test_saving_what_was_read_gives_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    again = save_network(load_network(folder), tmp_path / "again")
    assert (again / WEIGHTS).read_bytes() == (folder / WEIGHTS).read_bytes()


def test_a_model_of_no_rig_is_read_too(tmp_path: Path) -> None:
    assert _same(pretrained(), load_network(save_network(pretrained(), tmp_path / "m")))


def test_packaged_files_are_small_and_have_checksums() -> None:
    assert (pretrained_folder() / WEIGHTS).stat().st_size <= 2_000_000
    [part] = read_card(pretrained_folder()).predictors
    assert part.record.training["trained"]


@pytest.mark.parametrize(
    "changes",
    [
        {"kind": "svm"},
        {"rate_hz": float("nan")},
        {"level": 1.0},
    ],
    ids=str,
)
def test_a_card_of_something_else(folder: Path, changes: dict[str, Any]) -> None:
    edit(folder, CARD, **changes)
    with pytest.raises(InputError) as caught:
        load_network(folder)
    assert str(folder) in str(caught.value)
    assert "\n" not in str(caught.value)


def _without(name: str) -> Callable[[Arrays], Arrays]:
    return lambda arrays: {n: a for n, a in arrays.items() if n != name}


def _changed(name: str, change: Callable[[Any], Any]) -> Callable[[Arrays], Arrays]:
    return lambda arrays: {**arrays, name: np.ascontiguousarray(change(arrays[name]))}


ATTACKS = {
    "no rig for any finger": lambda a: {n: x for n, x in a.items() if ".-1." not in n},
    "a finger that is no number": lambda a: {**a, "rig.thumb.scalars": np.zeros(3)},
    "a finger that no hand has": lambda a: {**a, "rig.2.scalars": np.zeros(3)},
    "a rig without scalars": _without("rig.-1.scalars"),
    "sign of two": _changed("rig.-1.scalars", lambda a: a * [1, 2, 1]),
    "no factors": _without("factors"),
    "no factors of averages": _without("mixed"),
    "factors below nothing": _changed("factors", lambda a: -a),
    "nothing is familiar": _without("familiar.mean"),
    "a scale of nothing": _changed("inputs.sd", lambda a: 0 * a),
    "nothing at all": lambda a: {},
    "level of nearly nothing": _changed("rig.-1.scalars", lambda a: a * [1e-30, 1, 1]),
    "weights that overflow": _changed("body2.out.scale", lambda a: a * np.float32(1e31)),
    "weights that overflow together": lambda a: {
        n: x * np.float32(1e12) if n.endswith(".scale") else x for n, x in a.items()
    },
    "a scale that overflows": _changed("inputs.sd", lambda a: a * np.float32(1e-38)),
    "integers whose sums overflow": _changed("body1.into.weight", lambda a: 0 * a + 32_000),
    "integers that are floats": _changed("body1.into.weight", lambda a: a.astype(np.float32)),
    "a rig whose term overflows": _changed("term.weight", lambda a: a * np.float32(1e12)),
}


@pytest.mark.parametrize("attack", ATTACKS)
def test_arrays_that_do_not_fit(folder: Path, attack: str) -> None:
    replace_arrays(folder, ATTACKS[attack](load_arrays(folder)))
    with pytest.raises(InputError) as caught:
        load_network(folder)
    assert WEIGHTS in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_prediction_that_is_no_number_is_never_silent() -> None:
    signals = KNOWN.signals.copy()
    signals[3] = np.nan
    with pytest.raises(InputError, match="contact 3"), np.errstate(invalid="ignore"):
        MODEL.predict_touches(replace(KNOWN, signals=signals))
