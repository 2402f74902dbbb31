"""Damaged, foreign or hostile model files are refused in one sentence."""

import os
import pickle
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from safetensors.numpy import save

from firstcontact.core import InputError
from firstcontact.models import (
    Model,
    Task,
    WindowModel,
    WindowPredictor,
    load_model,
    make_estimator,
)
from firstcontact.models.card import TrainingData, TrainingRecord, WindowCard
from firstcontact.models.model_file import read_card
from firstcontact.testing.synthetic import RATE, toy_windows
from saved import CARD, WEIGHTS, edit, load_arrays, load_window, replace_arrays, save_window, vouch

DATA = TrainingData(source="synthetic", pinches=60, sessions=("a", "b"), specimens=("x",))
RECORD = TrainingRecord(split="session b held out", scores={"rmse": 2.5})


@cache
def svm() -> WindowModel:
    return make_estimator("svm", Task.CLASSIFICATION, RATE).fit(*toy_windows(60))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Model(predictors=(WindowPredictor(svm(), record=RECORD),), trained_on=DATA).save(
        tmp_path / "model"
    )


def test_the_card_states_the_source_of_the_model(folder: Path) -> None:
    card = read_card(folder)
    assert card.trained_on == DATA
    [part] = card.predictors
    assert isinstance(part, WindowCard)
    assert part.record.split == RECORD.split
    assert part.record.scores == RECORD.scores
    assert part.rate_hz == RATE
    assert part.samples == 74
    assert part.channels == 1
    assert part.classes == (10.0, 29.0, 60.0)
    assert part.record.training["support_vectors"] > 0
    assert {"firstcontact", "numpy", "scikit-learn"} <= set(card.versions)
    assert sorted(p.name for p in folder.iterdir()) == [CARD, WEIGHTS]


