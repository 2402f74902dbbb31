"""Fast predictions for one contact while its signal arrives.

A NumPy call takes at least a microsecond, and the general code needs 200 such calls. Compiled
kernels need one call; see :mod:`firstcontact.models._compiled`. Without them this module repeats
the network's arithmetic for a single contact. It stores values that later predictions for the same
contact need again, and so takes a third of the general code's time. The results equal those of
:meth:`InContextModel.predict` bit by bit, and those of the kernels up to rounding.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._compiled import compiled_prediction
from firstcontact.models._contact_features import LEAST, NAMES
from firstcontact.models._interval import SHORE_A
from firstcontact.models._network_inputs import INPUTS
from firstcontact.models._out_of_range import TRAITS, pre_contact_noise
from firstcontact.models._rig import STAGES
from firstcontact.models._touches import lengths

if TYPE_CHECKING:
    from firstcontact.models._in_context import InContextModel
    from firstcontact.models._touches import Touches


def _stage_index(valid: int, rate: float) -> int:
    """Return :func:`firstcontact.models._rig.stage_index` for one contact."""
    share = valid * (STAGES[-1] / lengths(rate)[1])
    return min(bisect_left(STAGES, share - 1e-9), len(STAGES) - 1)


class ContactPrediction(NamedTuple):
    """Prediction for one contact; see :class:`firstcontact.models.Predictions`."""

    value: float
    low: float
    high: float
    half_width: float
    out_of_range: bool


class SingleContactPredictor:
    """Predictor for one contact; each prediction uses more samples than the previous one.

    Parameters
    ----------
    model
        Network, conditioned on a rig.
    touches
        The contact, as one row, with the samples received so far.
    features
        The contact's row of :meth:`InContextModel.rig_features`.
    """

    def __init__(
        self, model: InContextModel, touches: Touches, features: NDArray[np.float64]
    ) -> None:
        #: Inputs besides the signal, one row.
        self.features = features
        finger = model.by_rig(touches)[0][0]
        #: True if :meth:`predict` can be used: it does not resample contacts of another rate.
        self.fits = touches.waves.shape[1] == STAGES[-1]
        self._compiled = compiled_prediction(model, finger) if self.fits else None
        self._refine = partial(model.refine, finger) if model.refines else None
        self._rig, self._network = model.rigs[finger], model.network
        self._context, self._familiar = model.context(finger), model.familiar
        self._factors, self._rate = model.factors.tolist(), touches.rate
        self._has_level = self._rig.tokens.shape[1] > 0
        level = np.full(1, self._rig.level)
        noise = pre_contact_noise(touches.signals[:, : touches.lead], level)
        self._traits = np.empty(TRAITS)
        self._traits[-2] = noise[0]
        if self._compiled is not None:
            return
        size = STAGES[-1]
        self._t = np.arange(size).astype(np.float64)
        self._v = np.zeros(size)
        self._energy = np.zeros((1, size))
        self._steps = np.zeros(size - 1)
        self._x = np.zeros(INPUTS)
        self._x[-len(features[0]) :] = features[0]
        self._done = 0  # samples of the signal that are in these arrays

    @property
    def is_compiled(self) -> bool:
        """True if the compiled kernels predict."""
        return self._compiled is not None

    def predict(self, signal: NDArray[np.floating], valid: int) -> ContactPrediction | None:
        """Return the prediction from the first ``valid`` samples; None if it is not finite.

        Parameters
        ----------
        signal
            Signal from the contact on, V, shape (samples,).
        valid
            Number of samples that may be used, more than in the previous call.
        """
        stage = _stage_index(valid, self._rate)
        if self._compiled is not None:
            noise = float(self._traits[-2])
            is_ready = signal.dtype == np.float32 and signal.flags.c_contiguous
            if not is_ready or len(signal) != STAGES[-1]:
                padded = np.zeros(STAGES[-1], np.float32)
                padded[:valid] = signal[:valid]
                signal = padded
            answer = self._compiled(signal, valid, stage, self.features, noise)
            return None if answer is None else ContactPrediction(*answer)
        self._take(signal, valid)
        traits = self._features(valid)
        mixture = self._network.outputs_of_one(self._x, self._context, stage)
        weight, mean, sd = mixture
        value = float((weight * mean).sum())
        square = float((weight * (sd * sd + mean * mean)).sum())
        spread = math.sqrt(max(square - value * value, 1e-4))
        if self._refine is not None:
            value, spread = self._refine(self._x, stage, value, spread)
        half = spread * self._factors[stage]
        if not math.isfinite(value + half):
            return None
        lowest, highest = SHORE_A
        value = min(max(value, lowest), highest)
        return ContactPrediction(
            value,
            min(max(value - half, lowest), highest),
            min(max(value + half, lowest), highest),
            half,
            self._familiar.is_out_of_range(traits, stage, self._has_level),
        )

    def _take(self, signal: NDArray[np.floating], valid: int) -> None:
        """Add the samples since the last prediction."""
        taken, self._done = self._done, valid
        new = slice(taken, valid)
        v = self._v
        v[new] = self._rig.sign * signal[new]
        part = v[new]
        np.multiply(part, part, out=self._energy[0, new])
        first = max(taken, 1)
        steps = self._steps[first - 1 : valid - 1]
        np.subtract(v[first:valid], v[first - 1 : valid - 1], out=steps)
        # The first of the network's waves; the others depend on the peak so far.
        logs = np.log1p(np.abs(part) * (2 / self._rig.level))
        self._x[new] = np.copysign(logs, part) / 2
        self._x[2 * len(v) + taken : 2 * len(v) + valid] = 1.0

    def _features(self, valid: int) -> NDArray[np.float64]:
        """Update the network's inputs. Return the traits that show out-of-range contacts.

        See :func:`firstcontact.models._contact_features.features`.
        """
        v, level, size = self._v, self._rig.level, len(self._v)
        scale = size / 74.0
        at = int(v.argmax())
        floor = LEAST * level
        peak = max(float(v[at]), floor)
        rise = max(float(self._steps.max()), floor)
        relative = self._x[size : 2 * size]
        np.divide(v, peak, out=relative)
        rising = relative[: at + 1]
        fall = relative[at + 1 : valid]
        low_at = at + 1 + int(fall.argmin()) if len(fall) else at
        low = float(relative[low_at]) if len(fall) else 1.0
        total = float(self._energy[0].sum()) + LEAST * LEAST * level * level
        centre = float((self._energy @ self._t)[0]) / total
        rough = float((self._steps * self._steps).sum()) / total
        rms = math.sqrt(total / valid)
        logs = np.log((peak / level, rise / level, rough + 1e-4, rms / level)).tolist()
        last, earlier = float(relative[valid - 1]), float(relative[max(valid - 4, 0)])
        traits = self._traits
        traits[:-2] = (
            logs[0],
            logs[1],
            at / (20 * scale) - 1,
            np.count_nonzero(rising < 0.1) / (10 * scale) - 0.5,
            np.count_nonzero(rising < 0.5) / (10 * scale) - 0.5,
            np.count_nonzero(relative > 0.5) / (20 * scale) - 0.5,
            logs[2] + 2,
            low,
            low_at / (40 * scale) - 1,
            logs[3],
            centre / (20 * scale) - 1,
            valid / (37 * scale) - 1,
            last,
            last - earlier,
        )
        self._x[3 * size : 3 * size + len(NAMES)] = traits[:-2]
        flat = np.count_nonzero(self._steps[: valid - 1] == 0.0)
        traits[-1] = 10 * (flat / (valid - 1))
        return traits
