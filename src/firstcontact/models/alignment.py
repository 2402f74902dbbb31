"""Contacts at which training windows start, and the choice and fitting of the contact detector."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, general_detector, make_detector
from firstcontact.contact.closing_start import (
    closing_starts,
    count_starts,
    cut_closings,
    describe_starts,
)
from firstcontact.contact.contacts import first_contact
from firstcontact.contact.detector_file import is_pretrained
from firstcontact.core import ArgumentError, Contact, Dataset, InputError
from firstcontact.core.installation import missing_modules, require_modules
from firstcontact.core.text import counted
from firstcontact.jobs import Runner
from firstcontact.models.splits import inner_folds
from firstcontact.signal import resample_dataset
from firstcontact.signal.resampling import restore_contacts

Places = NDArray[np.intp]
Contacts = Literal["detected", "known"]

_log = logging.getLogger("firstcontact.models")

#: Largest distance of a contact that is placed right from the known one, s.
TOLERANCE = 0.003
#: Number of folds. A detector is fitted without one fold, and then finds the contacts of that fold.
FOLDS = 3
#: Note in models that were made with the base install.
NOT_FITTED = "the package's detector is used: to fit one to your pinches, install the extra 'train'"


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """First contact of each pinch (None without one), and a text on their source in ``how``."""

    contacts: Sequence[Contact | None]
    how: str


def at_known_contacts(contacts: str, dataset: Dataset) -> bool:
    """Return True if training windows start at the contacts in the data: ``contacts`` is "known".

    Return False for "detected". Raise ArgumentError for another value, or if the data have no
    contacts.
    """
    if contacts not in get_args(Contacts):
        raise ArgumentError(
            f"{contacts!r} is not a kind of contact: choose one of {', '.join(get_args(Contacts))}",
            parameter="contacts",
        )
    if contacts == "known" and all(p.first is None for p in dataset.pinches):
        raise ArgumentError(
            'no pinch has a known first contact: use "detected", or import recordings with a '
            "column 'first_contact'",
            parameter="contacts",
        )
    return contacts == "known"


def label_alignment(dataset: Dataset) -> Alignment:
    """Return the first contacts that the dataset contains, from contact strips or labels."""
    return Alignment([p.first for p in dataset.pinches], "known (strips or labels)")


def detect_alignment(dataset: Dataset, detector: Detector, how: str = "") -> Alignment:
    """Return the first contact of each pinch that a detector finds after the start of the closing.

    ``how`` is appended to the detector's name in the text on the source of the contacts.
    """
    rate = detector.rate
    resampled = dataset if rate is None else resample_dataset(dataset, rate)
    starts = closing_starts(resampled)
    heard = cut_closings(resampled, starts).pinches
    contacts = [first_contact(detector, pinch) for pinch in heard]
    if rate is not None:
        contacts = restore_contacts(contacts, dataset, rate)
    return Alignment(
        contacts, f"detected ({detector.name}{how}; {describe_starts(count_starts(starts))})"
    )


def fit_detector(dataset: Dataset, name: str | None = None) -> Detector:
    """Return the detector of this name, fitted to the pinches.

    Without a name, fit the default detector. If the pinches have no known contacts, or too little
    signal before them, return the package's fitted detector instead.
    """
    if name is not None:
        return make_detector(name).fit(dataset)
    if any(p.first is not None for p in dataset.pinches):
        require_modules("train", "sklearn")
        try:
            return make_detector(DETECTORS.default).fit(dataset)
        except InputError:
            pass  # too little quiet before the contacts: nothing to learn a steady state from
    return general_detector(dataset.layout)


def choose_detector(
    dataset: Dataset, name: str | None, is_known: bool, seed: int, runner: Runner
) -> tuple[Detector, Alignment, str]:
    """Choose the package's detector or one fitted to these pinches.

    With a ``name``, that detector is fitted. Without one, the package's detector is kept unless a
    fitted one places clearly more known contacts within 3 ms. ``is_known`` is True if training
    windows start at the contacts in the data.

    Return the detector, the contacts at which training windows start, and a sentence on the choice.
    """
    shipped = general_detector(dataset.layout)
    if name is None and missing_modules(["sklearn"]):
        alignment = label_alignment(dataset) if is_known else detect_alignment(dataset, shipped)
        return shipped, alignment, NOT_FITTED
    fitted = fit_detector(dataset, name)
    if name is not None or not is_pretrained(shipped) or is_pretrained(fitted):
        if is_known:
            return fitted, label_alignment(dataset), ""
        return fitted, found_as_live(dataset, fitted, seed, runner), ""
    shipped_alignment = detect_alignment(dataset, shipped, " of the package")
    try:
        fitted_alignment = found_as_live(dataset, fitted, seed, runner)
    except InputError:  # a part of the pinches has too few known contacts
        reason = "the package's detector is used: too few known contacts to compare it"
        return shipped, label_alignment(dataset) if is_known else shipped_alignment, reason
    by_fitted = _is_detected(dataset, fitted_alignment)
    by_shipped = _is_detected(dataset, shipped_alignment)
    gain = int(by_fitted.sum()) - int(by_shipped.sum())
    takes_fitted = gain > np.sqrt(np.count_nonzero(by_fitted != by_shipped))
    used = "a detector fitted to these pinches" if takes_fitted else "the package's detector"
    reason = (
        f"{used} is used: of {counted(len(by_fitted), 'known contact')}, the package's detector "
        f"finds {by_shipped.sum()} within 3 ms, and one fitted to your other pinches "
        f"{by_fitted.sum()}"
    )
    _log.info("%s", reason)
    detector, alignment = (
        (fitted, fitted_alignment) if takes_fitted else (shipped, shipped_alignment)
    )
    return detector, label_alignment(dataset) if is_known else alignment, reason


def _is_detected(dataset: Dataset, alignment: Alignment) -> NDArray[np.bool_]:
    """Return a mask over the known contacts, True if the detector found the contact.

    It counts as found on the same finger and within 3 ms.
    """
    return np.array(
        [
            contact is not None
            and contact.finger is pinch.first.finger
            and abs(contact.sample - pinch.first.sample) / pinch.layout.rate <= TOLERANCE
            for pinch, contact in zip(dataset.pinches, alignment.contacts, strict=True)
            if pinch.first is not None
        ]
    )


def found_as_live(dataset: Dataset, detector: Detector, seed: int, runner: Runner) -> Alignment:
    """Return the first contacts that a live session would detect.

    The detector for the pinches of a session is fitted to other sessions, or to other pinches if
    the sessions have no names. A detector that needs no training, or that the package contains
    already trained, is used unchanged.
    """
    if not detector.learns or is_pretrained(detector):
        return detect_alignment(dataset, detector)
    starts = closing_starts(dataset)
    dataset = cut_closings(dataset, starts)
    sessions = dataset.sessions if "" not in dataset.sessions else None
    contacts: list[Contact | None] = [None] * len(dataset)
    folds = list(inner_folds(np.zeros(len(dataset)), sessions, seed, FOLDS))
    answers = runner.map(_detect_held_out, folds, dataset, detector.name)
    for (_, ask), answered in zip(folds, answers, strict=True):
        for place, contact in zip(ask, answered, strict=True):
            contacts[place] = contact
    apart = "pinches" if sessions is None or len(np.unique(sessions)) < 2 else "sessions"
    begin = describe_starts(count_starts(starts))
    how = f"detected ({detector.name} that learned from other {apart}; {begin})"
    return Alignment(contacts, how)


def _detect_held_out(
    fold: tuple[Places, Places], dataset: Dataset, detector: str
) -> Sequence[Contact | None]:
    """Fit the named detector to some pinches. Return the contacts that it detects in others.

    ``fold`` holds two arrays of indices: the pinches to fit to, and those for detection.
    """
    learn, ask = fold
    other = make_detector(detector).fit(dataset.take(learn))
    return detect_alignment(dataset.take(ask), other).contacts
