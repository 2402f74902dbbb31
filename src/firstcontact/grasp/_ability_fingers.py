"""Where the fingers of an Ability Hand should go: geometry and the force limit.

Nothing here was measured on a hand. The levers are those of the hand's published URDF (size
"large"), taken as constant; how far that is off is said in docs/reference/hands.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees

from firstcontact.core import Command

INDEX, MIDDLE, RING, PINKY, THUMB, ROTATOR = range(6)

#: How far the pad goes by one radian of the finger's joint, m. URDF: index 0.105 (open) to 0.073
#: (80 degrees), here at 45 degrees; thumb 0.052 (pad) to 0.059 (tip).
LEVERS = {INDEX: 0.092, THUMB: 0.055}

#: First of a finger's six touch sensors among the thirty.
SENSORS = {INDEX: 0, THUMB: 24}

#: Flexion of an open and of a fully closed finger, degrees.
OPEN, CLOSED = 5.0, 100.0

#: The thumb stands opposite the index finger, degrees; assumed.
OPPOSED = -80.0

#: Where all six motors go to let go, degrees.
RELEASED = [OPEN] * 5 + [OPPOSED]

#: How far a target may run ahead of a closing finger, degrees; assumed. It bounds what the
#: hand's position controller pushes with where no touch sensor tells of the contact.
LEAD = 10.0

#: Flexion below which a finger counts as open, degrees.
NEARLY_OPEN = OPEN + 3.0


@dataclass(frozen=True, slots=True)
class Felt:
    """What the hand last said of itself.

    Parameters
    ----------
    position
        Of the six motors, degrees.
    touch
        Of the thirty touch sensors above their unloaded reading, N; empty where it has none.
    """

    position: Sequence[float]
    touch: Sequence[float] = ()

    def force(self, finger: int) -> float:
        """Sum over a finger's six sensors, N; 0 without sensors."""
        first = SENSORS[finger]
        return sum(max(x, 0.0) for x in self.touch[first : first + 6])

    @property
    def open(self) -> bool:
        """Whether index finger and thumb are open."""
        return all(self.position[finger] <= NEARLY_OPEN for finger in LEVERS)


class Fingers:
    """Targets of index finger and thumb; the other fingers follow the index.

    Parameters
    ----------
    felt
        Where the hand is; it starts from there.
    """

    def __init__(self, felt: Felt) -> None:
        self._targets = {finger: _within(felt.position[finger]) for finger in LEVERS}

    @property
    def targets(self) -> list[float]:
        """Of the six motors, degrees."""
        index = self._targets[INDEX]
        return [index, index, index, index, self._targets[THUMB], OPPOSED]

    def open(self) -> None:
        """Go to open at once, as fast as the hand can."""
        self._targets = dict.fromkeys(self._targets, OPEN)

    def move(self, command: Command, seconds: float, felt: Felt) -> None:
        """Go on as ordered for some time.

        A closing finger that presses with the limit or more stays where it is, or goes
        back to where it is if its target was ahead of it.
        """
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
