"""Number of pinches from which a finger is better conditioned alone than with the other finger.

Prints the error on objects with each finger as a rig of its own, minus the error with both as one
rig, by the number of block pinches of each finger: Shore A, mean and standard error over rigs. The
fingers of the twin's hands differ, those of the rigs of another structure are equal.

    python docs/measure_fingers.py
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset
from firstcontact.models import Touches
from firstcontact.models.labelled_data import LabelledTouches
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig import network_estimator as conditioning
from firstcontact.models.rig.rigs import Rig
from firstcontact.twin import (
    CONDITIONS,
)
from firstcontact_lab.study.rig_sets import PinchUse, Sizes, rig_set
from firstcontact_lab.study.structures import MOTORS, draw_blocks, draw_objects, draw_structured

Pinches = tuple[Touches, NDArray[np.float64]]
COUNTS = (4, 6, 8, 10, 15, 20)
#: Seeds of the twin's hands and of the other rigs, and draws of the pinches of each count.
TWINS, STRUCTURES, DRAWS = range(9301, 9306), range(41, 43), 4
LEVELS = (20.0, 29.0, 43.0, 52.0, 60.0)


def hands() -> Iterator[tuple[Pinches, Pinches]]:
    """Yield pinches of blocks and of objects of the twin's hands."""
    sizes = Sizes(blocks=24, held_out=0, objects=8, other_blocks=0, kinds=0)
    for seed in TWINS:
        for condition in (CONDITIONS["paper-rig"], CONDITIONS["everyday"]):
            pinches = rig_set(seed, condition, sizes, [2, 3, 4, 5])
            is_long = pinches.touches.answerable
            blocks, objects = (
                np.flatnonzero((pinches.uses == use) & is_long)
                for use in (PinchUse.BLOCKS, PinchUse.OBJECTS)
            )
            touches, shore_a = pinches.touches, pinches.windows.y
            yield (
                (touches.take(blocks), shore_a[blocks]),
                (touches.take(objects), shore_a[objects]),
            )


def structured() -> Iterator[tuple[Pinches, Pinches]]:
    """Yield pinches of blocks and of objects of rigs of another structure."""
    for seed in STRUCTURES:
        for motor in MOTORS:
            rig = draw_structured(seed, motor)
            yield labelled(draw_blocks(rig, LEVELS, 24, 4)), labelled(draw_objects(rig, 60))


def labelled(data: Dataset) -> Pinches:
    """Return the contacts that last long enough, with their Shore A."""
    cut = LabelledTouches.cut(data, [pinch.first for pinch in data.pinches])
    cut = cut.take(cut.touches.answerable)
    return cut.touches, cut.shore_a


def gain(blocks: Pinches, objects: Pinches, count: int) -> float:
    """Return the difference of the errors with ``count`` block pinches of each finger."""
    (touches, shore_a), (asked, truth) = blocks, objects
    squares = np.zeros(2)
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        order = rng.permutation(len(touches))
        # As many pinches of each level as possible: the n-th pinch of each level comes before the
        # next one of any.
        turns = [np.sum(shore_a[order[:i]] == shore_a[row]) for i, row in enumerate(order)]
        order = order[np.argsort(turns, kind="stable")]
        rows = np.sort([row for f in (0, 1) for row in order[touches.fingers[order] == f][:count]])
        known = conditioning.known_rigs(touches.take(rows), shore_a[rows], seed)
        each = {finger: rig for finger, (rig, _) in known.items()}
        for place, rigs in enumerate(({Rig.ANY: each[Rig.ANY]}, each)):
            model = pretrained().conditioned_on(rigs)
            squares[place] += np.mean((model.predict_touches(asked).value - truth) ** 2)
    one, each = np.sqrt(squares / DRAWS)
    return float(each - one)


def main() -> None:
    """Print one line for each kind of rig and number of pinches."""
    conditioning.LEAST_OF_FINGER = 2
    for name, rigs in (("twin", list(hands())), ("other structure", list(structured()))):
        for count in COUNTS:
            gains = np.array([gain(*rig, count) for rig in rigs])
            error = gains.std(ddof=1) / np.sqrt(len(gains))
            print(f"{name}, {count} pinches of each finger: {gains.mean():+.2f} ± {error:.2f}")


if __name__ == "__main__":
    main()
