"""A hand that closes on one object and takes commands while it does."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.command import Command
from firstcontact.core.layout import FINGERTIP_RATE, Finger, fingertip_layout
from firstcontact.twin.commanded import CommandedRun
from firstcontact.twin.converters import Converters, settled_filter
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.drive import Drive
from firstcontact.twin.filter import DeviceFilter
from firstcontact.twin.mechanics import CONTACT_FORCE, INDENTATION, SQUEEZED
from firstcontact.twin.objects import TwinObject
from firstcontact.twin.outcome import DROPPED, GRAVITY, Outcome, needed_force, slide, stable_from
from firstcontact.twin.pinch import BURN_IN
from firstcontact.twin.sensor import VelostatParameters

#: The object is lifted off its support so long after the first contact, s.
LIFT = 0.45
#: And watched for this long, s.
WATCHED = 0.20
#: No pinch is longer, s: without a contact it ends here.
LONGEST = 1.5


class GraspPlant:
    """One pinch from the closing hand to the lifted object.

    It begins as a simulated pinch does: both fingers closing at their drawn speed, the
    motor heard, 130 ms or more before the first contact. Never commanded it is that pinch.
    The same draw and commands give the same bytes, however it is advanced.

    Parameters
    ----------
    draw
        The chance in it; a plant uses it up.
    drive
        What the commands go through.
    thing
        What is pinched: its mass, friction and how much it bears.
    velostat
        Force array of both fingers in place of the draw's own.
    lift
        Time from the first contact to the instant at which the support is gone, s.
    longest
        The longest that it can take, s.

    Attributes
    ----------
    nominal
        The command that it begins with: the drawn speed, the drive's force.
    sample
        Number of the next sample.
    limit
        Contact force at which this object breaks, N.
    """

    def __init__(
        self,
        draw: PinchDraw,
        drive: Drive,
        thing: TwinObject,
        velostat: VelostatParameters | None = None,
        *,
        lift: float = LIFT,
        longest: float = LONGEST,
    ) -> None:
        self._run = CommandedRun(draw, drive, longest, BURN_IN)
        times = self._run.times[BURN_IN:] - BURN_IN / FINGERTIP_RATE
        sheets = None if velostat is None else (velostat, velostat)
        self._converters = Converters(draw, times, sheets)
        self._run.limit = math.inf if thing.fragility is None else thing.fragility.draw(draw.rng)
        self._run.advance(BURN_IN)
        self._device: DeviceFilter | None = None
        # Nothing that is commanded from now on changes the next samples as far as the
        # latency reaches: they are made together and handed out as they are asked for.
        self._ahead = np.empty((0, len(fingertip_layout().channels)), np.int16)
        self._made = 0
        self._delay = drive.delay
        self._thing = thing
        # As the mechanics has it, the share of what the object gives of an indentation.
        moduli = np.array([p.pad_modulus for p in draw.fingers])
        self._give = moduli / (moduli + draw.held.modulus)
        self._mass = 2 * draw.held.face_mass
        self._lift = round(lift * FINGERTIP_RATE)
        self._watched = round(WATCHED * FINGERTIP_RATE)
        self._forces = np.zeros((times.size, 2))
        self._depths = np.zeros((times.size, 2))
        self._bulk = np.zeros(times.size)
        self._contacts: list[int | None] = [None, None]
        self.nominal = Command(self._run.nominal, drive.force)
        self.sample = 0

    @property
    def limit(self) -> float:
        """Contact force at which this object breaks, N."""
        return self._run.limit

    @property
    def now(self) -> float:
        """Instant of the newest sample, s from the first; 0 before it."""
        return max(self.sample - 1, 0) / FINGERTIP_RATE

    @property
    def ended(self) -> bool:
        """Whether the object has been lifted and watched, or never was touched."""
        return self.sample >= self._end

    @property
    def _first(self) -> int | None:
        return min((c for c in self._contacts if c is not None), default=None)

    @property
    def _end(self) -> int:
        most = len(self._forces)
        first = self._first
        return most if first is None else min(most, first + self._lift + self._watched)

    def command(self, command: Command) -> None:
        """Order; takes effect the drive's latency after the newest sample."""
        self._run.tell(command, BURN_IN + self.sample - 1 + self._delay)

    def advance(self, samples: int) -> NDArray[np.int16]:
        """Take the next samples as the device sends them.

        Returns
        -------
        ndarray
            Shape (samples, 16), in the order of
            :func:`firstcontact.core.layout.fingertip_layout`; less at the longest's end.
        """
        lacking = samples - len(self._ahead)
        if lacking > 0:
            self._ahead = np.concatenate([self._ahead, self._make(max(lacking, self._delay))])
        data, self._ahead = self._ahead[:samples], self._ahead[samples:]
        self.sample += len(data)
        return data

    def _make(self, samples: int) -> NDArray[np.int16]:
        motion, body = self._run.advance(samples)
        scans = self._converters.read(motion)
        here = slice(self._made, self._made + len(motion))
        self._forces[here] = motion[..., CONTACT_FORCE]
        self._depths[here] = motion[..., INDENTATION]
        self._bulk[here] = body[:, SQUEEZED]
        for f in Finger:
            if self._contacts[f] is None and scans[:, 4 + f].any():
                self._contacts[f] = self._made + int(np.argmax(scans[:, 4 + f]))
        if self._device is None:
            self._device = settled_filter(scans[0], self._converters.sheets)
        self._made += len(motion)
        return self._device.update(scans)

    @property
    def forces(self) -> NDArray[np.float64]:
        """Contact force of index and thumb so far, N, shape (samples, 2)."""
        return self._forces[: self.sample].copy()

    @property
    def gaps(self) -> NDArray[np.float64]:
        """Of each finger to its face so far, m, negative where it presses; NaN where not known."""
        return -self._depths[: self.sample]

    @property
    def outcome(self) -> Outcome:
        """How it went, as far as it has gone."""
        crack = self._run.broken_at
        broken = crack is not None and crack < BURN_IN + self.sample
        # What is left of a broken object is not what was to be held.
        end = crack - BURN_IN + 1 if crack is not None and broken else self.sample
        forces = self._forces[:end]
        grip = forces.min(axis=1)
        seen = sorted(c for c in self._contacts if c is not None and c < self.sample)
        friction = self._thing.friction
        lifted = forces[seen[0] + self._lift :] if seen else forces[:0]
        way, speed = slide(lifted, self._mass, friction, 1 / FINGERTIP_RATE)
        lost = speed > 0 and friction * float(forces[-1].sum()) < self._mass * GRAVITY
        since = None
        if seen and not broken:
            since = stable_from(grip, needed_force(self._mass, friction))
        depths = np.nan_to_num(self._depths[:end]).clip(0.0)
        squeeze = self._bulk[:end] + depths @ self._give
        return Outcome(
            peak_force=float(grip.max(initial=0.0)),
            squeeze=float(squeeze.max(initial=0.0)),
            time_to_grasp=None if since is None else (since - seen[0]) / FINGERTIP_RATE,
            slipped=way,
            dropped=way > DROPPED or lost or (not seen and self.ended),
            broken=broken,
            first_contact=seen[0] / FINGERTIP_RATE if seen else None,
            second_contact=seen[1] / FINGERTIP_RATE if len(seen) > 1 else None,
        )
