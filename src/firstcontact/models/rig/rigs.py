"""Summary of a rig and a regression, both computed from the rig's pinches of known Shore A."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Self, TypedDict

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import touch
from firstcontact.chain.constants import ProcessConstants
from firstcontact.chain.image import LINES, TURN
from firstcontact.chain.touch import HINTS, INPUTS, TRAITS, touch_constants, touch_inputs
from firstcontact.core import ArgumentError, ModelError
from firstcontact.core.weights import take_array
from firstcontact.models.touches import Signals, Touches
from firstcontact.models.values import Arrays, Values
from firstcontact.signal import samples_in
from firstcontact.signal.windowing import BASELINE_GUARD

#: Frequency range of the motor's spectrum, Hz.
LOWEST, HIGHEST = 100.0, 2300.0
#: Distance between two points in ln(frequency).
STEP = float(np.log(HIGHEST / LOWEST)) / (LINES - 1)
#: One count of the converter, V.
COUNT = 3.2e-3
_ROUNDS = 4

Spectra = NDArray[np.float32]


class SpectrumConstants(TypedDict):
    """Constant arrays for the spectrum of the motor's noise; ``fc_pitch.h`` describes each one."""

    sine: NDArray[np.float32]
    fade: NDArray[np.float32]
    part: NDArray[np.float32]
    cell: NDArray[np.int32]


