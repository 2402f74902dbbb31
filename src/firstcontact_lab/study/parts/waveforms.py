"""What contact looks like on the vibration sensor, by stiffness."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.models import DURATION
from firstcontact_lab.report.figures.responses import peak_figure, response_figure
from firstcontact_lab.report.figures.style import vibration_unit
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.data import PeakVoltage
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject


def waveforms(subject: Subject) -> PartResult:
    """Representative responses and peak amplitude against Shore A."""
    if len(subject.levels) < 2:
        return PartResult(
            left_out=["Responses by stiffness: the data have no two Shore A levels to learn from."]
        )
    data = subject.windows(DURATION)
    blocks = data.take(~data.test)
    if len(blocks) < 2:
        return PartResult(left_out=["Responses by stiffness: no contact was found to start from."])
    unit = vibration_unit(subject.dataset.layout)
    peaks = np.abs(blocks.X[:, :, 0]).max(axis=1).astype(np.float64)
    by_level = {f"{level:g}": _peaks(peaks[blocks.y == level]) for level in np.unique(blocks.y)}
    return PartResult(
        SubjectResults(peak_v=by_level),
        [response_figure(blocks, unit), peak_figure(blocks.y, peaks, unit)],
    )


def _peaks(values: NDArray[np.float64]) -> PeakVoltage:
    spread = float(values.std(ddof=1)) if len(values) > 1 else None
    return PeakVoltage(mean=float(values.mean()), sd=spread, n=len(values))
