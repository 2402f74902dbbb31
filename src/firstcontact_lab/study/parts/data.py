"""What was recorded, and how far the two contacts lie apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firstcontact.models import DURATION, distinct_specimens
from firstcontact_lab.report.figures.offsets import offset_figure
from firstcontact_lab.report.figures.timing import timing_figure
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results.data import DataSummary, Offsets
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject


def describe(subject: Subject) -> PartResult:
    """Counts of the data, the offset distribution and the timing of one pinch."""
    dataset = subject.dataset
    recorded, rate = dataset.recorded_rate, float(dataset.layout.rate)
    summary = DataSummary(
        source=dataset.source,
        pinches=len(dataset),
        specimens=len(set(distinct_specimens(dataset)) - {""}),
        sample_rate_hz=rate if recorded is None else float(recorded),
        model_rate_hz=None if recorded is None else rate,
        sessions=len(set(dataset.sessions) - {""}),
        train_pinches=int((~dataset.test).sum()),
        test_pinches=int(dataset.test.sum()),
        objects=sorted(set(dataset.objects.tolist()) - {""}),
        notes=_merged([n for n in dataset.notes if n not in dataset.losses]),
    )
    spread = None
    figures: list[Figure] = []
    # What is missing is told where people look for it, not among what was assumed.
    left_out = [f"{loss.rstrip('.')}." for loss in _merged(dataset.losses)]
    offsets = np.array([1e3 * p.offset for p in dataset.pinches if p.offset is not None])
    if len(offsets):
        spread = Offsets(
            mean=float(offsets.mean()),
            # Of a single offset there is no spread to tell.
            sd=float(offsets.std(ddof=1)) if len(offsets) > 1 else None,
            share_below_15=float((offsets < 1e3 * DURATION).mean()),
            share_below_8=float((offsets < 8.0).mean()),
            median=float(np.median(offsets)),
            n=len(offsets),
        )
        figures.append(offset_figure(offsets))
        middle = min(
            (p for p in dataset.pinches if p.offset is not None),
            key=lambda p: abs(1e3 * (p.offset or 0.0) - float(offsets.mean())),
        )
        figures.insert(0, timing_figure(middle))
    else:
        left_out.append(
            "Offset between the contacts: no pinch has a known first and second contact."
        )
    return PartResult(SubjectResults(data=summary, offset_ms=spread), figures, left_out)


def _merged(notes: Sequence[str], most: int = 12) -> list[str]:
    """Notes without repetitions, the rest counted."""
    unique = list(dict.fromkeys(notes))
    if len(unique) <= most:
        return unique
    return [*unique[:most], f"... and {len(unique) - most} notes more of this kind."]