@lru_cache(maxsize=8)
def spectrum_constants(rate: float) -> SpectrumConstants:
    """Return the constant arrays for the motor's spectrum at the sampling ``rate``, Hz."""
    quiet = samples_in(Touches.BEFORE, rate) - samples_in(BASELINE_GUARD, rate)
    place = np.geomspace(LOWEST, HIGHEST, LINES) * (TURN / rate)
    cell = np.minimum(place.astype(np.int32), TURN // 2 - 1).astype(np.int32)
    return {
        "sine": np.sin(2 * np.pi * np.arange(TURN // 4 + 1) / TURN).astype(np.float32),
        "fade": (np.hanning(quiet) / COUNT).astype(np.float32),
        "part": np.clip(place - cell, 0.0, 1.0).astype(np.float32),
        "cell": cell,
    }


def spectra(signals: Signals, rate: float) -> Spectra:
    """Return the spectrum of the motor's noise before each contact, shape (n, LINES).

    Frequencies are spaced evenly in ln(frequency). ``signals`` are in V, ``rate`` is in Hz.
    """
    constants = spectrum_constants(rate)
    return touch.spectra(signals[:, : len(constants["fade"])], **constants)


@dataclass(frozen=True, slots=True, eq=False)
class MotorPitch:
    """Spectrum of a motor's noise, by which the closing speed of a contact is estimated.

    The spectrum shifts along frequency with the speed. ``reference`` is the mean spectrum, aligned
    over contacts. ``usual`` is its median shift in ln(frequency), which stands for the usual speed.
    """

    reference: Spectra
    usual: float

    @classmethod
    def fit(cls, heard: Spectra) -> MotorPitch:
        """Return the pitch of a motor from the spectra before several contacts.

        ``heard`` holds the spectra, shape (n, LINES).
        """
        reference = heard[np.argmax(heard.std(axis=1))]
        for _ in range(_ROUNDS):
            shift, alike = touch.shifts(heard, reference)
            weight = np.maximum(alike, 0.0) ** 2
            moved = [
                w * np.roll(spectrum, -s)
                for w, s, spectrum in zip(weight, shift.tolist(), heard, strict=True)
            ]
            total = np.sum(moved, axis=0, dtype=np.float64) / max(float(weight.sum()), 1e-9)
            reference = total.astype(np.float32)
        shift, _ = touch.shifts(heard, reference)
        return cls(reference, float(np.median(shift)) * STEP)

    def listen(self, heard: Spectra) -> tuple[Values, Values]:
        """Estimate the closing speed at contacts from the spectra before them.

        ``heard`` holds the spectra, shape (n, LINES). Return ln(speed / usual speed), and the
        confidence in it from 0 to 1, shape (n,) each.
        """
        shift, alike = touch.shifts(heard, self.reference)
        speed = shift.astype(np.float64) * STEP - self.usual
        return speed, np.clip(alike, 0.0, 1.0).astype(np.float64)


#: Number of features of a contact: its traits without the noise before it and the share of repeated
#: samples.
FEATURES = TRAITS - 2
#: Number of points of a level's median waveform.
WAVE = 25
#: Largest interquartile range of a feature in a token. Larger ranges are clipped.
_WIDEST = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """Summary of a rig (a hand with its sensors) or one finger, which the network gets as input.

    Parameters
    ----------
    level
        Typical peak of a contact, V: the geometric mean of the median peaks of each Shore A value.
    sign
        Sign of the largest swing in the first 15 ms, 1 or -1. It shows the polarity of the disc.
    pitch
        Spectrum of the noise of the rig's motor; None if unknown or not used.
    speeds
        Closing speeds of the rig, as its hand measured them; None if unknown.
    tokens
        Features of each Shore A value for each signal length in ``STAGES``, shape (stages, values,
        TOKEN).
    general
        Features of the rig as a whole, such as noise and number of pinches, shape (GENERAL,).
    """

    #: Finger number of the rig that holds for any finger.
    ANY: ClassVar[int] = -1
    #: Signal lengths for which a rig is described, in samples after the contact ("stages"). A
    #: prediction from a length between two of them uses the longer one.
    STAGES: ClassVar[tuple[int, ...]] = (10, 12, 15, 18, 22, 26, 32, 40, 50, 61, 74)
    #: Largest number of Shore A values in a summary. More values are merged with neighbours.
    LEVELS: ClassVar[int] = 8
    #: Length of a token, which describes the pinches of one Shore A value at one stage: Shore A,
    #: number of pinches, medians and interquartile ranges of features, median waveform.
    TOKEN: ClassVar[int] = 2 + 2 * FEATURES + WAVE
    #: Number of features of the rig as a whole.
    GENERAL: ClassVar[int] = 6
    #: ``level`` (typical peak of a contact) that is assumed for an unknown rig, V.
    USUAL_LEVEL: ClassVar[float] = 0.35

    level: float
    sign: float
    pitch: MotorPitch | None
    speeds: RigSpeeds | None
    tokens: NDArray[np.float64]
    general: NDArray[np.float64]

    @staticmethod
    def stage_index(valid: NDArray[np.intp] | int) -> NDArray[np.intp]:
        """Return the index of the shortest signal length in ``STAGES`` that is at least ``valid``.

        ``valid`` is a number of samples after the contact. For longer signals the last index is
        returned.
        """
        stages = Rig.STAGES
        return np.minimum(np.searchsorted(stages, valid), len(stages) - 1).astype(np.intp)

    @classmethod
    def stages_at_scored_times(cls, rate: float) -> list[int]:
        """Return the signal length in ``STAGES`` that each time in ``Touches.SCORED_MS`` uses.

        Lengths are in samples, ``rate`` is in Hz.
        """
        samples = [samples_in(1e-3 * ms, rate) for ms in Touches.SCORED_MS]
        return [cls.STAGES[int(cls.stage_index(n))] for n in samples]

    @classmethod
    def unknown(cls) -> Rig:
        """Return the summary of an unknown rig, for predictions without any labelled pinch."""
        tokens = np.zeros((len(Rig.STAGES), 0, Rig.TOKEN))
        return cls(Rig.USUAL_LEVEL, 1.0, None, None, tokens, np.zeros(Rig.GENERAL))

    @classmethod
    def fit(cls, touches: Touches, shore_a: Values) -> Rig:
        """Return the summary of a rig, computed from contacts with objects of known Shore A.

        ``shore_a`` holds the Shore A of each contact's object, shape (n,). Raise ArgumentError if
        there is no contact.
        """
        if not len(touches):
            raise ArgumentError(
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
        believed = alike > touch_constants().believed
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
        tokens = np.stack([_tokens(touches, sign, level, s, shore_a, groups) for s in Rig.STAGES])
        return cls(level, sign, pitch, speeds, tokens, general)


def level_groups(shore_a: Values) -> NDArray[np.intp]:
    """Return a group number for each pinch, shape (n,). Pinches of one Shore A share a group.

    With more than ``Rig.LEVELS`` values of Shore A, neighbouring values share a group, too.
    """
    values, group = np.unique(shore_a, return_inverse=True)
    if len(values) <= Rig.LEVELS:
        return group.astype(np.intp)
    return (np.arange(len(values)) * Rig.LEVELS // len(values))[group].astype(np.intp)


def _tokens(
    touches: Touches,
    sign: float,
    level: float,
    stage: int,
    shore_a: Values,
    groups: list[NDArray[np.intp]],
) -> NDArray[np.float64]:
    """Return the rig's features for each Shore A, shape (groups, Rig.TOKEN).

    Each array in ``groups`` holds the indices of contacts with the same Shore A. The features use
    the first ``stage`` samples after a contact. ``sign`` and ``level`` are the polarity and the
    signal level of the rig.
    """
    n = len(touches)
    valid = np.minimum(touches.valid, stage)
    scales = np.full(n, level), np.full(n, sign)
    _, traits = touch_inputs(touches.signals, valid, touches.lead, *scales, np.zeros((n, HINTS)))
    features = traits[:, :FEATURES]
    places = np.linspace(0, touches.waves.shape[1] - 1, WAVE).round().astype(np.intp)
    waves = np.where(places < touches.valid[:, None], sign * touches.waves[:, places], np.nan)
    out = np.empty((len(groups), Rig.TOKEN))
    for row, group in enumerate(groups):
        ordered = np.sort(features[group], axis=0)
        low, middle, high = (ordered[round(q * (len(group) - 1))] for q in (0.25, 0.5, 0.75))
        out[row] = np.concatenate(
            [
                [shore_a[group].mean() / 40 - 1, np.log(len(group)) / 2 - 1],
                middle,
                np.minimum(high - low, _WIDEST),
                _median_wave(waves[group]) / level,
            ]
        )
    return out


def _median_wave(waves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median of waveforms, shape (waveforms, samples), at each sample.

    NaN is ignored. Where all are NaN, the median is 0.
    """
    is_finite = np.isfinite(waves)
    filled = np.where(is_finite, waves, np.inf)
    filled.sort(axis=0)
    count = is_finite.sum(axis=0)
    columns = np.arange(waves.shape[1])
    middle = filled[np.maximum(count - 1, 0) // 2, columns]
    return np.where(count > 0, middle, 0.0)


#: Smallest and largest value of a spread or an error of ln(speed). No rig and no measurement is
#: more exact than LEAST_SPREAD, and no speeds differ by more than MOST_SPREAD.
LEAST_SPREAD, MOST_SPREAD = 0.01, 10.0
#: Largest variance of the errors of measurements that are used, as a share of the variance of the
#: rig's speeds.
MOST_NOISE = 4.0
#: Spread of ln(speed) that is assumed for a rig with fewer than FEWEST pinches, and for old files.
ASSUMED, FEWEST = 0.2, 4
#: Relative error above which a measurement is ignored for the rig.
USELESS = 0.5
#: Distance from the quartiles, in interquartile ranges, above which a value counts as an outlier:
#: 3.4 standard deviations of a normal variable.
FENCE = 2.0


@dataclass(frozen=True, slots=True)
class RigSpeeds:
    """Closing speeds of a rig.

    ``usual`` is the median speed, m/s. ``spread`` is the standard deviation of ln(speed).
    ``heard_error`` is the standard error of ln(speed) from the motor's pitch, infinite if unknown.
    """

    usual: float
    spread: float = ASSUMED
    heard_error: float = np.inf

    @property
    def is_possible(self) -> bool:
        """True if spread and pitch error are within bounds. An infinite pitch error is allowed."""
        errors = [self.spread, *([self.heard_error] if np.isfinite(self.heard_error) else [])]
        return all(LEAST_SPREAD <= error <= MOST_SPREAD for error in errors)

    @classmethod
    def fit(
        cls, speeds: Values, errors: Values, heard: Values, believed: NDArray[np.bool_]
    ) -> Self | None:
        """Return the closing speeds of a rig from the speeds that its hand measured.

        ``errors`` are relative standard errors of ``speeds`` (m/s). ``heard`` is ln(speed / usual
        speed) from the motor's pitch, and ``believed`` is True where that is reliable. All have
        shape (n,). Return None if no speed is exact enough.
        """
        is_measured = np.isfinite(speeds) & (_bound_errors(errors) <= USELESS)
        if not is_measured.any():
            return None
        usual = float(np.median(speeds[is_measured]))
        log, noise = _log_ratio(speeds, usual), _bound_errors(errors) ** 2
        both = is_measured & believed
        has_spread, has_heard = is_measured.sum() >= FEWEST, both.sum() >= FEWEST
        spread = _spread(log[is_measured], noise[is_measured]) if has_spread else ASSUMED
        if np.median(noise[is_measured]) > MOST_NOISE * spread**2:
            return None
        heard_error = _spread((heard - log)[both], noise[both]) if has_heard else np.inf
        return cls(usual, spread, heard_error)


def _log_ratio(speeds: Values, usual: float) -> Values:
    out: Values = np.log(np.maximum(speeds, 1e-6) / usual)
    return out


def _bound_errors(errors: Values) -> Values:
    """Return the relative errors of closing speeds, raised to at least ``LEAST_SPREAD``.

    NaN counts as an exact speed.
    """
    return np.maximum(np.where(np.isnan(errors), 0.0, errors), LEAST_SPREAD)


def _spread(values: Values, noise: Values) -> float:
    """Return the standard deviation of ``values`` without outliers and measurement noise.

    ``noise`` holds the variance of the measurement noise of each value. The result is at least
    ``LEAST_SPREAD``.
    """
    low, high = np.quantile(values, [0.25, 0.75])
    reach = FENCE * max(high - low, LEAST_SPREAD)
    usual = values[(values >= low - reach) & (values <= high + reach)]
    return max(float(np.sqrt(max(np.var(usual, ddof=1) - np.median(noise), 0.0))), LEAST_SPREAD)


#: Positions of the regression's inputs in those of the network: the features and the closing speed.
REGRESSED = slice(INPUTS - HINTS - FEATURES, INPUTS - HINTS + 1)
WIDTH = FEATURES + 1
#: Added to the standard deviation of each input.
_LEAST_DEVIATION = 0.1
#: Largest number of pinches. With more, the regression is surer of itself but not better on objects
#: unlike the rig's blocks.
MOST_PINCHES = 32


class RigRegression:
    """Gaussian process from signal features to Shore A, fitted to the pinches of one rig.

    All rigs have the same length scale and variances (:func:`touch_constants`). Values that were
    chosen on held-out pinches of each rig scored no better on rigs whose structure differs from
    that of the network's training rigs. Inputs are clipped, because a contact without a first swing
    has inputs a thousand times as large as usual.
    """

    def __init__(
        self,
        inputs: NDArray[np.float64],
        shore_a: Values,
        scale: NDArray[np.float64],
        offset: NDArray[np.float64],
    ) -> None:
        n = len(shore_a)
        if not 2 <= n <= MOST_PINCHES or not (scale > 0).all():
            raise ModelError(
                f"the model's regression must have 2 to {MOST_PINCHES} pinches, and a scale above "
                "0 for each input: adapt the model again"
            )
        largest = touch_constants().largest
        inputs = np.clip(inputs, -largest, largest)
        self._inputs, self._shore_a = inputs, shore_a
        self._scale, self._offset = scale, offset

    def chain_constants(self) -> ProcessConstants:
        """Return the constants that the C chain needs to predict by this regression."""
        inputs, shore_a, fixed = self._inputs, self._shore_a, touch_constants()
        mean, sd = inputs.mean(axis=1), inputs.std(axis=1) + _LEAST_DEVIATION
        centre, unit = float(shore_a.mean()), max(float(shore_a.std()), 1.0)
        known = (inputs - mean[:, None]) / sd[:, None]
        inner = known @ known.transpose(0, 2, 1)
        squares = np.einsum("sii->si", inner)
        distances = np.maximum(squares[:, :, None] + squares[:, None] - 2.0 * inner, 0.0)
        smooth = np.exp(distances * (-1.0 / (2.0 * fixed.length * fixed.length * WIDTH)))
        covariance = (
            1.0 + inner * (fixed.linear / WIDTH) + smooth + fixed.noise * np.eye(len(shore_a))
        )
        factor = np.linalg.inv(np.linalg.cholesky(covariance))
        weights = factor.transpose(0, 2, 1) @ (factor @ ((shore_a - centre) / unit)[:, None])
        return ProcessConstants(
            centre=centre,
            unit=unit,
            mean=mean,
            sd=sd,
            known=known.transpose(0, 2, 1),
            weights=weights[..., 0],
            factor=factor,
            scale=self._scale,
            offset=self._offset,
        )

    def shifted(self, offset: NDArray[np.float64]) -> RigRegression:
        """Return a copy of the regression with another ``offset``, Shore A, (signal lengths,).

        The offset is subtracted from the average of the network and the regression.
        """
        return RigRegression(self._inputs, self._shore_a, self._scale, offset)

    def to_arrays(self) -> Arrays:
        arrays = {"inputs": self._inputs, "shore_a": self._shore_a}
        return arrays | {"scale": self._scale, "offset": self._offset}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str) -> Self:
        """Restore the regression from the arrays whose names begin with ``prefix``."""
        shore_a = take_array(arrays, prefix + "shore_a", None).astype(np.float64)
        inputs = take_array(arrays, prefix + "inputs", len(Rig.STAGES), len(shore_a), WIDTH)
        stages = len(Rig.STAGES)
        scale = take_array(arrays, prefix + "scale", stages).astype(np.float64)
        offset = np.zeros(stages)  # of older files
        if prefix + "offset" in arrays:
            offset = take_array(arrays, prefix + "offset", stages).astype(np.float64)
        return cls(inputs.astype(np.float64), shore_a, scale, offset)
