"""Means and shares over the closings of the payload task, with intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from firstcontact.models import Values, cluster_intervals
from firstcontact_lab.grasping._trials import Row
from firstcontact_lab.grasping.results import Policies, Summary
from firstcontact_lab.grasping.settings import KINDS, SOFT


def _breaks(row: Row) -> bool:
    return KINDS[row.kind].fragility is not None


#: Groups of objects whose closings are summarised together. Brittle objects are apart, because the
#: peak force on an object that broke is only its breaking force.
GROUPS: Mapping[str, Callable[[Row], bool]] = {
    "soft": lambda row: not _breaks(row) and row.shore_a <= SOFT,
    "firm": lambda row: not _breaks(row) and row.shore_a > SOFT,
    "lasting": lambda row: not _breaks(row),
    "brittle": _breaks,
    "all": lambda row: True,
}


def milliseconds(latency: float) -> str:
    """Return a latency, given in s, as a key of the results, in ms."""
    return f"{1e3 * latency:g}"


def summary(rows: Sequence[Row], seed: int) -> Summary:
    """Return means and shares of outcomes over closings."""
    steady = np.array([r.time is not None for r in rows], dtype=float)
    columns = np.stack(
        [
            np.ones(len(rows)),
            [r.peak for r in rows],
            [1e3 * r.squeeze for r in rows],
            [1e3 * (r.time or 0.0) for r in rows],
            steady,
            [r.dropped for r in rows],
            [r.broken for r in rows],
        ],
        axis=1,
    )
    means: dict[str, Callable[[Values], Values]] = {
        "peak_n": lambda s: s[..., 1] / s[..., 0],
        "squeeze_mm": lambda s: s[..., 2] / s[..., 0],
        "steady": lambda s: s[..., 4] / s[..., 0],
        "dropped": lambda s: s[..., 5] / s[..., 0],
        "broken": lambda s: s[..., 6] / s[..., 0],
    }
    if steady.any():
        # A resample without a steady grasp has no mean time: use that of all closings.
        mean_time = columns[:, 3].sum() / steady.sum()
        means["time_ms"] = lambda s: np.where(
            s[..., 4] > 0, s[..., 3] / np.maximum(s[..., 4], 1), mean_time
        )
    sessions = np.array([r.session for r in rows])
    total = columns.sum(axis=0)
    return Summary(
        **{name: float(of(total)) for name, of in means.items()},
        n=len(rows),
        misses=sum(r.misses for r in rows),
        intervals=cluster_intervals(columns, means, sessions, seed),
    )


def by_policy(rows: Sequence[Row], seed: int) -> Policies:
    """Return the :func:`summary` of each variant, latency (ms) and group of objects."""
    policies: Policies = {}
    for variant, latency in dict.fromkeys((r.variant, r.latency) for r in rows):
        selected = [r for r in rows if r.variant == variant and r.latency == latency]
        groups = {name: [r for r in selected if belongs(r)] for name, belongs in GROUPS.items()}
        policies.setdefault(variant, {})[milliseconds(latency)] = {
            name: summary(group, seed) for name, group in groups.items() if group
        }
    return policies
