"""Competitors whose predictions are compared: estimators, network, floor and ceilings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import gent_shore_a
from firstcontact.models import (
    SHORE_A,
    ContactPredictor,
    Fit,
    Task,
    Touches,
    fit_model,
    rig_estimators,
)
from firstcontact_lab.study._rig_sets import RigSet
from firstcontact_lab.study.window_ladder import fit_window_ladder, registered

Index = NDArray[np.intp]
Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Entrant:
    """Competitor of a comparison."""

    name: str
    method: str
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Query:
    """Job of one competitor on one set: pinches to learn from, and pinches to predict."""

    entrant: Entrant
    place: int
    learn: Index
    ask: Index


def answer(query: Query, sets: Sequence[RigSet], seed: int) -> Values:
    """Return the predicted Shore A of each pinch in ``query.ask``, shape (n,)."""
    entrant = query.entrant
    return WAYS[entrant.method](entrant, sets[query.place], query.learn, query.ask, seed)


def _trained(entrant: Entrant, rigs: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """Fit a registered estimator to the pinches ``learn``, and predict the pinches ``ask``."""
    options = dict(entrant.options)
    name = options.pop("estimator")
    X = rigs.windows.X[ask]
    fit = Fit(name, Task.REGRESSION, rigs.windows.take(learn), X, seed, options)
    return fit_model(fit).predict(X).astype(np.float64)


def _in_context(entrant: Entrant, rigs: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """Condition an any-time estimator on the pinches ``learn``, and predict the pinches ``ask``."""
    query = rigs.touches.take(ask)
    if entrant.options.get("radii"):
        query = replace(query, radii=rigs.radii[ask])
    return fit_on_set(entrant, rigs, learn, seed).predict(query).value


def _anybody(entrant: Entrant, rigs: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """Fit an estimator or a user's regressor to ``learn``, and predict the pinches ``ask``."""
    return fit_on_set(entrant, rigs, learn, seed).predict(rigs.touches.take(ask)).value


def fit_on_set(entrant: Entrant, rigs: RigSet, learn: Index, seed: int) -> ContactPredictor:
    """Return a competitor that learned from some pinches of a set; see :func:`fit_predictor`."""
    windows = rigs.windows
    return fit_predictor(
        entrant, rigs.touches.take(learn), windows.y[learn], windows.sessions[learn], seed
    )


def fit_predictor(
    entrant: Entrant, touches: Touches, shore_a: Values, groups: NDArray[np.str_], seed: int
) -> ContactPredictor:
    """Return a competitor that learned from contacts, and predicts at any time after a contact."""
    options = dict(entrant.options)
    regressor, name = options.pop("regressor", None), options.pop("estimator", None)
    if entrant.method == "in context":
        kind = rig_estimators()[name]
        return kind(Task.REGRESSION, touches.rate).fit_touches(touches, shore_a, groups, seed).model
    learner = registered(name if regressor is None else regressor, options)
    return fit_window_ladder(learner, touches, shore_a, groups, seed=seed)


def _modulus(entrant: Entrant, rigs: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """Predict the Shore A from the true modulus of each pinch, by Gent's formula."""
    return np.array([gent_shore_a(modulus) for modulus in rigs.moduli[ask]])


def _stiffness(entrant: Entrant, rigs: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """Predict the Shore A by a parabola in the logarithm of the true contact stiffness."""
    logarithms = np.log(rigs.stiffnesses)
    shore_a = rigs.windows.y[learn]
    degree = min(2, len(np.unique(shore_a)) - 1)
    line = np.polynomial.Polynomial.fit(logarithms[learn], shore_a, degree)
    estimates: Values = np.clip(line(logarithms[ask]), *SHORE_A)
    return estimates


WAYS = {
    "trained": _trained,
    "anybody": _anybody,
    "in context": _in_context,
    "told the modulus": _modulus,
    "told the stiffness": _stiffness,
}
