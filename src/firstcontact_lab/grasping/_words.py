"""Names, shares and intervals as people read them."""

from __future__ import annotations

from firstcontact.core import percent as any_percent
from firstcontact.grasp import POLICIES
from firstcontact_lab.grasping.results import CEILING, Between

#: What is no policy, as it is called.
REFERENCES = {
    "label": "label told",
    "label_rmse_3": "label with noise, RMSE 3",
    "label_rmse_5": "label with noise, RMSE 5",
    "label_rmse_10": "label with noise, RMSE 10",
    CEILING: "ceiling (each specimen known)",
}


def title_of(name: str) -> str:
    """Of a policy or a reference, as people read it."""
    return POLICIES[name].title if name in POLICIES else REFERENCES.get(name, name)


def percent(share: float) -> str:
    """Return a share as a whole percentage."""
    return any_percent(share, 0)


def ends(found: Between, sign: bool = False) -> str:
    """A share with its interval."""
    form = "{:+.0f}" if sign else "{:.0f}"
    value, low, high = (form.format(100 * x + 0.0) for x in (found.value, found.low, found.high))
    return f"{value} % ({low} to {high})".replace("-", "−")
