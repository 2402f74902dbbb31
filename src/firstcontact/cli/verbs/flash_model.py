"""Command ``firstcontact flash-model``: transfer of a model to a device."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from firstcontact.cli.options import Option
from firstcontact.core import DeviceError

if TYPE_CHECKING:
    from firstcontact.core import Calibration


@dataclass(frozen=True)
class FlashModel:
    """Send a model to a device that runs it. The device stores the complete model or none of it."""

    model: Annotated[Path, Option(positional=True)]
    """Model folder, as `adapt` or `train` writes it."""
    device: str
    """Serial port of the device."""
    calibration: Path | None = None
    """File that `calibrate` wrote; by default the noise is measured first."""
    estimator: str | None = None
    """Estimator that shall predict, by default the first one of the model."""

    def run(self) -> None:
        from firstcontact.device.flashing import check_model_fits, flash_model
        from firstcontact.export.hand_image import hand_image

        # Refuse a model before anything changes on the device, and before the user has to wait.
        image = hand_image(self.model, estimator=self.estimator)
        check_model_fits(self.device, image.data)
        image = hand_image(self.model, self._floors(), self.estimator)
        digest = flash_model(self.device, image.data)
        if digest != image.digest:
            raise DeviceError(
                f"{self.device} has the model {digest}, not {image.digest}: flash it again"
            )
        print(f"{self.device} confirms the model {digest}: {len(image.data)} bytes")

    def _floors(self) -> Calibration:
        from firstcontact.core.calibration import read_calibration
        from firstcontact.device.noise_floor import REST, measure_noise
        from firstcontact.device.serial_source import SerialSource

        if self.calibration is not None:
            return read_calibration(self.calibration)
        print(f"measuring the noise floor, {REST:g} s: keep the hand open and still", flush=True)
        with SerialSource(self.device) as source:
            return measure_noise(source)
