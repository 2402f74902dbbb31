"""From rows to what is reported: means, shares, differences, each with its interval."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from firstcontact.core.by_name import ByName
from firstcontact.grasp.policy import Part
from firstcontact.grasp_study._trials import Row
from firstcontact.grasp_study.results import (
    Comparison,
    Difference,
    Headline,
    HeadlineConditions,
    Met,
    ObjectSummary,
    Policies,
    Summary,
    Target,
)
from firstcontact.grasp_study.settings import HEADLINE, KINDS, SOFT
from firstcontact.grasp_study.variants import playing
from firstcontact.learning.metrics import Values, cluster_intervals

#: What was to be reached, at the headline's latency.
LESS_PEAK, LONGER = 0.30, 0.10


def _breaks(row: Row) -> bool:
    return KINDS[row.kind].fragility is not None


#: Objects that are told of together. The peak of what broke says how much it bore, no more.
GROUPS: Mapping[str, Callable[[Row], bool]] = {
    "soft": lambda row: not _breaks(row) and row.shore_a <= SOFT,
    "firm": lambda row: not _breaks(row) and row.shore_a > SOFT,
    "lasting": lambda row: not _breaks(row),
    "brittle": _breaks,
    "all": lambda row: True,
}


def milliseconds(latency: float) -> str:
    """Of a latency, as a key."""
    return f"{1e3 * latency:g}"


def summary(rows: Sequence[Row], seed: int) -> Summary:
    """Means and shares over closings."""
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
        # A resample without a steady grasp has no time: it counts as the mean.
        whole = columns[:, 3].sum() / steady.sum()
        means["time_ms"] = lambda s: np.where(
            s[..., 4] > 0, s[..., 3] / np.maximum(s[..., 4], 1), whole
        )
    sessions = np.array([r.session for r in rows])
    total = columns.sum(axis=0)
    return Summary(
        **{name: float(of(total)) for name, of in means.items()},
        n=len(rows),
        misses=sum(r.misses for r in rows),
        intervals=cluster_intervals(columns, means, sessions, seed),
    )


def compared(ours: Sequence[Row], theirs: Sequence[Row], seed: int) -> Difference:
    """What one policy does to the same pinches otherwise than another.

    Parameters
    ----------
    ours, theirs
        Rows of the same pinches in the same order.
    seed
        Of the intervals.
    """
    same = [(r.kind, r.session, r.latency) for r in ours]
    if same != [(r.kind, r.session, r.latency) for r in theirs]:
        raise ValueError("the rows are of different pinches")
    pairs = list(zip(ours, theirs, strict=True))
    both = [a.time is not None and b.time is not None for a, b in pairs]
    columns = np.stack(
        [
            [a.peak for a, _ in pairs],
            [b.peak for _, b in pairs],
            [(a.time or 0.0) * k for (a, _), k in zip(pairs, both, strict=True)],
            [(b.time or 0.0) * k for (_, b), k in zip(pairs, both, strict=True)],
        ],
        axis=1,
    )
    ratios: dict[str, Callable[[Values], Values]] = {
        "less_peak": lambda s: 1 - s[..., 0] / s[..., 1]
    }
    if any(both):
        ratios["longer"] = lambda s: np.where(
            s[..., 3] > 0, s[..., 2] / np.maximum(s[..., 3], 1e-9) - 1, 0.0
        )
    total = columns.sum(axis=0)
    return Difference(
        **{name: float(of(total)) for name, of in ratios.items()},
        more_dropped=sum(a.dropped - b.dropped for a, b in pairs),
        more_broken=sum(a.broken - b.broken for a, b in pairs),
        n=len(pairs),
        intervals=cluster_intervals(columns, ratios, np.array([r.session for r in ours]), seed),
    )


def by_policy(rows: Sequence[Row], seed: int) -> Policies:
    """Variant to latency (ms) to group to :func:`summary`."""
    found: Policies = {}
    for variant, latency in dict.fromkeys((r.variant, r.latency) for r in rows):
        its = [r for r in rows if r.variant == variant and r.latency == latency]
        groups = {name: [r for r in its if belongs(r)] for name, belongs in GROUPS.items()}
        found.setdefault(variant, {})[milliseconds(latency)] = {
            name: summary(group, seed) for name, group in groups.items() if group
        }
    return found


def by_object(rows: Sequence[Row], seed: int) -> dict[str, ObjectSummary]:
    """Object to variant to :func:`summary`, at the headline's latency."""
    found = {}
    here = [r for r in rows if r.latency == HEADLINE]
    for kind in dict.fromkeys(r.kind for r in here):
        its = [r for r in here if r.kind == kind]
        found[kind] = ObjectSummary(
            shore_a=KINDS[kind].shore_a,
            breaks=KINDS[kind].fragility is not None,
            variants={
                v: summary([r for r in its if r.variant == v], seed)
                for v in dict.fromkeys(r.variant for r in its)
            },
        )
    return found


def headline(rows: Sequence[Row], seed: int) -> Headline:
    """The target at the headline's latency: each candidate against every baseline and control."""
    here = [r for r in rows if r.latency == HEADLINE]

    def of(variant: str, group: str) -> list[Row]:
        belongs = GROUPS[group]
        return [r for r in here if r.variant == variant and belongs(r)]

    baselines, controls, candidates = (
        [v.key for v in playing(part)] for part in (Part.BASELINE, Part.CONTROL, Part.CANDIDATE)
    )
    peaks = {v: float(np.mean([r.peak for r in of(v, "soft")])) for v in baselines}
    about = HeadlineConditions(
        latency_ms=1e3 * HEADLINE,
        soft_up_to=SOFT,
        best_feedback=min(peaks, key=lambda v: peaks[v]),
        target=Target(less_peak=LESS_PEAK, more_dropped=0, longer=LONGER),
    )
    found: dict[str, dict[str, Comparison]] = {}
    for variant in candidates:
        against = {}
        for other in (*baselines, *controls):
            soft = compared(of(variant, "soft"), of(other, "soft"), seed)
            lasting = compared(of(variant, "lasting"), of(other, "lasting"), seed)
            everything = compared(of(variant, "all"), of(other, "all"), seed)
            met = Met(
                less_peak=soft.less_peak >= LESS_PEAK,
                more_dropped=everything.more_dropped <= 0,
                longer=lasting.longer is not None and lasting.longer <= LONGER,
            )
            against[other] = Comparison(soft=soft, lasting=lasting, all=everything, met=met)
        found[variant] = against
    return ByName(found, about)
