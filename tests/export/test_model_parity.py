"""Window models in C: the same predictions, intervals and refusals as in Python."""

from __future__ import annotations

from pathlib import Path

import building
import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.export.budget import instructions
from firstcontact.export.parts import NamedModel, Trained
from firstcontact.models import ESTIMATORS, Interval, Spec, Task, make_estimator
from firstcontact.models.svm import SvmModel
from firstcontact.testing.synthetic import RATE, toy_windows

pytestmark = pytest.mark.usefixtures("small_searches")

INTERVAL = Interval(0.9, edges=(20.0, 40.0), half_widths=(1.0, 2.5, 4.0))


def learned(name: str, task: Task) -> NamedModel:
    estimator = make_estimator(name, task, RATE, **ESTIMATORS[name].quick)
    X, y, groups = toy_windows()
    model = estimator.fit(X, y, groups, seed=1)
    if task is Task.CLASSIFICATION:
        return NamedModel("stiffness", model, None)
    return NamedModel("stiffness", model, INTERVAL)


def program(named: NamedModel, folder: Path) -> building.Program:
    folder.mkdir()
    MODEL_EXPORTERS["c"].write(Trained((named,)), folder)
    spec = named.model.spec
    predictions = {
        "MODEL": f"fc_{named.name}",
        "HEADER": f'"fc_{named.name}.h"',
        "NUMBERS": str(spec.samples * spec.channels),
    }
    return building.Program("windows.c", folder / "src", predictions)


def malformed(X: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return damaged windows: NaN, infinite, flat, saturated, half saturated, or too loud."""
    bad = X[:7].copy()
    bad[0, 5], bad[1, 0], bad[2, -1] = np.nan, np.inf, -np.inf
    bad[3] = 0.0
    bad[4] = 1.65
    bad[5] *= np.float32(1e25)
    bad[6] = np.minimum(bad[6], np.median(bad[6]))
    return bad


def quiet_and_loud(X: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return one window at levels from very quiet to nearly too loud for float32."""
    sizes = np.concatenate([10.0 ** np.arange(-42, 19, 3), np.geomspace(1e-8, 1e-4, 9)])
    return (X[:1] / np.abs(X[0]).max() * sizes[:, None, None]).astype(np.float32)


def expected(named: NamedModel, window: NDArray[np.float32]) -> tuple[float, float, float] | None:
    """Return the Python model's prediction and its bounds; None if the model refuses the window."""
    try:
        value = float(named.model.predict(window[None])[0])
    except InputError:
        return None
    if named.interval is None:
        return value, np.nan, np.nan
    return value, *named.interval.around(value)


def assert_parity(named: NamedModel, X: NDArray[np.float32], got: NDArray[np.void]) -> None:
    assert len(got) == len(X)
    for window, record in zip(X, got, strict=True):
        wanted = expected(named, window)
        assert (record["status"] == 0) == (wanted is not None)
        if wanted is None:
            continue
        answer = [record["value"], record["low"], record["high"]]
        if named.model.spec.classes:
            assert answer[0] == wanted[0]
            assert named.model.spec.classes[record["class_number"]] == wanted[0]
        np.testing.assert_allclose(answer, wanted, atol=0.01)


@pytest.mark.parametrize("task", list(Task))
def test_c_predicts_the_values_of_python(task: Task, tmp_path: Path) -> None:
    named = learned("svm", task)
    built = program(named, tmp_path / "library")
    X = toy_windows(40, seed=8)[0]
    X = np.concatenate([X, malformed(X), quiet_and_loud(X)])
    data = X.tobytes()
    native = building.ask_native(built.native(tmp_path / "native", strict=True), data, tmp_path)
    assert_parity(named, X, building.answers(native))
    if building.has_emulator():
        m7 = building.ask_m7(built.m7(tmp_path / "m7.elf"), data, tmp_path)
        assert building.same(building.answers(native), building.answers(m7))
        counted = building.answers(m7)["instructions"]
        assert counted.min() > 0


def test_a_pair_without_bias_goes_to_the_same_class_where_kernels_vanish(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    spec = Spec(Task.CLASSIFICATION, RATE, 16, 1, (10.0, 29.0, 60.0))
    vectors = rng.standard_normal((6, 17)).astype(np.float32)
    weights = (100 * np.abs(rng.standard_normal((3, 6)))).astype(np.float32)
    none, scale = np.zeros(3, np.float32), np.array([0.0, 1.0])
    model = SvmModel(spec, scale, vectors, weights, none, scale, np.array([1.0, 0.7, 0.0]))
    X = rng.standard_normal((80, 16, 1)) * np.geomspace(1e-2, 1e-1, 80)[:, None, None]
    X = X.astype(np.float32)
    small = model.outputs(X)
    assert ((small > 0) & (small < 1e-34)).any()  # what C takes for 0
    named = NamedModel("stiffness", model, None)
    native = program(named, tmp_path / "library").native(tmp_path / "native", strict=True)
    assert_parity(named, X, building.answers(building.ask_native(native, X.tobytes(), tmp_path)))


def test_the_emulator_is_installed(request: pytest.FixtureRequest) -> None:
    if not building.has_emulator():
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi and qemu-system-arm are not installed")


@pytest.mark.parametrize("n", [8, 31, 74])
@pytest.mark.parametrize("classes", [(), (10.0, 29.0, 43.0, 60.0, 80.0)], ids=["svr", "svc"])
def test_no_count_is_above_the_stated_instructions(
    n: int, classes: tuple[float, ...], tmp_path: Path
) -> None:
    if not building.has_emulator():
        pytest.skip("gcc-arm-none-eabi and qemu-system-arm are not installed")
    rng = np.random.default_rng(0)
    task = Task.CLASSIFICATION if classes else Task.REGRESSION
    rows, one = len(classes) * (len(classes) - 1) // 2 or 1, np.array([0.0, 1.0])
    vectors, weights = rng.standard_normal((3 * n // 2, n + 1)), np.ones((rows, 3 * n // 2))
    spec = Spec(task, RATE, n, 1, classes)
    model = SvmModel(spec, one, vectors, weights, np.zeros(rows), one, np.array([1.0, 0.1, 0.0]))
    X = rng.standard_normal((4, n, 1)).astype(np.float32)
    image = program(NamedModel("stiffness", model, None), tmp_path / "c").m7(tmp_path / "m7.elf")
    counted = building.answers(building.ask_m7(image, X.tobytes(), tmp_path))["instructions"]
    assert counted.max() <= instructions(model) <= 1.3 * counted.max() + 500


def test_other_models_have_no_form_in_c(tmp_path: Path) -> None:
    for part in (Trained((learned("peak", Task.REGRESSION),)), Trained()):
        with pytest.raises(InputError, match=r"svm|SVM"):
            MODEL_EXPORTERS["c"].write(part, tmp_path)
