"""Test that half the time step gives the same waveform, with noise and both contacts."""

import numpy as np
import pytest
from numpy.typing import NDArray
from pinches import EVERYDAY, PAPER_RIG, drawn

from firstcontact.twin import BLOCKS, TwinObject
from firstcontact.twin.draw import Condition
from firstcontact.twin.mechanics import BUFFER, INDENTATION
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact.twin.pinch import SUBSTEPS, integrate_pinch

TENNIS_BALL = EVERYDAY_OBJECTS[4]
AVOCADO = EVERYDAY_OBJECTS[7]


def output(kind: TwinObject, number: int, condition: Condition, steps: int) -> NDArray[np.float64]:
    return integrate_pinch(drawn(kind, number, condition), substeps=steps)[1]


@pytest.mark.parametrize("condition", [PAPER_RIG, EVERYDAY], ids=lambda c: c.name)
@pytest.mark.parametrize("kind", [BLOCKS[0], BLOCKS[4], TENNIS_BALL, AVOCADO], ids=lambda k: k.name)
def test_halving_the_step_changes_the_waveform_by_less_than_1_percent(
    kind: TwinObject, condition: Condition
) -> None:
    for number in range(4):
        waveform = output(kind, number, condition, SUBSTEPS)
        finer = output(kind, number, condition, 2 * SUBSTEPS)
        assert (waveform[-1, :, INDENTATION] > 0).all(), "both fingers have touched"
        change = np.abs(waveform - finer)[..., BUFFER].max(axis=0)
        assert (change / np.abs(finer[..., BUFFER]).max(axis=0) < 0.01).all()


def test_error_decreases_with_the_step() -> None:
    reference = output(BLOCKS[4], 0, PAPER_RIG, 16 * SUBSTEPS)[..., BUFFER]
    errors = [
        np.abs(output(BLOCKS[4], 0, PAPER_RIG, n)[..., BUFFER] - reference).max()
        for n in (SUBSTEPS // 2, SUBSTEPS, 2 * SUBSTEPS)
    ]
    # Of fourth order between the contacts, less at their edges.
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[1] / 2
