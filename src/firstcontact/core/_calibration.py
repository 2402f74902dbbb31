"""What was measured of one fingertip pair before recording with it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from firstcontact.core._layout import ADC_VOLTS, Finger
from firstcontact.core._records import Name

#: Resistor of the published divider, ohm.
DIVIDER_OHM = 4700.0


#: Sizes that a calibration of these sensors can hold.
Size = Annotated[float, Meta(ge=0.0, le=1e9)]
Positive = Annotated[float, Meta(gt=0.0, le=1e9)]


@dataclass(frozen=True, slots=True)
class VibrationCalibration:
    """One vibration sensor with nothing touching and the motor at rest.

    Parameters
    ----------
    finger
        Whose; None where it belongs to none.
    noise
        RMS around the mean, in the channel's unit (V of fingertips).
    offset
        Mean, in that unit (0 when a fingertip's buffer sits exactly at its 1.65 V).
    tap
        Peak of the response to a tap, in that unit; None where no tap was made.
    """

    finger: Finger | None
    noise: Size
    offset: Annotated[float, Meta(ge=-1e9, le=1e9)] = 0.0
    tap: Size | None = None


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """Velostat of one finger: from the divider's voltage to newtons.

    The sheet's conductance rises with the force, ``g = leak + gain F^exponent``;
    over the divider's resistor R it gives ``V = 3.3 R g / (1 + R g)``.

    Parameters
    ----------
    finger
        Whose.
    leak
        Conductance unloaded, S.
    gain
        S / N^exponent.
    exponent
        Of the force.
    rms
        Of the fit's residuals, N.
    resistor
        Of the divider, ohm.
    """

    finger: Finger
    leak: Size
    gain: Positive
    exponent: Positive
    rms: Size
    resistor: Positive = DIVIDER_OHM

    def newtons(self, volts: NDArray[Any]) -> NDArray[np.float64]:
        """Force on a taxel, N, for voltages over the divider, same shape."""
        ratio = np.clip(np.asarray(volts, dtype=np.float64) / ADC_VOLTS, 0.0, 0.999)
        conductance = ratio / (1.0 - ratio) / self.resistor
        out: NDArray[np.float64] = (np.maximum(conductance - self.leak, 0.0) / self.gain) ** (
            1.0 / self.exponent
        )
        return out


@dataclass(frozen=True, slots=True)
class Calibration:
    """Of one pair of fingertips; goes into the header of every recording.

    ``piezo`` is of the vibration sensors, of whatever kind (files know it by this name);
    ``created`` is an ISO 8601 time; fingers that were not measured are absent.

    Examples
    --------
    >>> import firstcontact as fc
    >>> from firstcontact.core import VibrationCalibration
    >>> calibration = fc.Calibration((VibrationCalibration(fc.Finger.INDEX, noise=0.002),))
    >>> calibration.noise(fc.Finger.INDEX)
    0.002
    """

    piezo: Annotated[tuple[VibrationCalibration, ...], Meta(max_length=len(Finger) + 1)] = ()
    force: Annotated[tuple[ForceCurve, ...], Meta(max_length=len(Finger))] = ()
    created: Name = ""

    def noise(self, finger: Finger | None) -> float | None:
        """Noise floor of a finger's vibration sensor, RMS in its unit, where it was measured."""
        return next((p.noise for p in self.piezo if p.finger is finger), None)

    def to_json(self) -> dict[str, Any]:
        """A JSON-ready form."""
        return asdict(self)