@pytest.mark.parametrize("name", [CARD, WEIGHTS])
def test_every_truncation_is_noticed(folder: Path, name: str) -> None:
    content = (folder / name).read_bytes()
    lengths = range(0, len(content) - 2, max(1, len(content) // 50))
    for length in lengths:
        (folder / name).write_bytes(content[:length])
        with pytest.raises(InputError, match=name):
            load_window(folder)


def test_a_flipped_bit_is_noticed(folder: Path) -> None:
    content = bytearray((folder / WEIGHTS).read_bytes())
    content[len(content) // 2] ^= 1
    (folder / WEIGHTS).write_bytes(content)
    with pytest.raises(InputError, match="sha256"):
        load_window(folder)


@pytest.mark.parametrize(
    "changes",
    [
        {"format": "other"},
        {"format_version": 2},
        {"kind": "forest"},
        {"rate_hz": float("nan")},
        {"rate_hz": 10**400},
        {"samples": 75},
        {"samples": 10**18},
        {"channels": 2},
        {"classes": []},
        {"classes": [1.0, 2.0]},
        {"classes": [60.0, 29.0, 10.0]},
        {"channel_order": ["strip"]},
        {"trained_on": {"objects": {"apple": 1e18}}},
        {"takes": "contact"},
        {"sha256": None},
        {"interval": {"level": 0.9, "edges": [], "half_widths": [1e300]}},
    ],
    ids=str,
)
def test_a_card_of_something_else(folder: Path, changes: dict[str, Any]) -> None:
    edit(folder, **changes)
    with pytest.raises(InputError) as caught:
        load_window(folder)
    assert str(folder) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ["", "[]", "null", "{", "\x00\xff", '"card"', "[" * 100_000, '{"a":' * 100_000]
)
def test_a_card_that_is_no_card(folder: Path, text: str) -> None:
    (folder / CARD).write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=CARD):
        load_window(folder)


def test_arrays_that_do_not_fit(folder: Path) -> None:
    arrays = load_arrays(folder)
    for wrong in (
        {name: array for name, array in arrays.items() if name != "bias"},
        arrays | {"weights": arrays["weights"] * np.nan},
        arrays | {"vectors": arrays["vectors"][:, :-1].copy()},
        arrays | {"parameters": -arrays["parameters"]},
    ):
        replace_arrays(folder, wrong)
        with pytest.raises(InputError, match=WEIGHTS):
            load_window(folder)


class Hostile:
    """Object that writes a file when it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.mark),)


def test_a_pickle_in_place_of_the_weights_is_not_run(folder: Path) -> None:
    mark = folder / "ran"
    vouch(folder, pickle.dumps(Hostile(mark)))
    with pytest.raises(InputError, match="not a safetensors file"):
        load_window(folder)
    assert not mark.exists()


def test_a_model_that_cannot_be_written_leaves_the_old_one(folder: Path) -> None:
    X, y, groups = toy_windows(60)
    model = make_estimator("train_mean", Task.REGRESSION, RATE).fit(X, y, groups)
    original = {p.name: p.read_bytes() for p in folder.iterdir()}
    with pytest.raises(ValueError, match="JSON"):
        save_window(model, folder, record=TrainingRecord(scores={"rmse": float("nan")}))
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == original


def test_a_file_that_is_too_large_is_not_read(folder: Path) -> None:
    """The file is sparse, so its declared size is checked without writing it."""
    for name in (CARD, WEIGHTS):
        original = (folder / name).read_bytes()
        os.truncate(folder / name, 1 << 40)
        with pytest.raises(InputError, match=name):
            load_window(folder)
        (folder / name).write_bytes(original)


def test_a_pipe_does_not_block(folder: Path) -> None:
    for name in (WEIGHTS, CARD):
        (folder / name).unlink()
        os.mkfifo(folder / name)
        with pytest.raises(InputError, match=name):
            load_window(folder)


def test_a_header_that_declares_terabytes(folder: Path) -> None:
    header = b'{"vectors":{"dtype":"F32","shape":[1099511627776],"data_offsets":[0,4398046511104]}}'
    vouch(folder, len(header).to_bytes(8, "little") + header)
    with pytest.raises(InputError, match="not a safetensors file"):
        load_window(folder)
    vouch(folder, (1 << 62).to_bytes(8, "little") + header)
    with pytest.raises(InputError, match="not a safetensors file"):
        load_window(folder)


def test_what_could_not_be_read_again_is_not_written(folder: Path) -> None:
    original = {p.name: p.read_bytes() for p in folder.iterdir()}
    data = TrainingData(sessions=("x" * 1000,))
    model = Model(predictors=(WindowPredictor(svm()),), trained_on=data)
    with pytest.raises(InputError, match="sessions"):
        model.save(folder)
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == original


def test_a_constant_that_is_no_class(tmp_path: Path) -> None:
    model = make_estimator("train_mean", Task.CLASSIFICATION, RATE).fit(*toy_windows(60)[:2])
    folder = save_window(model, tmp_path / "s")
    replace_arrays(folder, {"value": np.array([11.0])})
    with pytest.raises(InputError, match="not one of its classes"):
        load_window(folder)


@pytest.mark.parametrize(
    "digests", [np.zeros(8, np.float32), np.zeros(7, np.uint8), np.zeros((1, 8), np.uint8)]
)
def test_digests_that_are_none(folder: Path, digests: NDArray[Any]) -> None:
    arrays = {f"0.{name}": array for name, array in load_arrays(folder).items()}
    vouch(folder, save({**arrays, "pinches": digests}))
    with pytest.raises(InputError, match=WEIGHTS):
        load_window(folder)


def test_a_model_whose_folder_refuses_it_is_written_elsewhere(folder: Path, tmp_path: Path) -> None:
    model, gone = load_model(folder), tmp_path / ".gone.0123abcd.part" / "gone"
    gone.parent.write_text("a file where a folder shall be")
    with pytest.raises(InputError) as refused:
        model.write(gone)
    (kept,) = tmp_path.glob("gone-*")
    assert str(kept) in str(refused.value)
    assert load_model(kept).estimators == model.estimators
