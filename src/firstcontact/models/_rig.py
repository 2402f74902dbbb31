"""Summary of a rig from its pinches of known Shore A: the context of the network."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import HINTS, TRAITS, touch_inputs
from firstcontact.core import InputError
from firstcontact.models._motor_pitch import BELIEVED, MotorPitch, spectra
from firstcontact.models._rig_speeds import RigSpeeds
from firstcontact.models._spec import Values
from firstcontact.models._touches import Touches

#: Stages at which a rig is described, in samples after the contact. A prediction between two stages
#: uses the longer one.
STAGES = (10, 12, 15, 18, 22, 26, 32, 40, 50, 61, 74)
#: Largest number of Shore A levels in a context. More levels are merged.
LEVELS = 8
#: Number of features of a contact: its traits without the noise before it and the share of repeated
#: samples.
FEATURES = TRAITS - 2
#: Number of points of a level's median waveform.
WAVE = 25
#: Length of a token, which describes the pinches of one level of Shore A at one stage: Shore A,
#: number of pinches, medians and interquartile ranges of features, median waveform.
TOKEN = 2 + 2 * FEATURES + WAVE
#: Number of features of the rig as a whole.
GENERAL = 6
#: Level (typical peak of a contact) of an unknown rig, V.
USUAL_LEVEL = 0.35
#: Largest interquartile range of a feature in a token. Larger ranges are clipped.
_WIDEST = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """Summary of a rig, or of one of its fingers, from its pinches of known Shore A.

    Parameters
    ----------
    level
        Typical peak of a contact, V: the geometric mean over the median peaks at each level of
        Shore A.
    sign
        Sign of the largest swing in the first 15 ms, 1 or -1. It shows the polarity of the disc.
    pitch
        Spectrum of the rig's motor; None if unknown or not used.
    speeds
        Closing speeds of the rig, as its hand measured them; None if unknown.
    tokens
        Tokens: features of each level of Shore A at each stage, shape (stages, levels, TOKEN).
    general
        Features of the rig as a whole, such as noise and number of pinches, shape (GENERAL,).
    """

    level: float
    sign: float
    pitch: MotorPitch | None
    speeds: RigSpeeds | None
    tokens: NDArray[np.float64]
    general: NDArray[np.float64]

    @classmethod
    def unknown(cls) -> Rig:
        """Return the summary of an unknown rig, without pinches."""
        tokens = np.zeros((len(STAGES), 0, TOKEN))
        return cls(USUAL_LEVEL, 1.0, None, None, tokens, np.zeros(GENERAL))

    @classmethod
    def fit(cls, touches: Touches, shore_a: Values) -> Rig:
        """Return the summary of a rig from its contacts.

        ``shore_a`` holds the Shore A of the object of each contact, shape (n,).

        Raises
        ------
        InputError
            There is no contact.
        """
        if not len(touches):
            raise InputError(
                "no pinch has a known Shore A, so the model cannot be adapted to the rig: record "
                "pinches of objects of known Shore A"
            )
        signals = touches.waves.astype(np.float64)
        heard = spectra(touches.signals, touches.rate)
        pitch = MotorPitch.fit(heard)
        speed, alike = pitch.listen(heard)
        longest = np.where(np.arange(signals.shape[1]) < touches.valid[:, None], signals, 0.0)
        extreme = np.where(-longest.min(axis=1) > longest.max(axis=1), -1.0, 1.0)
        sign = 1.0 if np.median(extreme) >= 0 else -1.0
        peaks = np.log(np.maximum((sign * longest).max(axis=1), 1e-5))
        loudness_level = level_groups(shore_a)
        groups = [np.flatnonzero(loudness_level == g) for g in np.unique(loudness_level)]
        level = float(np.exp(np.mean([np.median(peaks[g]) for g in groups])))
        believed = alike > BELIEVED
        speeds = RigSpeeds.fit(touches.speeds, touches.speed_errors, speed, believed)
        noise = touches.signals[:, : touches.lead // 2].std(axis=1).mean()
        general = np.array(
            [
                np.log(max(float(noise), 1e-6) / level) + 4,
                np.median(alike),
                np.std(speed[believed]) if believed.sum() > 3 else 0.2,
                np.log(len(touches)) - 4,
                len(groups) / 4 - 1,
                float(speeds is not None),
            ]
        )
        tokens = np.stack([_tokens(touches, sign, level, s, shore_a, groups) for s in STAGES])
        return cls(level, sign, pitch, speeds, tokens, general)


def stage_index(valid: NDArray[np.intp] | int) -> NDArray[np.intp]:
    """Return the position in ``STAGES`` for a number of valid samples."""
    return np.minimum(np.searchsorted(STAGES, valid), len(STAGES) - 1).astype(np.intp)


def level_groups(shore_a: Values) -> NDArray[np.intp]:
    """Return the group of each pinch: its level of Shore A, or neighbouring levels."""
    values, group = np.unique(shore_a, return_inverse=True)
    if len(values) <= LEVELS:
        return group.astype(np.intp)
    return (np.arange(len(values)) * LEVELS // len(values))[group].astype(np.intp)


def _tokens(
    touches: Touches,
    sign: float,
    level: float,
    stage: int,
    shore_a: Values,
    groups: list[NDArray[np.intp]],
) -> NDArray[np.float64]:
    """Return the tokens of each level at a stage, shape (levels, TOKEN)."""
    n = len(touches)
    valid = np.minimum(touches.valid, stage)
    scales = np.full(n, level), np.full(n, sign)
    _, traits = touch_inputs(touches.signals, valid, touches.lead, *scales, np.zeros((n, HINTS)))
    features = traits[:, :FEATURES]
    places = np.linspace(0, touches.waves.shape[1] - 1, WAVE).round().astype(np.intp)
    waves = np.where(places < touches.valid[:, None], sign * touches.waves[:, places], np.nan)
    out = np.empty((len(groups), TOKEN))
    for row, group in enumerate(groups):
        ordered = np.sort(features[group], axis=0)
        low, middle, high = (ordered[round(q * (len(group) - 1))] for q in (0.25, 0.5, 0.75))
        out[row] = np.concatenate(
            [
                [shore_a[group].mean() / 40 - 1, np.log(len(group)) / 2 - 1],
                middle,
                np.minimum(high - low, _WIDEST),
                _median(waves[group]) / level,
            ]
        )
    return out


def _median(waves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median of the values that are not NaN at each point; 0 if all are NaN."""
    is_finite = np.isfinite(waves)
    filled = np.where(is_finite, waves, np.inf)
    filled.sort(axis=0)
    count = is_finite.sum(axis=0)
    columns = np.arange(waves.shape[1])
    middle = filled[np.maximum(count - 1, 0) // 2, columns]
    return np.where(count > 0, middle, 0.0)
