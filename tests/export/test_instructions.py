"""Stated instruction counts equal the counts on the emulated Cortex-M7."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import building
import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core import INPUT, Program, Step, steps
from firstcontact.core import layer_steps as layers
from firstcontact.core import shape_steps as shapes
from firstcontact.export import NamedModel, Trained
from firstcontact.export import _c_library as c_library
from firstcontact.models import Spec, Task, WindowModel

RNG = np.random.default_rng(0)


def draw(*shape: int) -> NDArray[np.float64]:
    return 0.1 * RNG.standard_normal(shape)


class Steps(WindowModel):
    kind = "steps"
    notes = property(lambda self: {})  # type: ignore[assignment]

    def __init__(self, samples: int, chain: tuple[Step, ...]) -> None:
        self.spec = Spec(Task.REGRESSION, 4936.0, samples)
        self._program = Program(samples, chain, chain[-1].gives)

    def program(self) -> Program:
        return self._program

    def outputs(self, X: NDArray[np.float32]) -> NDArray[np.float64]:
        return np.zeros((len(X), 1))

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        return {}

    @classmethod
    def from_arrays(cls, spec: object, arrays: object) -> Steps:
        raise NotImplementedError


def machine(n: int) -> tuple[Step, ...]:
    vectors = 3 * n // 2
    return (
        steps.shape_and_level(INPUT, "shape", n, 0.0, 1.0),
        steps.rbf("shape", "near", draw(vectors, n + 1), 0.1),
        steps.dense("near", "pairs", draw(10, vectors), draw(10)),
        steps.votes("pairs", "votes", 5),
        steps.deviation("near", "spread", draw(vectors, vectors), 1.0, 0.1, 1.0),
    )


def small(n: int) -> tuple[Step, ...]:
    return (
        steps.log_peak(INPUT, "peak", n),
        steps.parabola("peak", "line", np.array([1.0, 2.0, 3.0]), -9.0, 9.0),
        steps.nearness("line", "near", draw(6)),
    )


def spectrum(n: int) -> tuple[Step, ...]:
    return (
        shapes.over_peak(INPUT, "over", n),
        shapes.powers("over", "powers", n // 2),
        shapes.level_free("powers", "level", n // 2, 1e-6),
        shapes.course(INPUT, "course", n, 1, 0, (0.1, 0.25, 0.5, 0.75, 0.9)),
    )


def shares(n: int) -> tuple[Step, ...]:
    return (shapes.shares_above(INPUT, "shares", n, 1, (1, 3), draw(2, 84, 1 + n % 3)),)


def convolutions(n: int) -> tuple[Step, ...]:
    half = (n + 1) // 2
    return (
        layers.compress(INPUT, "small", n, 3.0, 0.0, 1.0),
        layers.conv("small", "first", n, draw(16, 1, 7), draw(16), 2),
        layers.silu("first", "bent", 16 * half),
        layers.conv("bent", "wide", half, draw(30, 16, 1), draw(30), 1),
        layers.conv("wide", "seen", half, draw(12, 30, 3), draw(12), 1),
        layers.means("seen", "means", half, 12),
        layers.gate(("seen", "means"), "gated", half, 12),
        layers.plus(("seen", "gated"), "sum", 12 * half),
    )


def depthwise(n: int) -> tuple[Step, ...]:
    return (
        layers.depthwise(INPUT, "three", n, draw(1, 3), draw(1), 1),
        layers.conv("three", "wide", n, draw(8, 1, 1), draw(8), 1),
        layers.depthwise("wide", "more", n, draw(8, 3), draw(8), 2),
        layers.depthwise("more", "five", (n + 1) // 2, draw(8, 5), draw(8), 1),
    )


@pytest.mark.parametrize("n", [8, 31, 74])
@pytest.mark.parametrize("chain", [machine, small, spectrum, shares, convolutions, depthwise])
def test_no_estimate_is_below_the_count(
    chain: Callable[[int], tuple[Step, ...]], n: int, tmp_path: Path
) -> None:
    if not building.has_emulator():
        pytest.skip("gcc-arm-none-eabi and qemu-system-arm are not installed")
    model = Steps(n, chain(n))
    c_library.write(Trained((NamedModel("steps_model", model, None),)), tmp_path)
    predictions = {"MODEL": "fc_steps_model", "HEADER": '"fc_steps_model.h"', "NUMBERS": str(n)}
    image = building.Program("windows.c", tmp_path / "src", predictions).m7(tmp_path / "m7.elf")
    X = draw(4, n).astype(np.float32)
    counted: Any = building.answers(building.ask_m7(image, X.tobytes(), tmp_path))
    most = int(counted["instructions"].max())
    text = model.program().instructions
    assert most <= text <= 1.3 * most + 500
