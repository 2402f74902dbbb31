"""What the errors of several pinches of one object have in common, and what that makes surer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from firstcontact.models import InContextModel, Values, combine
from firstcontact_lab.pretraining._examples import Examples
from firstcontact_lab.pretraining._finishing import answers

#: Pinches of each thing, all in one session.
PINCHES = 5


def of_things(
    model: InContextModel, examples: Examples, samples: int, seed: int
) -> tuple[Values, Values, Values]:
    """Answers, half widths, shape (things, PINCHES), and Shore A of things, shape (things,)."""
    values, spreads = answers(model.network, examples, samples, seed)
    half = model.half_widths(spreads, samples)
    things = examples.things >= 0
    value, width, truth = (
        x[things].reshape(-1, PINCHES) for x in (np.clip(values, 0, 100), half, examples.shore_a)
    )
    return value, width, truth[:, 0]


def shared_part(values: Values, half_widths: Values, truth: Values) -> float:
    """Part of a pinch's error that others of the same thing have, as a standard deviation.

    Errors are counted in half widths of their own intervals: the mean product of two of a thing
    over the mean square of one is the square of what they share.
    """
    z = (values - truth[:, None]) / half_widths
    n = z.shape[1]
    products = (z.sum(axis=1) ** 2 - (z**2).sum(axis=1)).mean() / (n * (n - 1))
    return float(np.sqrt(max(products, 0.0) / (z**2).mean()))


def coverage(values: Values, half_widths: Values, truth: Values, pinches: int) -> float:
    """Share of things whose Shore A lies in the interval of their first so many pinches."""
    found = [combine(v[:pinches], h[:pinches]) for v, h in zip(values, half_widths, strict=True)]
    held = [its.low <= y <= its.high for its, y in zip(found, truth, strict=True)]
    return float(np.mean(held))


def same_object(
    model: InContextModel,
    known: Examples,
    asked: Examples,
    samples: Mapping[str, int],
    seed: int,
) -> dict[str, Any]:
    """What errors share on some rigs, and what combined intervals then hold on others.

    Parameters
    ----------
    model
        Knows no rig; the examples have their contexts.
    known, asked
        Of different rigs, each thing pinched ``PINCHES`` times.
    samples
        After the contact, by the name of the time.
    seed
        Of what is drawn.
    """
    out = {}
    for time, after in samples.items():
        its = of_things(model, asked, after, seed)
        out[time] = {
            "shared": round(shared_part(*of_things(model, known, after, seed)), 3),
            "coverage": {str(n): round(coverage(*its, n), 3) for n in range(1, PINCHES + 1)},
        }
    return {"pinches": PINCHES, "ms": out}
