"""Processor time of one commanded closing of the simulated hand, relative to a reference.

Each closing gets the same three commands. The reference builds a new plant for each closing, uses
the fine time step to the end, and reads all samples in blocks of five until the last command. The
other variants copy a prepared plant at its first sample or at the first contact. They use a coarser
time step after the contacts. All variants run in turn in this process, without detector and policy,
after compilation. Run it on an idle machine: ``OMP_NUM_THREADS=1 python benchmarks/closing.py``.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from firstcontact.core import Command
from firstcontact.twin import CONDITIONS, draw_pinch
from firstcontact.twin.drive import Drive
from firstcontact.twin.household import HOUSEHOLD, draw_household_specimen
from firstcontact.twin.outcome import Lift
from firstcontact.twin.plant import GraspPlant

#: Samples of a block.
BLOCK = 5
#: Samples of a block after the last command.
LONG = 50
#: Samples between two commands after the first contact.
STEP = 100


def plant(number: int, latency: float, lift: Lift) -> GraspPlant:
    """Return a simulated hand before closing ``number``, at rest around a household object."""
    household_object = HOUSEHOLD[number % len(HOUSEHOLD)]
    specimen = draw_household_specimen(0, CONDITIONS["paper-rig"], household_object, 0)
    draw = draw_pinch(0, CONDITIONS["paper-rig"], "benchmark", specimen, number)
    return GraspPlant(draw, Drive(latency=latency), specimen, lift=lift, longest=2.5)


def approach(hand: GraspPlant) -> GraspPlant:
    """Command a gentle closing, and advance the hand until a finger touches. Return the hand."""
    hand.command(Command(hand.nominal.speed, 1.0))
    while not hand.contacts:
        hand.move(BLOCK)
    return hand


def close(hand: GraspPlant, reads: bool) -> Any:
    """Close gently, slow down at the first contact, then squeeze. Return the outcome.

    With ``reads``, the samples are read until the last command.
    """
    if hand.sample == 0:
        hand.command(Command(hand.nominal.speed, 1.0))
    orders = [Command(0.03, 1.0), Command(0.03, 4.0)]
    due: int | None = None
    while not hand.ended:
        samples = BLOCK if orders else LONG
        if reads:
            hand.advance(samples)
        else:
            hand.move(samples)
        if due is None and hand.contacts:
            due = hand.sample
        if orders and due is not None and hand.sample >= due:
            hand.command(orders.pop(0))
            due += STEP
    return hand.outcome


def new_closing(number: int, latency: float, lift: Lift) -> Any:
    """Build a simulated hand, run a whole closing, and return the outcome."""
    return close(plant(number, latency, lift), reads=True)


def forked(hand: GraspPlant, reads: bool) -> Any:
    """Copy a prepared hand, run the rest of the closing with the copy, and return the outcome."""
    return close(hand.copy(), reads)


def spent(work: Callable[[], Any]) -> tuple[float, Any]:
    """Call a function that runs a closing. Return its processor time, ms, and its outcome."""
    begin = time.process_time()
    outcome = work()
    return 1e3 * (time.process_time() - begin), outcome


def main() -> dict[str, float]:
    """Measure all variants and print the table. Return the ratios to the reference by name."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=3, help="passes over the household")
    options = parser.parse_args()
    ratios = {}
    for lift in (Lift(), Lift(duration=0.5)):
        for latency in (0.0, 0.02):
            rows, other = [], 0
            for number in range(-3, options.rounds * len(HOUSEHOLD)):
                base = plant(number, latency, lift)
                touching = approach(base.copy())  # all policies share this part
                measured = [
                    spent(partial(new_closing, number, latency, lift)),
                    spent(partial(forked, base, False)),
                    spent(partial(forked, touching, False)),
                    spent(partial(forked, base, True)),
                ]
                if number < 0:
                    continue
                rows.append([ms for ms, _ in measured])
                fine, quick = measured[0][1], measured[1][1]
                other += (fine.dropped, fine.broken) != (quick.dropped, quick.broken)
            old, new, later, read = np.median(np.array(rows), axis=0)
            print(f"latency {1e3 * latency:.0f} ms, lift {lift.duration:g} s; ms of CPU time:")
            for name, ms in (("forked", new), ("at the contact", later), ("and read", read)):
                print(f"  {name}: {ms:.1f}, {old / ms:.1f} times less than {old:.1f}")
            print(f"  {other} of {len(rows)} closings end otherwise than the reference")
            ratios[f"{1e3 * latency:.0f} ms latency, {lift.duration:g} s lift, forked"] = old / new
    return ratios


if __name__ == "__main__":
    main()
