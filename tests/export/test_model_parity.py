"""Window models in C: the same predictions, intervals and refusals as in Python."""

from __future__ import annotations

from pathlib import Path

import building
import numpy as np
import pytest
from numpy.typing import NDArray

from estimator_tasks import EACH
from firstcontact.core import INPUT, InputError, import_onnxruntime
from firstcontact.export import NamedModel, Trained
from firstcontact.export import _c_library as c_library
from firstcontact.export._onnx_graph import to_onnx
from firstcontact.models import (
    ESTIMATORS,
    Interval,
    Spec,
    SvmModel,
    Task,
    WindowModel,
    make_estimator,
)
from firstcontact.testing._windows import RATE, toy_windows

pytestmark = pytest.mark.usefixtures("small_searches")

INTERVAL = Interval(0.9, edges=(20.0, 40.0), half_widths=(1.0, 2.5, 4.0))


def learned(name: str, task: Task) -> NamedModel:
    estimator = make_estimator(name, task, RATE, **ESTIMATORS[name].quick)
    X, y, groups = toy_windows()
    model = estimator.fit(X, y, groups, seed=1)
    if task is Task.CLASSIFICATION:
        return NamedModel("stiffness", model, None)
    scaled = model.spread(X[:1]) is not None
    interval = Interval(0.9, INTERVAL.edges, INTERVAL.half_widths, INTERVAL.limits, scaled)
    return NamedModel("stiffness", model, interval)


def program(named: NamedModel, folder: Path) -> building.Program:
    folder.mkdir()
    c_library.write(Trained((named,)), folder)
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
        value = named.model.predict_one(window)
    except InputError:
        return None
    if named.interval is None:
        return value, np.nan, np.nan
    spread = named.model.spread(window[None])
    ends = named.interval.around(value, 1.0 if spread is None else float(spread[0]))
    return value, *ends


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
            assert named.model.spec.classes[record["chosen"]] == wanted[0]
        np.testing.assert_allclose(answer, wanted, atol=0.01)


@pytest.mark.parametrize(("name", "task"), EACH)
def test_c_answers_as_python_does(name: str, task: Task, tmp_path: Path) -> None:
    named = learned(name, task)
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
        assert counted.max() <= named.model.program().instructions  # a budget is kept


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
    session = import_onnxruntime().InferenceSession(to_onnx(model.program()))
    (got,) = session.run(None, {INPUT: X.reshape(len(X), -1)})
    np.testing.assert_array_equal(got.argmax(axis=1), model.choose(small))


def test_the_emulator_is_installed(request: pytest.FixtureRequest) -> None:
    if not building.has_emulator():
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi and qemu-system-arm are not installed")


class Opaque(WindowModel):
    kind = "opaque"
    notes = property(lambda self: {})  # type: ignore[assignment]

    def __init__(self) -> None:
        self.spec = learned("train_mean", Task.REGRESSION).model.spec

    def outputs(self, X: NDArray[np.float32]) -> NDArray[np.float64]:
        return np.zeros((len(X), 1))

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        return {}

    @classmethod
    def from_arrays(cls, spec: object, arrays: object) -> Opaque:
        return cls()


def test_what_is_not_described_in_steps_says_so(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'opaque' .*steps of its arithmetic"):
        c_library.write(Trained((NamedModel("stiffness", Opaque(), None),)), tmp_path)
