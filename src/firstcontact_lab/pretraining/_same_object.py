"""Error that several pinches of one object share, and coverage of their pooled interval."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from firstcontact.models import InContextModel, Values, combine
from firstcontact_lab.pretraining._examples import Examples
from firstcontact_lab.pretraining._finishing import answers

#: Number of pinches of each object, all in one session.
PINCHES = 5


def object_estimates(
    model: InContextModel, examples: Examples, samples: int, seed: int
) -> tuple[Values, Values, Values]:
    """Return predictions, half widths of their intervals, and the Shore A of the objects."""
    values, spreads = answers(model, examples, samples, seed)
    half = model.half_widths(spreads, samples)
    is_object = examples.object_ids >= 0
    value, width, truth = (
        x[is_object].reshape(-1, PINCHES) for x in (np.clip(values, 0, 100), half, examples.shore_a)
    )
    return value, width, truth[:, 0]


def shared_part(values: Values, half_widths: Values, truth: Values) -> float:
    """Return the share of a pinch's error that is common to all pinches of the same object."""
    z = (values - truth[:, None]) / half_widths
    n = z.shape[1]
    products = (z.sum(axis=1) ** 2 - (z**2).sum(axis=1)).mean() / (n * (n - 1))
    return float(np.sqrt(max(products, 0.0) / (z**2).mean()))


def coverage(values: Values, half_widths: Values, truth: Values, pinches: int) -> float:
    """Return the share of objects whose pooled interval of n ``pinches`` holds their Shore A."""
    combined = [combine(v[:pinches], h[:pinches]) for v, h in zip(values, half_widths, strict=True)]
    covered = [
        estimates.low <= y <= estimates.high for estimates, y in zip(combined, truth, strict=True)
    ]
    return float(np.mean(covered))


def same_object(
    model: InContextModel,
    calibration: Examples,
    test: Examples,
    samples: Mapping[str, int],
    seed: int,
) -> dict[str, Any]:
    """Return the size of the error that pinches of one object share, and the pooled coverage."""
    out = {}
    for time, length in samples.items():
        estimates = object_estimates(model, test, length, seed)
        out[time] = {
            "shared": round(shared_part(*object_estimates(model, calibration, length, seed)), 3),
            "coverage": {str(n): round(coverage(*estimates, n), 3) for n in range(1, PINCHES + 1)},
        }
    return {"pinches": PINCHES, "ms": out}
