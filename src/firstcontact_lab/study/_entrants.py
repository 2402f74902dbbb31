"""Who is asked off the blocks: every estimator, the in-context network, and those told more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import gent_shore_a
from firstcontact.models import (
    SHORE_A,
    Answering,
    Fit,
    Task,
    Touches,
    adapt_network,
    fit_model,
    fit_window_ladder,
    pretrained,
    registered,
)
from firstcontact_lab.study._rig_sets import RigSet

Index = NDArray[np.intp]
Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Entrant:
    """Somebody who answers.

    Parameters
    ----------
    name
        In results.
    way
        Which of ``WAYS`` answers.
    options
        For that one.
    """

    name: str
    way: str
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """One question to one entrant: which pinches of which set to know, and which to tell."""

    entrant: Entrant
    place: int
    learn: Index
    ask: Index


def answer(asked: Asked, sets: Sequence[RigSet], seed: int) -> Values:
    """Shore A of each pinch that is asked about, shape (n,)."""
    entrant = asked.entrant
    return WAYS[entrant.way](entrant, sets[asked.place], asked.learn, asked.ask, seed)


def _trained(entrant: Entrant, its: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """A registered estimator, which learns from these pinches and nothing else."""
    options = dict(entrant.options)
    name = options.pop("estimator")
    X = its.windows.X[ask]
    fit = Fit(name, Task.REGRESSION, its.windows.take(learn), X, seed, options)
    return fit_model(fit).predict(X).astype(np.float64)


def _in_context(entrant: Entrant, its: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """The in-context network, which is told of these pinches; of radii where it is to be."""
    asked = its.touches.take(ask)
    if entrant.options.get("radii"):
        asked = replace(asked, radii=its.radii[ask])
    return fit_on_set(entrant, its, learn, seed).answers(asked).values


def _anybody(entrant: Entrant, its: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """A regressor of a user's own: a model a length, answering by the longest that is filled."""
    return fit_on_set(entrant, its, learn, seed).answers(its.touches.take(ask)).values


def fit_on_set(entrant: Entrant, its: RigSet, learn: Index, seed: int) -> Answering:
    """Fit an entrant to pinches of a set; see :func:`fit_answering`."""
    windows = its.windows
    return fit_answering(
        entrant, its.touches.take(learn), windows.y[learn], windows.sessions[learn], seed
    )


def fit_answering(
    entrant: Entrant, touches: Touches, shore_a: Values, groups: NDArray[np.str_], seed: int
) -> Answering:
    """Condition the in-context network on contacts, or train one model a window length.

    Parameters
    ----------
    entrant
        In-context network, registered estimator or regressor of a user.
    touches, shore_a
        Contacts to learn from, shape (n,).
    groups
        Session or specimen of each contact, held out whole for intervals, shape (n,).
    seed
        Random seed of trainings and folds.
    """
    if entrant.way == "in context":
        return adapt_network(pretrained(), touches, shore_a, groups, seed).model
    options = dict(entrant.options)
    own, name = options.pop("regressor", None), options.pop("estimator", None)
    learner = registered(name if own is None else own, options)
    return fit_window_ladder(learner, touches, shore_a, groups, seed=seed)


def _modulus(entrant: Entrant, its: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """Gent's reading of the modulus at that very pinch."""
    return np.array([gent_shore_a(modulus) for modulus in its.moduli[ask]])


def _stiffness(entrant: Entrant, its: RigSet, learn: Index, ask: Index, seed: int) -> Values:
    """A parabola in the logarithm of the contact's stiffness, through what was learned."""
    known = np.log(its.stiffnesses)
    shore_a = its.windows.y[learn]
    degree = min(2, len(np.unique(shore_a)) - 1)
    line = np.polynomial.Polynomial.fit(known[learn], shore_a, degree)
    told: Values = np.clip(line(known[ask]), *SHORE_A)
    return told


WAYS = {
    "trained": _trained,
    "anybody": _anybody,
    "in context": _in_context,
    "told the modulus": _modulus,
    "told the stiffness": _stiffness,
}
