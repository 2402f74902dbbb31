"""Simulated hand that closes on one object and follows commands, to test grasp control.

Without commands it equals a pinch of a simulated set. Samples are computed ahead, as far as no
later command can take effect.
"""

from __future__ import annotations

import copy
import math
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Command, Contact, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import GRAVITY, holding_force
from firstcontact.twin._run import PinchRun
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.drive import Drive
from firstcontact.twin.mechanics import BUFFER, CONTACT_FORCE, FACE, INDENTATION, OUTPUTS
from firstcontact.twin.objects import TwinObject
from firstcontact.twin.outcome import DROPPED, GraspOutcome, Lift, slide, stable_since
from firstcontact.twin.pinch import BURN_IN
from firstcontact.twin.sensor import DeviceFilter, PinchFingertips, mask_contacts, settled_filter
from firstcontact.twin.slip_sound import SlipParameters, SlipSound

#: Time for which the lifted object is observed, s.
WATCHED = 0.20
#: Longest pinch, s. A pinch without contact ends then.
LONGEST = 1.5


class GraspPlant:
    """Simulated hand during one pinch, from the start of its closing to the lifted object."""

    def __init__(
        self,
        draw: PinchDraw,
        drive: Drive,
        held_object: TwinObject,
        *,
        lift: Lift | None = None,
        longest: float = LONGEST,
        slip: SlipParameters | None = None,
        slip_seed: int = 0,
    ) -> None:
        self._run = PinchRun(draw, longest, BURN_IN, drive, damped=True)
        times = self._run.times[BURN_IN:] - BURN_IN / FINGERTIP_RATE
        if times[-1] <= draw.timing.second:
            raise ValueError(
                f"a pinch of {longest} s ends before its second contact: use a longer one"
            )
        self._tips = PinchFingertips(draw, times)
        self._velostat = draw.velostat
        self._device: DeviceFilter | None = None
        self._run.limit = (
            math.inf if held_object.fragility is None else held_object.fragility.draw(draw.rng)
        )
        self._run.advance(BURN_IN)
        self._delay = drive.delay
        self._friction = held_object.friction
        # Part of an indentation that is the object's (the rest is the pad's), as in the mechanics.
        moduli = np.array([p.pad_modulus for p in draw.fingers])
        self._give = moduli / (moduli + draw.object.modulus)
        self._mass = 2 * draw.object.face_mass
        self._lift = Lift() if lift is None else lift
        self._watched = round(WATCHED * FINGERTIP_RATE)
        self._motion = np.zeros((times.size, 2, OUTPUTS))
        self._contacts: list[Contact] = []
        # Distance (m) and speed (m/s) of the slip at each sample.
        self._slid = np.zeros((times.size, 2))
        self._data = np.zeros((times.size, fingertip_layout().width), np.int16)
        self._made = 0
        self._end = times.size
        self._sound = None
        if slip is not None:
            rng = np.random.default_rng(slip_seed)
            self._sound = SlipSound(draw.fingers, self._mass, self._friction, slip, rng)
        self.nominal = Command(self._run.nominal_speed, drive.force)
        self.sample = 0

    @property
    def limit(self) -> float:
        return self._run.limit

    @property
    def now(self) -> float:
        """Time from the first to the newest sample, s; 0 before the first sample."""
        return max(self.sample - 1, 0) / FINGERTIP_RATE

    @property
    def ended(self) -> bool:
        """True after the object was lifted and watched, or after the longest time."""
        return self.sample >= self._end

    def command(self, command: Command) -> None:
        """Give a command.

        It takes effect after the drive's latency, counted from the newest sample.
        """
        self._run.order(command, BURN_IN + self.sample - 1 + self._delay)

    def advance(self, samples: int) -> NDArray[np.int16]:
        """Simulate the next ``samples`` samples, and return them as the device sends them."""
        first = self.sample
        self.move(samples)
        read = self._tips.sample
        if read < self.sample:
            scans = self._tips.read(self._motion_with_slip(read))
            if self._device is None:
                self._device = settled_filter(scans[0], self._velostat)
            self._data[read : self._made] = self._device.update(scans)
        return self._data[first : self.sample].copy()

    def move(self, samples: int) -> None:
        """Simulate the next ``samples`` samples without the sensors, which takes half the time."""
        stop = min(self.sample + samples, len(self._motion))
        if stop > self._made:
            self._compute_until(stop)
        self.sample = stop

    def copy(self, lift: Lift | None = None) -> Self:
        """Return an independent copy in the current state. ``lift`` replaces the planned lift."""
        other = copy.copy(self)
        other._run = self._run.fork()
        other._tips = self._tips.fork()
        other._device = None if self._device is None else self._device.fork()
        other._sound = None if self._sound is None else self._sound.fork()
        for name in ("_motion", "_slid", "_data"):
            original = getattr(self, name)
            copied = np.zeros_like(original)
            copied[: self._made] = original[: self._made]
            setattr(other, name, copied)
        if lift is not None:
            other._lift = lift
            other._add_contacts([])
            other._slide(self.sample, other._motion[self.sample : self._made])
        return other

    def _motion_with_slip(self, first: int) -> NDArray[np.float64]:
        """Return the motion from the sample ``first`` on, with the sound of slips in the piezos.

        Its shape is (samples, 2, OUTPUTS).
        """
        motion = self._motion[first : self._made]
        if self._sound is None:
            return motion
        hanging = np.zeros(len(motion))
        if self._contacts:
            hanging = self._lift.hanging(first - self._contacts[0].sample, len(motion))
        speeds = np.ascontiguousarray(self._slid[first : self._made, 1])
        motion = motion.copy()
        motion[..., BUFFER] += self._sound.hear(motion[..., CONTACT_FORCE], speeds, hanging)
        return motion

    def _compute_until(self, stop: int) -> None:
        """Compute the motion at least up to the sample number ``stop``, which is not included."""
        first = self._made
        # Samples beyond the end are computed on request, but not ahead.
        samples = max(stop, min(stop + self._delay, self._end)) - first
        motion = self._run.advance(samples)
        self._motion[first : first + samples] = motion
        self._made += samples
        self._add_contacts(mask_contacts(motion[..., INDENTATION] > 0, first, self._contacts))
        self._slide(first, motion)

    def _add_contacts(self, contacts: list[Contact]) -> None:
        self._contacts = self._contacts + contacts
        if self._contacts:
            end = self._contacts[0].sample + self._lift.samples + self._watched
            self._end = min(len(self._motion), end)

    def _slide(self, first: int, motion: NDArray[np.float64]) -> None:
        if self._contacts:
            hanging = self._lift.hanging(first - self._contacts[0].sample, len(motion))
            forces = np.ascontiguousarray(motion[..., CONTACT_FORCE])
            slide(
                forces, hanging, self._mass, self._friction,
                1 / FINGERTIP_RATE, self._slid[max(first - 1, 0)].copy(),
                self._slid[first : first + len(motion)],
            )  # fmt: skip

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Contacts so far in order of time, as the contact strips would show them."""
        return tuple(c for c in self._contacts if c.sample < self.sample)

    @property
    def slipped(self) -> float:
        """Distance that the object has slid down in the hand so far, m."""
        return float(self._slid[self.sample - 1, 0]) if self.sample else 0.0

    @property
    def lost(self) -> bool:
        """True if the object has slid far enough to count as dropped."""
        return self.slipped > DROPPED

    @property
    def slipping_since(self) -> float | None:
        """Time at which the current slip began, s after the first sample; None without a slip."""
        speeds = self._slid[: self.sample, 1]
        if not (speeds.size and speeds[-1] > 0):
            return None
        still = np.flatnonzero(speeds == 0)
        return float(still[-1] + 1) / FINGERTIP_RATE

    @property
    def grip(self) -> float:
        """Grip force at the newest sample, N: the smaller of both contact forces."""
        return float(self._motion[self.sample - 1, :, CONTACT_FORCE].min()) if self.sample else 0.0

    @property
    def forces(self) -> NDArray[np.float64]:
        """Contact forces of index and thumb so far, N, shape (samples, 2)."""
        return self._motion[: self.sample, :, CONTACT_FORCE].copy()

    @property
    def outcome(self) -> GraspOutcome:
        broken = self._run.broken_at
        crack = None if broken is None or broken - BURN_IN >= self.sample else broken - BURN_IN
        # Ignore the remains of a broken object.
        end = self.sample if crack is None else crack + 1
        motion = self._motion[:end]
        forces = motion[..., CONTACT_FORCE]
        grip = forces.min(axis=1)
        seen = [c.sample for c in self.contacts]
        distance, speed = map(float, self._slid[end - 1]) if end else (0.0, 0.0)
        gravity = 0.0
        if seen:
            gravity = GRAVITY * float(self._lift.hanging(end - 1 - seen[0], 1)[0])
        is_slipping = speed > 0 and self._friction * float(forces[-1].sum()) < self._mass * gravity
        stable = None
        if seen and crack is None:
            stable = stable_since(grip, holding_force(self._mass, self._friction))
        depths = np.nan_to_num(motion[..., INDENTATION]).clip(0.0)
        squeeze = motion[..., FACE].sum(axis=1) + depths @ self._give
        return GraspOutcome(
            peak_force=float(grip.max(initial=0.0)),
            squeeze=float(squeeze.max(initial=0.0)),
            time_to_grasp=None if stable is None else (stable - seen[0]) / FINGERTIP_RATE,
            slipped=distance,
            dropped=distance > DROPPED or is_slipping or (not seen and self.ended),
            broken=crack is not None,
            first_contact=seen[0] / FINGERTIP_RATE if seen else None,
            second_contact=seen[1] / FINGERTIP_RATE if len(seen) > 1 else None,
        )
