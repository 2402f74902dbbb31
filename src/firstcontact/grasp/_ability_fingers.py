"""Position targets for the fingers of an Ability Hand: geometry and force limit.

No value here was measured on a hand. The lever arms come from the hand's published URDF (size
"large") and are taken as constant. docs/reference/hands.md states the error of this assumption.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, radians

from firstcontact.core import Command

INDEX, MIDDLE, RING, PINKY, THUMB, ROTATOR = range(6)

#: Travel of the pad per radian of the finger's joint, m. URDF: index 0.105 (open) to 0.073
#: (80 degrees), here at 45 degrees; thumb 0.052 (pad) to 0.059 (tip).
LEVERS = {INDEX: 0.092, THUMB: 0.055}

#: Index of a finger's first touch sensor. A finger has six, the hand thirty.
SENSORS = {INDEX: 0, THUMB: 24}

#: Flexion of an open and of a fully closed finger, degrees.
OPEN, CLOSED = 5.0, 100.0

#: Rotation of the thumb opposite the index finger, degrees; assumed.
OPPOSED = -80.0

#: Targets of the six motors that open the hand, degrees.
RELEASED = [OPEN] * 5 + [OPPOSED]

#: Largest lead of a target over a closing finger, degrees; assumed. It limits the force of the
#: hand's position controller when no touch sensor reports the contact.
LEAD = 10.0

#: Largest flexion of a finger that counts as open, degrees.
NEARLY_OPEN = OPEN + 3.0


@dataclass(frozen=True, slots=True)
class Felt:
    """State that the hand last reported."""

    position: Sequence[float]
    touch: Sequence[float] = ()

    def force(self, finger: int) -> float:
        """Return the sum of the forces on a finger's six sensors, N; 0 without sensors."""
        first = SENSORS[finger]
        return sum(max(x, 0.0) for x in self.touch[first : first + 6])

    @property
    def travel(self) -> float:
        """Travel of the fingertips from the joints' zero position, mean of index and thumb, m."""
        travels = [radians(self.position[f]) * lever for f, lever in LEVERS.items()]
        return sum(travels) / len(travels)

    @property
    def open(self) -> bool:
        """True if index finger and thumb are open."""
        return all(self.position[finger] <= NEARLY_OPEN for finger in LEVERS)


class Fingers:
    """Position targets of index finger and thumb. The other fingers follow the index."""

    def __init__(self, felt: Felt) -> None:
        self._targets = {finger: _within(felt.position[finger]) for finger in LEVERS}

    @property
    def targets(self) -> list[float]:
        """Targets of the six motors, degrees."""
        index = self._targets[INDEX]
        return [index, index, index, index, self._targets[THUMB], OPPOSED]

    def open(self) -> None:
        """Set the targets to open."""
        self._targets = dict.fromkeys(self._targets, OPEN)

    def move(self, command: Command, seconds: float, felt: Felt) -> None:
        """Move the targets at the commanded speed for ``seconds``."""
        for finger, lever in LEVERS.items():
            target, position = self._targets[finger], felt.position[finger]
            pressed = command.speed >= 0 and felt.force(finger) >= command.force
            if pressed:
                target = min(target, position)
            else:
                target += degrees(command.speed / lever) * seconds
                if command.speed > 0:
                    target = min(target, position + LEAD)
            self._targets[finger] = _within(target)


def _within(flexion: float) -> float:
    return min(max(flexion, OPEN), CLOSED)
