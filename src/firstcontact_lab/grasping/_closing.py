"""One closing of the simulated hand, controlled by a policy with the live pipeline."""

from __future__ import annotations

import math
from dataclasses import dataclass

from firstcontact.chain import CONFIRMED
from firstcontact.core import Block, Command, Estimate, fingertip_layout
from firstcontact.grasp import Hand, HandLimits, LoopCounts, Policy
from firstcontact.signal import samples_in
from firstcontact.streaming import (
    ClosingStart,
    ContactEvent,
    ContactWithdrawn,
    Grasping,
    NoEstimate,
    Pipeline,
)
from firstcontact.twin import GraspPlant

#: Number of samples of a block, as the device sends them.
BLOCK = 5
#: Number of samples of a block when no policy reads the force arrays.
LONG = 50
LAYOUT = fingertip_layout()


@dataclass(frozen=True, slots=True)
class Order:
    """Command that was sent ``at`` seconds after the first sample of the closing."""

    at: float
    command: Command


class PlantHand(Hand):
    """Hand that sends its commands to the simulated plant."""

    name = "plant"
    limits = HandLimits(speed=0.25, force=12.0, rate=math.inf, watchdog=math.inf)

    def __init__(self, plant: GraspPlant) -> None:
        self.orders: list[Order] = []
        self._plant = plant

    def send(self, command: Command) -> None:
        """Send the command. It takes effect one latency of the drive after the newest sample."""
        self.orders.append(Order(self._plant.now, command))
        self._plant.command(command)

    def release(self) -> None:
        """Open the hand."""
        self.send(Command(-self.limits.speed, 0.0))

    def close(self) -> None:
        """Leave the plant as it is, because a simulated hand has no connection to close."""


@dataclass(frozen=True, slots=True)
class ClosingRecord:
    """Commands and estimates of one closing, and counts such as missed deadlines."""

    orders: tuple[Order, ...]
    estimates: tuple[Estimate, ...]
    counts: LoopCounts


def close(
    plant: GraspPlant,
    policy: Policy,
    pipeline: Pipeline | None = None,
    windows: int = 0,
    feels: bool = True,
) -> ClosingRecord:
    """Close the hand on the plant's object, until the object is lifted or lost."""
    hand = PlantHand(plant)
    grasping = Grasping(policy, hand, LAYOUT)
    estimates: list[Estimate] = []
    listening = pipeline is not None
    certain = math.inf  # sample from which on the first contact stands
    settled = False
    if pipeline is None:
        grasping.on_event(ClosingStart(0, 0))
    while not plant.ended:
        waiting = policy.deadline is not None and not _settled(grasping)
        step = BLOCK if listening or waiting or feels else LONG
        first = plant.sample
        block = Block(plant.advance(step), first)
        if listening and pipeline is not None:
            for event in pipeline.update(block, 0.0):
                if isinstance(event, ContactEvent) and event.first:
                    certain = event.contact.decided + samples_in(CONFIRMED, LAYOUT.rate)
                elif isinstance(event, ContactWithdrawn):
                    certain, settled = math.inf, False
                    estimates.clear()
                settled |= isinstance(event, NoEstimate)
                if isinstance(event, Estimate):
                    # The published study compares whole windows, also where the second contact is
                    # within a window.
                    if event.final:
                        settled = True
                        continue
                    estimates.append(event)
                grasping.on_event(event)
            listening = block.end < certain or not (settled or len(estimates) >= windows)
        grasping.after_block(block)
    return ClosingRecord(tuple(hand.orders), tuple(estimates), grasping.loop.counts)


def _settled(grasping: Grasping) -> bool:
    """Return True if the policy has acted on an estimate, or its deadline has passed."""
    counts = grasping.loop.counts
    return counts.contacts > 0 and counts.misses + counts.estimates > 0
