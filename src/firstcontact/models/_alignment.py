"""Alignment of training windows to contacts, and the fitted contact detector."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import (
    DETECTORS,
    Detector,
    closing_starts,
    count_starts,
    cut_closings,
    describe_starts,
    detect,
    general_detector,
    is_pretrained,
    make_detector,
)
from firstcontact.core import Contact, Dataset, InputError, Runner
from firstcontact.models._splits import inner_folds

Places = NDArray[np.intp]

#: Detectors that find the contacts of pinches they did not learn from.
FOLDS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """First contacts of pinches.

    Parameters
    ----------
    contacts
        One a pinch, None where none was found.
    how
        How they were found, and from where on was listened, in words.
    """

    contacts: Sequence[Contact | None]
    how: str


def label_alignment(dataset: Dataset) -> Alignment:
    """Contacts as the strips or labels say."""
    return Alignment([p.first for p in dataset.pinches], "known (strips or labels)")


def detect_alignment(dataset: Dataset, detector: Detector, how: str = "") -> Alignment:
    """Contacts as a detector finds them, from where each closing starts."""
    starts = closing_starts(dataset)
    heard = cut_closings(dataset, starts).pinches
    contacts = [next(iter(detect(detector, pinch)), None) for pinch in heard]
    return Alignment(
        contacts, f"detected ({detector.name}{how}; {describe_starts(count_starts(starts))})"
    )


def fit_detector(dataset: Dataset, name: str | None = None) -> Detector:
    """Return a detector that learned from these pinches.

    Parameters
    ----------
    dataset
        The pinches.
    name
        In the registry; None for the default one where it can learn from these pinches,
        and else the one of the package, or one that learns nothing.

    Raises
    ------
    InputError
        The one named cannot learn from these pinches.
    """
    if name is not None:
        return make_detector(name).fit(dataset)
    if any(p.first is not None for p in dataset.pinches):
        try:
            return make_detector(DETECTORS.default).fit(dataset)
        except InputError:
            pass  # too little quiet before the contacts: nothing to learn a steady state from
    return general_detector(dataset.layout)


def found_as_live(dataset: Dataset, detector: Detector, seed: int, runner: Runner) -> Alignment:
    """Return contacts as a detector finds them live, fitted without the pinch itself.

    Sessions stay whole. What learned from a pinch places its contact better than
    it will place any other.

    Parameters
    ----------
    dataset
        The pinches.
    detector
        What :func:`fit_detector` made of them.
    seed
        Of the folds.
    runner
        Does the folds.
    """
    if not detector.learns or is_pretrained(detector):
        return detect_alignment(dataset, detector)
    starts = closing_starts(dataset)
    dataset = cut_closings(dataset, starts)
    sessions = dataset.sessions if "" not in dataset.sessions else None
    contacts: list[Contact | None] = [None] * len(dataset)
    folds = list(inner_folds(np.zeros(len(dataset)), sessions, seed, FOLDS))
    answers = runner.map(_found_apart, folds, dataset, detector.name)
    for (_, ask), answered in zip(folds, answers, strict=True):
        for place, contact in zip(ask, answered, strict=True):
            contacts[place] = contact
    apart = "pinches" if sessions is None or len(np.unique(sessions)) < 2 else "sessions"
    begin = describe_starts(count_starts(starts))
    how = f"detected ({detector.name} that learned from other {apart}; {begin})"
    return Alignment(contacts, how)


def _found_apart(
    fold: tuple[Places, Places], dataset: Dataset, detector: str
) -> Sequence[Contact | None]:
    """Contacts of the second pinches by a detector that learned from the first."""
    learn, ask = fold
    other = make_detector(detector).fit(dataset.take(learn))
    return detect_alignment(dataset.take(ask), other).contacts
