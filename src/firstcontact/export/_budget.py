"""Reduction of models to a time budget on the microcontroller."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import first_contact
from firstcontact.core import Contact, Dataset, InputError
from firstcontact.export._c_anytime import instructions
from firstcontact.export._exporters import Part
from firstcontact.export._trained import NamedModel, Trained
from firstcontact.models import CompactNetwork, InContextModel, Windows, compacted, cut_touches
from firstcontact.signal import contact_windows

#: Clock of a Teensy 4, Hz, and assumed cycles per instruction.
CLOCK, CYCLES = 600e6, 1.5
#: Possible numbers of directions of the compact network's thin layers, and the default.
DIRECTIONS = (8, 12, 16, 24, 32, 48)
USUAL_DIRECTIONS = 16
#: Numbers of directions if the network uses the motor's pitch. The pitch is analysed once per
#: contact, in the time of two predictions.
LISTENING_DIRECTIONS = (16, 24)
#: Smallest number of windows to fit a smaller model to.
FEWEST_WINDOWS = 10


def microseconds(count: float) -> float:
    """Return the time (us) that the assumed microcontroller takes for a number of instructions."""
    return 1e6 * CYCLES * count / CLOCK


def small_enough(
    trained: Trained,
    dataset: Dataset | None,
    budget_us: float | None,
    parts: Collection[Part] = frozenset(Part),
) -> Trained:
    """Return the exported parts of a model, reduced to fit a time budget.

    Parameters
    ----------
    trained
        Exported parts of a model.
    dataset
        Training pinches, to which smaller models are fitted; None without them.
    budget_us
        Time that one prediction of each model may take, us; None keeps window models unchanged.
    parts
        Kinds of parts that may become smaller. Other parts stay unchanged.

    Raises
    ------
    InputError
        Even the smallest form of a model is too slow, or there are too few pinches to fit smaller
        forms to.
    """
    contacts = [] if dataset is None else _contacts(dataset, trained)
    models, anytime = trained.models, trained.anytime
    if Part.WINDOWS in parts:
        models = tuple(_fitting(named, dataset, contacts, budget_us) for named in models)
    if anytime is not None and dataset is not None and Part.ANYTIME in parts:
        anytime = _anytime(anytime, dataset, contacts, budget_us)
    return replace(trained, models=models, anytime=anytime)


def forms(named: NamedModel, X: Windows, sessions: NDArray[np.str_]) -> list[NamedModel]:
    """Return smaller forms of a window model, and the model itself, in order of size.

    Smaller models are fitted to four fifths of the sessions. In the held-out sessions, their
    predictions are compared with those of the original model. The difference widens the interval of
    the smaller model.

    Parameters
    ----------
    named
        Model with its interval.
    X, sessions
        Training windows, and the session of each.
    """
    is_held_out = np.isin(sessions, np.unique(sessions)[::5])
    if is_held_out.all():
        is_held_out = np.arange(len(X)) % 5 == 0
    candidates = []
    for form in named.model.smaller(X[~is_held_out]):
        interval = named.interval
        if interval is not None and not interval.scaled:
            away = np.abs(form.predict(X[is_held_out]) - named.model.predict(X[is_held_out]))
            further = float(np.quantile(away, interval.level))
            wider = tuple(half + further for half in interval.half_widths)
            interval = replace(interval, half_widths=wider)
        candidates.append(replace(named, model=form, interval=interval))
    return [*candidates, named]


def _contacts(dataset: Dataset, trained: Trained) -> list[Contact | None]:
    if any(p.first is not None for p in dataset.pinches) or trained.detector is None:
        return [p.first for p in dataset.pinches]
    return [first_contact(trained.detector, pinch) for pinch in dataset.pinches]


def _fitting(
    named: NamedModel,
    dataset: Dataset | None,
    contacts: list[Contact | None],
    budget_us: float | None,
) -> NamedModel:
    if budget_us is None:
        return named
    model = named.model
    candidates = [named]
    if dataset is not None:
        model.spec.require_rate(dataset.layout.rate)
        X, has_window = contact_windows(dataset, contacts, model.spec.duration)
        if len(X) < FEWEST_WINDOWS:
            raise InputError(
                f"--data holds only {len(X)} contacts: give the recordings that the model was "
                "trained on"
            )
        candidates = forms(named, X, dataset.sessions[has_window])
    took = [microseconds(form.model.program().instructions) for form in candidates]
    quick = [form for form, time in zip(candidates, took, strict=True) if time <= budget_us]
    if not quick:
        least = took[0]
        raise InputError(
            f"the smallest form of {named.name} takes about {least:.0f} us, more than --budget-us "
            f"{budget_us:g}: raise it"
            + ("" if dataset is not None else ", or give its training recordings with --data")
        )
    return quick[-1]


def compact_forms(
    model: InContextModel, dataset: Dataset, contacts: list[Contact | None]
) -> Iterator[InContextModel]:
    """Yield the network in compact forms, the smallest first."""
    touches, _ = cut_touches(dataset, contacts)
    for directions in DIRECTIONS:
        yield compacted(model, touches, directions)
    for directions in LISTENING_DIRECTIONS:
        yield compacted(model, touches, directions, listening=True)


def _anytime(
    model: InContextModel,
    dataset: Dataset,
    contacts: list[Contact | None],
    budget_us: float | None,
) -> InContextModel:
    if budget_us is None:
        touches, _ = cut_touches(dataset, contacts)
        return compacted(model, touches, USUAL_DIRECTIONS)
    took: list[float] = []
    chosen = None
    for form in compact_forms(model, dataset, contacts):
        assert isinstance(form.network, CompactNetwork)
        took.append(microseconds(instructions(form)))
        if took[-1] > budget_us:
            break
        chosen = form
    if chosen is None:
        raise InputError(
            f"the smallest form of the network takes about {min(np.array(took)):.0f} us, more than "
            f"--budget-us {budget_us:g}: raise it"
        )
    return chosen
