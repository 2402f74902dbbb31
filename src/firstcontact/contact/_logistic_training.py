"""What the logistic detector learns from: all looks at a pinch, before and after its contacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.signal import lfilter

from firstcontact.contact._loudness import EACH, ORDER, loudness_features, prediction
from firstcontact.contact._stream import SteadyState, WindowSizes
from firstcontact.core import Pinch
from firstcontact.signal import DeviceSmoothing, samples_in

#: Looks that must agree, each a step after the other: 1.2 ms, which outlasts most clicks.
LOOKS = 4
#: Ages of a contact, s, at which a look is to show it.
YOUNGEST, OLDEST = 0.0008, 0.0030
#: A contact is to be decided at this age, s.
DUE = 0.0026
#: Clicks that are added to a channel of a pinch, were it quiet all along; their median peak in
#: sigmas of what cannot be foretold, most samples, and the share of the ringing that is left
#: after each sample.
CLICKS = 4.0
CLICK = 8.0
CLICK_LENGTH = 5
DAMPED = 0.9
#: Most looks of a kind that are learned from.
MOST = 40_000


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """All looks at one pinch, of each finger one after the other.

    Parameters
    ----------
    features
        Shape (looks, features).
    quiet
        Whether the finger has touched nothing yet, shape (looks,).
    shows
        Whether the finger's contact is of an age to be shown, shape (looks,).
    early, due
        Whether the look ends before the first contact of the pinch, and whether it may
        decide that one in time, shape (looks,).
    begins
        Where the looks of each finger begin, and the number of all.
    """

    features: NDArray[np.float64]
    quiet: NDArray[np.bool_]
    shows: NDArray[np.bool_]
    early: NDArray[np.bool_]
    due: NDArray[np.bool_]
    begins: tuple[int, ...]

    def levels(self, line: NDArray[np.float64]) -> tuple[float, float]:
        """Highest score that :data:`LOOKS` looks agree on before the first contact, and in time."""
        score = scores(self.features, line)
        agreed = np.full(len(score), -np.inf)
        for a, b in zip(self.begins[:-1], self.begins[1:], strict=True):
            if b - a >= LOOKS:
                agreed[a + LOOKS - 1 : b] = sliding_window_view(score[a:b], LOOKS).min(axis=1)
        return (
            float(agreed[self.early].max(initial=-np.inf)),
            float(agreed[self.due].max(initial=-np.inf)),
        )


def add_clicks(
    x: NDArray[np.float64], weights: NDArray[np.float64], stop: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """A channel with clicks that the rig did not make, but might.

    Short bursts, heard through the ringing that the rig's own noise tells of: gears that
    hardly clicked while it was recorded need not be so kind on another day.

    Parameters
    ----------
    x
        One channel, in sigmas of its steady state, shape (samples,).
    weights
        Of :func:`firstcontact.contact._loudness.prediction`.
    stop
        Clicks begin before this sample.
    rng
        Where they are drawn from.
    """
    burst = np.zeros(len(x))
    for start in rng.integers(0, max(1, stop), rng.poisson(CLICKS * stop / len(x))):
        length = int(rng.integers(1, CLICK_LENGTH + 1))
        peak = CLICK * math.exp(0.5 * rng.standard_normal()) * rng.choice((-1.0, 1.0))
        shape = peak * np.sin(np.pi * (np.arange(length) + 0.5) / length)
        burst[start : start + length] += shape[: len(x) - start]
    if not weights[0] > 0.0:
        return x
    rung: NDArray[np.float64] = lfilter([1.0], weights * DAMPED ** np.arange(ORDER + 1), burst)
    return x + rung


def looks_of(pinch: Pinch, sizes: WindowSizes, early: float, rng: np.random.Generator) -> Looks:
    """Look at a pinch whose first contact is known, from where its closing starts.

    Parameters
    ----------
    pinch
        With samples before the first contact for a steady state.
    sizes
        Lengths at its rate.
    early
        The contacts may be up to this much earlier than their labels, s.
    rng
        Of the clicks that are put into what is quiet.
    """
    layout, rate = pinch.layout, pinch.layout.rate
    smooth = DeviceSmoothing(layout).update(pinch.vibration())
    steady = SteadyState.of(smooth[: sizes.steady])
    margin = samples_in(early, rate)
    first = pinch.truth[0].sample - pinch.first_sample
    length = sizes.window - (LOOKS - 1) * sizes.step
    parts = []
    for column, finger in enumerate(layout.vibration_fingers):
        if not steady.alive[column]:
            continue
        x = steady.normalise(smooth)[:, column]
        filtered = prediction(x[: sizes.steady])
        touched = [c.sample - pinch.first_sample for c in pinch.truth if c.finger is finger][:1]
        contact = (touched or [first])[0]
        oldest = samples_in(OLDEST, rate) if touched else -margin
        stop = min(len(x), contact + oldest)
        x = add_clicks(x, filtered, contact - samples_in(0.02, rate), rng)
        ends = np.arange(sizes.steady + sizes.step, stop + 1, sizes.step)
        windows = np.ascontiguousarray(sliding_window_view(x, length)[ends - length])
        weights = np.broadcast_to(filtered, (len(ends), ORDER + 1))
        age = ends - contact
        is_first = touched == [first]
        parts.append(
            (
                loudness_features(windows, weights, rate),
                age <= -margin,
                (age >= samples_in(YOUNGEST, rate)) & bool(touched),
                ends <= first - margin,
                (age > 0) & (age <= samples_in(DUE, rate)) & is_first,
            )
        )
    nothing = (np.zeros((0, 2 * EACH)), *(np.zeros(0, np.bool_) for _ in range(4)))
    joined = [np.concatenate(kind) for kind in zip(nothing, *parts, strict=True)]
    begins = np.cumsum([0, *(len(part[0]) for part in parts)]).tolist()
    features, quiet, shows, early_looks, due = joined
    return Looks(features, quiet, shows, early_looks, due, tuple(begins))


def scores(features: NDArray[np.float64], line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Positive where a contact is likelier than not, (looks, features) to (looks,)."""
    # Not a product of matrices: that gives other last digits for other numbers of rows.
    out: NDArray[np.float64] = (features * line[:-1]).sum(axis=1) + line[-1]
    return out


