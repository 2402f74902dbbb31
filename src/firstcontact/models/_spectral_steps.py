"""Steps that compute the features of the log spectrum in C."""

from __future__ import annotations

import numpy as np

from firstcontact.core import INPUT, Program, Step
from firstcontact.core import shape_steps as shapes
from firstcontact.core.layer_steps import plus
from firstcontact.core.steps import dense
from firstcontact.models._spec import Spec, Values
from firstcontact.models._spectral_features import (
    FLOOR,
    KINDS,
    QUANTILES,
    faded_lines,
    in_bands,
    padded_length,
)

#: Number of values that describe the course in time.
COURSE = len(QUANTILES) + 3


def spectral_program(kind: str, spec: Spec, weights: Values, offset: Values) -> Program:
    """Return the arithmetic of a linear model on the features of each channel, as steps."""
    n, channels = spec.samples, spec.channels
    made: list[Step] = [shapes.over_peak(INPUT, "waves", n * channels)]
    parts: list[str] = []
    columns = np.split(weights, channels, axis=1)
    for channel, column in enumerate(columns):
        at = f"_{channel}"
        spectral, course_weights = column, column[:, :0]
        if "course" in kind:
            spectral, course_weights = column[:, :-COURSE], column[:, -COURSE:]
        length = padded_length(n) if "bands" in kind else n
        lines = faded_lines(n, length)
        heard = np.zeros((2 * len(lines), n, channels))
        heard[:, :, channel] = np.concatenate([lines.real, lines.imag])
        made.append(
            dense("waves", "lines" + at, heard.reshape(len(heard), -1), np.zeros(len(heard)))
        )
        made.append(shapes.powers("lines" + at, "power" + at, len(lines)))
        level, size = "power" + at, len(lines)
        if "bands" in kind:
            bands = in_bands(length, spec.rate).T
            level, size = "bands" + at, len(bands)
            made.append(dense("power" + at, level, bands, np.zeros(size)))
        made.append(shapes.level_free(level, "spectrum" + at, size, FLOOR / size))
        made.append(dense("spectrum" + at, "said" + at, spectral, offset / channels))
        parts.append("said" + at)
        if course_weights.size:
            made.append(shapes.course(INPUT, "course" + at, n, channels, channel, QUANTILES))
            made.append(
                dense("course" + at, "when" + at, course_weights, np.zeros(len(course_weights)))
            )
            parts.append("when" + at)
    total = parts[0]
    for number, part in enumerate(parts[1:]):
        made.append(plus((total, part), f"sum_{number}", len(offset)))
        total = f"sum_{number}"
    assert kind in KINDS
    return Program(n * channels, tuple(made), total)
