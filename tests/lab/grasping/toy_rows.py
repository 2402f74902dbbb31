"""Artificial rows of a grasp study, with known numbers."""

from __future__ import annotations

from firstcontact_lab.grasping._trials import Row
from firstcontact_lab.grasping._variants import variants
from firstcontact_lab.grasping.settings import HEADLINE, KINDS

OBJECTS = ("block 5", "block 20", "block 60", "egg shell")
SESSIONS = 4
LATENCIES = (HEADLINE, 0.060)


def row(kind: str, session: int, variant: str, latency: float, peak: float) -> Row:
    """Return the row of one closing. No object is dropped; the egg breaks above 6 N."""
    return Row(
        kind=kind, shore_a=KINDS[kind].shore_a, session=session, variant=variant,
        latency=latency, peak=peak, squeeze=1e-3 * peak, time=0.1 + 0.01 * session,
        slipped=0.0, dropped=False, broken=kind == "egg shell" and peak > 6, touched=0.14,
        offset=0.02, estimate=None, misses=int(variant == "first_contact"), estimates=0,
    )  # fmt: skip


#: Peak force of every closing of a variant, N.
PEAKS = dict(zip(variants(), (12.0, 5.0, 4.0, 2.5, 2.6, 2.0), strict=True))


def rows() -> list[Row]:
    """Return rows of every variant on the same pinches."""
    return [
        row(kind, session, variant, latency, PEAKS[variant])
        for session in range(SESSIONS)
        for kind in OBJECTS
        for latency in LATENCIES
        for variant in PEAKS
    ]