def fit_line(looks: Sequence[Looks], seed: int) -> NDArray[np.float64]:
    """Logistic regression, its classes balanced: a weight of each feature, and the intercept."""
    from sklearn.linear_model import LogisticRegression

    rng = np.random.default_rng(seed)
    quiet = np.concatenate([look.features[look.quiet] for look in looks])
    loud = np.concatenate([look.features[look.shows] for look in looks])
    quiet, loud = (x[rng.permutation(len(x))[:MOST]] for x in (quiet, loud))
    x = np.concatenate([quiet, loud])
    mean, scale = x.mean(axis=0), x.std(axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    machine = LogisticRegression(class_weight="balanced", max_iter=1000)
    machine.fit((x - mean) / scale, np.arange(len(x)) >= len(quiet))
    weights = machine.coef_[0] / scale
    return np.append(weights, machine.intercept_[0] - weights @ mean)


def best_threshold(levels: NDArray[np.float64]) -> float:
    """Where false alarms and late decisions, counted softly, are fewest.

    Each pinch counts by how far it is on the wrong side, as a logistic function of its
    score's own unit: so a threshold that has room on both sides lies in the middle of it, and
    not at the edge of the one click that was heard.

    Parameters
    ----------
    levels
        Of :meth:`Looks.levels`, shape (pinches, 2).
    """
    quiet, loud = levels[np.isfinite(levels).all(axis=1)].T
    candidates = np.linspace(quiet.min(), max(loud.max(), quiet.max()), 1001)

    def wrong(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(0.5 * (1.0 + np.tanh(x / 2.0)).sum(axis=0))

    cost = wrong(quiet[:, None] - candidates) + wrong(candidates - loud[:, None])
    return float(candidates[np.argmin(cost)])
