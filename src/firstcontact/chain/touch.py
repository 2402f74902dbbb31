"""Functions of the C chain for contacts that are cut from recordings, and for training."""

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
    """Numbers of ``fc_touch.h`` and ``fc_gate.h`` that Python reads, too."""

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
    """Return the numbers of the compiled chain."""
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

    ``contacts`` are :attr:`Touches.arrays`.
    """
    out = np.full((len(contacts[0]), 6), np.nan)
    chain_extension().predict(image.handle, *_contacts(*contacts), is_regression, out)
    return out


def rig_inputs(image: Image, *contacts: Array) -> NDArray[np.float32]:
    """Return the inputs of the network for contacts of the rigs in the image, (n, INPUTS)."""
    out = np.empty((len(contacts[0]), INPUTS), np.float32)
    chain_extension().rig_inputs(image.handle, *_contacts(*contacts), out)
    return out


def predict_inputs(image: Image, inputs: Array, terms: Array) -> NDArray[np.float64]:
    """Return mean and standard deviation of the network's prediction for inputs, shape (n, 2)."""
    out = np.empty((len(inputs), 2))
    chain_extension().network(image.handle, _singles(inputs), _singles(terms), out)
    return out


def predict_window(
    image: Image, signal: NDArray[np.float64], lead: int
) -> tuple[float, float, float] | None:
    """Return value, lower and upper bound that the image's SVM predicts for one contact.

    ``signal`` has ``lead`` samples before the contact. Return None if it cannot be used.
    """
    made: tuple[float, float, float] | None
    made = chain_extension().svm(image.handle, _doubles(signal), lead)
    return made


def svm_outputs(image: Image, windows: Array, outputs: int) -> NDArray[np.float32]:
    """Return an SVM's prediction for each window, or its votes for each class, (n, outputs).

    The windows must vary. NaN stands for numbers that are not finite.
    """
    out = np.empty((len(windows), outputs), np.float32)
    chain_extension().svm_outputs(image.handle, _singles(windows), out)
    return out


def touch_inputs(
    signals: Array, valid: Array, before: int, level: Array, sign: Array, hints: Array
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return the network's inputs for contacts, and the features that tell if they are unusual."""
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
    """Return the spectra of the signals before contacts, shape (n, 400)."""
    out = np.empty((len(signals), LINES), np.float32)
    chain_extension().spectra(_singles(signals), len(fade), sine, fade, part, cell, out)
    return out


def shifts(
    heard: NDArray[np.float32], reference: NDArray[np.float32]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return the shift of each spectrum against a reference, in points, and the correlation."""
    n = len(heard)
    shift, correlation = np.empty(n, np.int32), np.empty(n, np.float32)
    chain_extension().shifts(_singles(heard), _singles(reference), shift, correlation)
    return shift, correlation


#: Order of the linear prediction of a motor's noise, and number of features of a look.
ORDER, FEATURES = 12, 16


def fit_predictions(quiet: Array) -> NDArray[np.float64]:
    """Return filters that predict a motor's noise, so that it can be subtracted."""
    rows = _doubles(quiet)
    out = np.empty((len(rows), ORDER + 1))
    chain_extension().fit_predictions(rows, rows.shape[1], out)
    return out


def look_features(
    looks: Array, weights: Array, lengths: Sequence[int], floor: float
) -> NDArray[np.float64]:
    """Return the loudness of windows in several spans, before and after noise is predicted away.

    ``weights`` are the filters that predict the noise.
    """
    rows = _doubles(looks)
    out = np.empty((len(rows), FEATURES))
    chain_extension().look_features(
        rows, rows.shape[1], _doubles(weights), _integers(lengths), floor, out
    )
    return out
