"""Functions of the C chain for contacts that were cut from recordings, and for training."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.image import LINES, Image, chain_extension

Array = NDArray[Any]
#: Number of the network's inputs, of a contact's traits, and of the hints among the inputs.
INPUTS, TRAITS, HINTS = 241, 16, 5


class TouchConstants(NamedTuple):
    """Constants of ``fc_touch.h`` and ``fc_gate.h`` that Python code needs, too."""

    believed: float
    tip: float
    largest: float
    length: float
    linear: float
    noise: float
    #: The motor runs if the RMS of a step exceeds the noise at rest by this factor.
    running: float


@cache
def touch_constants() -> TouchConstants:
    """Return the constants that were compiled into the chain."""
    return TouchConstants(**chain_extension().constants())


def _doubles(values: Any) -> NDArray[np.float64]:
    return np.ascontiguousarray(values, np.float64)


def _singles(values: Any) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, np.float32)


def _integers(values: Any) -> NDArray[np.int32]:
    return np.ascontiguousarray(values, np.int32)


def _contacts(
    signals: Array, valid: Array, fingers: Array, speeds: Array, errors: Array, radii: Array
) -> tuple[Array, ...]:
    speeds, errors = np.nan_to_num(_doubles(speeds)), np.nan_to_num(_doubles(errors), posinf=1e9)
    return _singles(signals), _integers(valid), _integers(fingers), speeds, errors, _doubles(radii)


def predict_touches(
    image: Image, *contacts: Array, is_regression: bool = False
) -> NDArray[np.float64]:
    """Return value, low, high, half width, spread and out-of-range mark per contact, (n, 6).

    ``contacts`` are :attr:`Touches.arrays`. With ``is_regression``, the rig's regression predicts
    alone.
    """
    out = np.full((len(contacts[0]), 6), np.nan)
    chain_extension().predict(image.handle, *_contacts(*contacts), is_regression, out)
    return out


def rig_inputs(image: Image, *contacts: Array) -> NDArray[np.float32]:
    """Return the network's inputs for contacts of the rigs in the image, shape (n, INPUTS).

    ``contacts`` are :attr:`Touches.arrays`.
    """
    out = np.empty((len(contacts[0]), INPUTS), np.float32)
    chain_extension().rig_inputs(image.handle, *_contacts(*contacts), out)
    return out


def predict_inputs(image: Image, inputs: Array, terms: Array) -> NDArray[np.float64]:
    """Return mean and standard deviation of the network's predictions, Shore A, shape (n, 2).

    ``inputs`` has the shape (n, INPUTS). ``terms`` are the vectors by which rigs shift the network.
    """
    out = np.empty((len(inputs), 2))
    chain_extension().network(image.handle, _singles(inputs), _singles(terms), out)
    return out


def predict_window(
    image: Image, signal: NDArray[np.float64], lead: int
) -> tuple[float, float, float] | None:
    """Return the prediction of the image's SVM for one contact, with lower and upper bound.

    ``signal`` (V) has ``lead`` samples before the contact. Return None if the signal is unusable.
    """
    made: tuple[float, float, float] | None
    made = chain_extension().svm(image.handle, _doubles(signal), lead)
    return made


def svm_outputs(image: Image, windows: Array, outputs: int) -> NDArray[np.float32]:
    """Return the predictions of the image's SVM, or its votes for each class, (n, outputs).

    The ``windows`` must vary. An output that is not finite becomes NaN.
    """
    out = np.empty((len(windows), outputs), np.float32)
    chain_extension().svm_outputs(image.handle, _singles(windows), out)
    return out


def touch_inputs(
    signals: Array, valid: Array, before: int, level: Array, sign: Array, hints: Array
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return the network's inputs for contacts, and features that show if a contact is unusual.

    The shapes are (n, INPUTS) and (n, TRAITS).
    """
    n = len(signals)
    inputs, traits = np.empty((n, INPUTS), np.float32), np.empty((n, TRAITS))
    chain_extension().inputs(
        _singles(signals),
        _integers(valid),
        before,
        _doubles(level),
        _doubles(sign),
        _doubles(hints),
        inputs,
        traits,
    )
    return inputs, traits


def spectra(
    signals: Array, sine: Array, fade: Array, part: Array, cell: Array
) -> NDArray[np.float32]:
    """Return the spectrum of the signal before each contact, shape (n, LINES).

    ``sine``, ``fade``, ``part`` and ``cell`` are constants from :func:`spectrum_constants`.
    """
    out = np.empty((len(signals), LINES), np.float32)
    chain_extension().spectra(_singles(signals), len(fade), sine, fade, part, cell, out)
    return out


def shifts(
    heard: NDArray[np.float32], reference: NDArray[np.float32]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return how far each spectrum is shifted against a reference, and the correlation then.

    Shifts are in points of the spectrum. Both arrays have the shape (n,).
    """
    n = len(heard)
    shift, correlation = np.empty(n, np.int32), np.empty(n, np.float32)
    chain_extension().shifts(_singles(heard), _singles(reference), shift, correlation)
    return shift, correlation


#: Order of the linear prediction of a motor's noise, and number of features of a look.
ORDER, FEATURES = 12, 16


def fit_predictions(quiet: Array) -> NDArray[np.float64]:
    """Return filters that predict a motor's noise from earlier samples, shape (n, ORDER + 1).

    ``quiet`` holds n signals without contact. The filters are used to subtract the noise.
    """
    rows = _doubles(quiet)
    out = np.empty((len(rows), ORDER + 1))
    chain_extension().fit_predictions(rows, rows.shape[1], out)
    return out


def look_features(
    looks: Array, weights: Array, lengths: Sequence[int], floor: float
) -> NDArray[np.float64]:
    """Return the features of looks (windows), shape (n, FEATURES).

    They are the loudness in several spans, before and after the noise that ``weights`` predict is
    subtracted. ``lengths`` are the spans' lengths, samples.
    """
    rows = _doubles(looks)
    out = np.empty((len(rows), FEATURES))
    chain_extension().look_features(
        rows, rows.shape[1], _doubles(weights), _integers(lengths), floor, out
    )
    return out
