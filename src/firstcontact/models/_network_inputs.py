"""Inputs of the network for one contact, besides the rig's context."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._contact_features import LEAST, NAMES, Shape
from firstcontact.models._motor_pitch import BELIEVED, spectra
from firstcontact.models._rig import STAGES, Rig
from firstcontact.models._spec import Values
from firstcontact.models._touches import Touches

#: Radius of a fingertip, m. The curvature of an object is relative to it.
TIP = 0.010
#: Number of inputs for closing speed and radius.
BESIDE = 5
#: Number of inputs of the network: waveform divided by the rig's level, waveform divided by its own
#: peak, mask of the samples so far, features, closing speed and radius.
INPUTS = 3 * STAGES[-1] + len(NAMES) + BESIDE


def beside(touches: Touches, rig: Rig, *, one: bool = False) -> NDArray[np.float64]:
    """Return the network's inputs for closing speed and radius, shape (n, BESIDE).

    They do not change with the time after the contact. ``one`` is True for a single contact that is
    followed live.
    """
    speed, alike = np.zeros(len(touches)), np.zeros(len(touches))
    if rig.pitch is not None and one:
        speed, alike = rig.pitch.listen_to_one(touches.signals, touches.lead, touches.rate)
    elif rig.pitch is not None:
        speed, alike = rig.pitch.listen(spectra(touches.signals, touches.lead, touches.rate))
    is_told = np.isfinite(touches.speeds)
    if rig.speeds is not None and is_told.any():
        posterior = rig.speeds.posterior(
            touches.speeds, touches.speed_errors, speed, alike > BELIEVED
        )
        speed, alike = np.where(is_told, posterior, speed), np.where(is_told, 1.0, alike)
    return facts(speed, alike, touches.radii)


def facts(speed: Values, alike: Values, radii: Values) -> NDArray[np.float64]:
    """Return the network's inputs for these speeds and radii, shape (n, BESIDE).

    Parameters
    ----------
    speed
        ln(closing speed / usual speed of the rig), shape (n,).
    alike
        Confidence in the speed, from 0 to 1, shape (n,).
    radii
        As in :class:`firstcontact.models._touches.Touches`.
    """
    believed = alike > BELIEVED
    has_radius = ~np.isnan(radii)
    with np.errstate(divide="ignore"):
        curvature = np.log1p(TIP / np.where(has_radius, radii, np.inf))
    return np.stack(
        [
            np.where(believed, np.clip(speed, -1.0, 1.0), 0.0) * 4,
            believed,
            alike,
            has_radius,
            np.where(has_radius, curvature, 0.0),
        ],
        axis=1,
    )


def relative_inputs(
    waves: NDArray[np.floating],
    valid: NDArray[np.intp],
    level: Values,
    sign: Values,
    rig_features: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the network's inputs for each contact, from its valid samples only.

    Parameters
    ----------
    waves, valid
        As in :class:`firstcontact.models._touches.Touches`.
    level, sign
        Level (V) and sign of each contact's rig, shape (n,).
    rig_features
        Result of :func:`beside`.

    Returns
    -------
    ndarray
        Inputs, shape (n, INPUTS).
    """
    return network_inputs(Shape.measure(waves, valid, level, sign), rig_features)


def rig_inputs(
    touches: Touches, rig: Rig, rig_features: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the network's inputs for contacts of one rig, shape (n, INPUTS).

    ``rig_features`` is the result of :func:`beside`.
    """
    level, sign = np.full(len(touches), rig.level), np.full(len(touches), rig.sign)
    return relative_inputs(touches.waves, touches.valid, level, sign, rig_features)


def network_inputs(shape: Shape, rig_features: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the network's inputs for contacts whose :class:`Shape` is already computed."""
    v = shape.v
    peak = np.maximum(v.max(axis=1), LEAST * shape.level)[:, None]
    # A hard object on a soft rig gives many times the level. The logarithm keeps it in bounds.
    scaled = np.copysign(np.log1p(np.abs(v) * (2 / shape.level[:, None])), v) / 2
    waves = [_resampled(w) for w in (scaled, v / peak, shape.is_valid)]
    return np.concatenate([*waves, shape.features, rig_features], axis=1)


def _resampled(wave: NDArray[np.generic]) -> NDArray[np.generic]:
    """Resample a signal to the times that the network expects: the samples of the fingertip."""
    if wave.shape[1] == STAGES[-1]:
        return wave
    places = np.linspace(0, wave.shape[1] - 1, STAGES[-1])
    return wave[:, places.round().astype(np.intp)]
