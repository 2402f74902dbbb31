"""SVMs in C: equal predictions, intervals and refusals on all machines."""

from pathlib import Path

import building
import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.chain import build_image
from firstcontact.core import InputError
from firstcontact.export.budget import instructions
from firstcontact.export.hand_image import predictor_in_c
from firstcontact.models import ESTIMATORS, Spec, Task, make_estimator
from firstcontact.models.anytime import Hints
from firstcontact.models.interval import Interval
from firstcontact.models.windows.svm import SvmModel
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.testing.synthetic import RATE, toy_windows

pytestmark = pytest.mark.usefixtures("small_searches")

INTERVAL = Interval(0.9, edges=(20.0, 40.0), half_widths=(1.0, 2.5, 4.0))
#: Samples before a contact.
LEAD = 111
Signal = NDArray[np.float64]


def learned(name: str, task: Task) -> WindowPredictor:
    estimator = make_estimator(name, task, RATE, **ESTIMATORS[name].quick)
    X, y, groups = toy_windows()
    model = estimator.fit(X, y, groups, seed=1)
    return WindowPredictor(model, None if task is Task.CLASSIFICATION else INTERVAL)


def contacts(X: NDArray[np.float32], size: float = 1.0) -> list[Signal]:
    """Return a signal for each window, with noise before it."""
    rng = np.random.default_rng(0)
    noise = 1e-3 * rng.standard_normal((len(X), LEAD + X.shape[1] + 2))
    noise[:, LEAD:-2] += X[:, :, 0]
    return [size * signal for signal in noise]


def malformed(signal: Signal) -> list[Signal]:
    """Return damaged signals: NaN, infinite, flat, saturated, too loud, or too short."""
    bad = [signal.copy() for _ in range(6)]
    bad[0][LEAD + 5], bad[1][LEAD], bad[2][40] = np.nan, np.inf, -np.inf
    bad[3][:], bad[4][LEAD:] = 1.65, 1.65
    bad[5] *= 1e300
    return [*bad, *(signal[LEAD - lead :] for lead in (0, 5, 15, 25, 100))]


def answers(window: WindowPredictor, each: list[Signal], folder: Path) -> list[NDArray[np.void]]:
    """Return the records of C on this machine, and on the emulated board if there is one."""
    image = build_image(RATE, model=predictor_in_c(window))
    data = building.signals(image.data, each, window.lengths[0] + window.lookahead)
    program = building.chain_program("windows.c", folder)
    native = program.native(folder / "native", strict=True)
    records = [building.ask_native(native, data, folder)]
    if building.has_emulator():
        records.append(building.ask_m7(program.m7(folder / "m7.elf"), data, folder))
    return [building.answers(raw) for raw in records]


@pytest.mark.parametrize("task", list(Task))
def test_every_machine_predicts_the_numbers_of_python(task: Task, tmp_path: Path) -> None:
    window = learned("svm", task)
    X = toy_windows(40, seed=8)[0]
    sizes = [1e-30, 1e-12, 1e-6, 1e3, 1e12, 1e30]
    each = contacts(X) + malformed(contacts(X)[0])
    each += [signal for size in sizes for signal in contacts(X[:1], size)]
    records = answers(window, each, tmp_path)
    made = [window.predict(s, window.lengths[0], 0, Hints()) for s in each]
    assert sum(p is None for p in made) >= 6
    for got, wanted in zip(records[0], made, strict=True):
        assert (got["status"] == 0) == (wanted is not None)
        if wanted is not None:
            assert (got["value"], got["low"], got["high"]) == wanted[:3]
    assert all(building.same(records[0], other) for other in records[1:])


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
    _, on_m7 = answers(WindowPredictor(model), contacts(X), tmp_path)
    most = on_m7["instructions"].max()
    assert most <= instructions(model) <= 1.3 * most + 500


def test_other_models_have_no_form_in_c() -> None:
    window = learned("svm", Task.REGRESSION)
    scaled = WindowPredictor(window.model, Interval(0.9, (), (1.0,), scaled=True))
    for predictor in (learned("peak", Task.REGRESSION), scaled):
        with pytest.raises(InputError, match="--estimator"):
            predictor_in_c(predictor)
