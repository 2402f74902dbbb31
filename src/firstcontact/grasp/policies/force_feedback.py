"""Classic policy: close until the force sensors report a contact."""

from __future__ import annotations

from typing import ClassVar

from firstcontact.core import ORANGE, RED, Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import ForceArray, Part, Policy, SensorVariant, Tunable


class ForceFeedback(Policy):
    """Policy that slows down and limits the force when a force sensor detects a contact."""

    name = "force_feedback"
    title = "force feedback"
    colour = ORANGE
    part = Part.BASELINE
    tunables: ClassVar = {
        "threshold": Tunable("Threshold", "mV", 1e3, (0.02, 0.05, 0.15), (0.03,)),
        "approach": Tunable("Force until then", "N", 1, (1.0, 1.5, 2.0, 2.5, 12.0), (2.0, 12.0)),
        "speed": Tunable(
            "Speed from then on", "mm/s", 1e3, (0.011, 0.02, 0.04, 0.08), (0.02, 0.08)
        ),
        "force": Tunable("Force from then on", "N", 1, (2.2, 2.5, 2.6, 3.0), (2.6,)),
    }
    variants = (
        SensorVariant("feedback", title, colour),
        SensorVariant("feedback_fast", f"{title}, ideal sheet", RED, ForceArray.IDEAL),
    )

    def __init__(
        self,
        grip: Grip,
        threshold: float = 0.05,
        approach: float = 2.5,
        speed: float = 0.04,
        force: float = 2.2,
    ) -> None:
        super().__init__(grip)
        self.threshold = threshold
        self._approach = Command(grip.speed, min(approach, grip.force))
        self._after_contact = Command(min(speed, grip.speed), min(force, grip.force))
        self._acted = False

    def begin(self) -> Command:
        """Return the approach speed with the approach's force limit."""
        self._acted = False
        return self._approach

    def felt(self, volts: float, since: float | None) -> Command | None:
        """Slow down once, when the rise of a taxel exceeds the threshold."""
        if self._acted or not volts > self.threshold:
            return None
        self._acted = True
        return self._after_contact
