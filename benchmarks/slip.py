"""What a slip detector hears on the twin, and how often it is wrong: `python benchmarks/slip.py`.

Its threshold is set on quiet holds of one hand (``SET_ON``), by false alarms and by no slip; all
that is told is of other hands. Slips are modelled (docs/explanation/slip.md): twin results.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass, replace

import numpy as np
from joblib import Parallel, delayed

from firstcontact.contact import PowerSlipDetector
from firstcontact.core import FINGERTIP_RATE, Block, Command, fingertip_layout, holding_force
from firstcontact.grasp import Grip
from firstcontact.twin import (
    HOUSEHOLD,
    Drive,
    GraspPlant,
    Lift,
    SlipParameters,
    condition,
    draw_household_specimen,
    draw_pinch,
)

SET_ON, HELD_OUT = 1, (2, 3, 4)
COUPLINGS = (0.03, 0.1, 0.3, 1.0)
#: Alarms a minute of quiet holds.
TARGET = 1.0
#: The detector is told of the hold so long after the first contact, s.
HOLDS = 0.25
LAYOUT = fingertip_layout()
#: A lift that nothing slips in, after a long hold; and two that something does.
QUIET = Lift(after=2.5, over=0.3)
LIFTS = {"gradual": Lift(after=0.45, over=0.3), "abrupt": Lift(after=0.45)}
#: Masses, kg.
GROUPS = (("all", 0, 9), ("< 50 g", 0, 0.05), ("50 to 200 g", 0.05, 0.2), ("> 200 g", 0.2, 9))
#: Force over what just holds the object.
FIRM, WEAK = 2.0, 0.7


@dataclass(frozen=True)
class Hold:
    """One pinch as the device sent it, and where what happened in it; samples."""

    data: np.ndarray
    contact: int
    slips: int | None
    drops: int | None
    mass: float


def hold(seed: int, place: int, ratio: float, lift: Lift, coupling: float) -> Hold | None:
    """Close on a thing of the household with a share of the force that it needs; None: missed."""
    rig = condition("paper-rig")
    thing = draw_household_specimen(seed, rig, HOUSEHOLD[place], 0)
    thing = replace(thing, fragility=None)
    draw = draw_pinch(seed, rig, "slip", thing, (thing.name, round(100 * ratio)))
    sound = SlipParameters(coupling=coupling)
    plant = GraspPlant(draw, Drive(), thing, lift=lift, longest=4.0, slip=sound, slip_seed=seed)
    mass = 2 * draw.held.face_mass
    force = min(ratio * holding_force(mass, thing.friction), 12.0)
    plant.command(Command(0.10, 1.0))
    data, slips, drops, told = [], None, None, False
    while not plant.ended:
        data.append(plant.advance(25))
        if plant.contacts and not told:
            plant.command(Grip().pressing(force))
            told = True
        if slips is None and plant.slipping_since is not None:
            slips = round(plant.slipping_since * FINGERTIP_RATE)
        if drops is None and plant.lost:
            drops = plant.sample
    if not plant.contacts:
        return None
    return Hold(np.concatenate(data), plant.contacts[0].sample, slips, drops, mass)


def listen(held: Hold, threshold: float, begin: int) -> tuple[list[int], list[float]]:
    """Alarms, and how loud it was piece by piece."""
    detector = PowerSlipDetector(threshold)
    detector.start(LAYOUT)
    alarms, loud = [], []
    detector.update(Block(held.data[:begin], 0))
    detector.hold()
    for i in range(begin, len(held.data), 12):
        alarms += detector.update(Block(held.data[i : i + 12], i))
        loud.append(detector.loudness)
    return alarms, loud


def quiet(seed: int) -> list[Hold]:
    """Firm holds that nothing slips in."""
    found = [hold(seed, p, FIRM, QUIET, 0.1) for p in range(len(HOUSEHOLD))]
    return [h for h in found if h is not None and h.slips is None]


def alarms_a_minute(holds: list[Hold], threshold: float) -> tuple[int, float]:
    """Alarms, and in how many seconds."""
    begins = [h.contact + round(HOLDS * FINGERTIP_RATE) for h in holds]
    count = sum(len(listen(h, threshold, b)[0]) for h, b in zip(holds, begins, strict=True))
    seconds = sum(len(h.data) - b for h, b in zip(holds, begins, strict=True)) / FINGERTIP_RATE
    return count, seconds - 0.1 * len(holds)


def _jolted(held: Hold, threshold: float) -> list[int]:
    begin = held.contact + round(HOLDS * FINGERTIP_RATE)
    lift = held.contact + LIFTS["abrupt"].begin
    return [a for a in listen(held, threshold, begin)[0] if lift <= a < lift + 600]


def slipping(seed: int, lift: str, coupling: float, threshold: float) -> list[dict]:
    """What is heard of slips: delay (s), whether before 10 mm, and alarms before the slip."""
    rows = []
    for place in range(len(HOUSEHOLD)):
        h = hold(seed, place, WEAK, LIFTS[lift], coupling)
        if h is None or h.slips is None:
            continue
        begin = h.contact + round(HOLDS * FINGERTIP_RATE)
        if h.slips < begin + round(0.1 * FINGERTIP_RATE):
            continue
        alarms, _ = listen(h, threshold, begin)
        after = [a for a in alarms if a >= h.slips]
        rows.append(
            {
                "thing": HOUSEHOLD[place].name,
                "mass": h.mass,
                "delay": (after[0] - h.slips) / FINGERTIP_RATE if after else math.inf,
                "in_time": bool(after) and (h.drops is None or after[0] < h.drops),
                "before": sum(a < h.slips for a in alarms),
            }
        )
    return rows


def main() -> None:
    """Set the threshold, then tell of the other hands."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=2)
    run = Parallel(parser.parse_args().jobs)
    hands = (SET_ON, *HELD_OUT)
    per_hand = dict(zip(hands, run(delayed(quiet)(s) for s in hands), strict=True))
    threshold = next(
        t
        for t in np.round(np.arange(1.2, 20.0, 0.1), 1)
        for count, seconds in [alarms_a_minute(per_hand[SET_ON], t)]
        if count / seconds * 60 <= TARGET
    )
    told: dict = {"threshold": float(threshold), "quiet": {}, "slips": {}}
    told["set_on"] = alarms_a_minute(per_hand[SET_ON], threshold)
    for seed in HELD_OUT:
        told["quiet"][seed] = alarms_a_minute(per_hand[seed], threshold)
    # Contacts, a running motor: the detector is told of a hold where there is none yet.
    for name, at in (("squeeze", 0.03), ("motor and contact", -0.115)):
        count = 0
        for h in per_hand[HELD_OUT[0]]:
            begin = max(h.contact + round(at * FINGERTIP_RATE), 0)
            stop = h.contact + round(HOLDS * FINGERTIP_RATE)
            count += bool([a for a in listen(h, threshold, begin)[0] if a < stop])
        told[name] = [count, len(per_hand[HELD_OUT[0]])]
    # A support that goes at once under a firm grip is a jolt, and no slip.
    for coupling in (0.1, 0.3):
        firm = [
            hold(HELD_OUT[0], p, FIRM, LIFTS["abrupt"], coupling) for p in range(len(HOUSEHOLD))
        ]
        firm = [h for h in firm if h is not None and h.slips is None]
        jolts = sum(bool(_jolted(h, threshold)) for h in firm)
        told[f"jolt, coupling {coupling}"] = [jolts, len(firm)]
    cases = [(lift, c) for lift in LIFTS for c in COUPLINGS]
    jobs = [(s, *case) for case in cases for s in HELD_OUT]
    rows = run(delayed(slipping)(*job, threshold) for job in jobs)
    for case in cases:
        mine = [r for job, rs in zip(jobs, rows, strict=True) if job[1:] == case for r in rs]
        for group, low, high in GROUPS:
            some = [r for r in mine if low <= r["mass"] < high]
            delays = [r["delay"] for r in some if r["in_time"]]
            told["slips"][f"{case[0]}, coupling {case[1]}, {group}"] = {
                "slips": len(some),
                "in_time": sum(r["in_time"] for r in some),
                "alarms_before": sum(r["before"] for r in some),
                "ms_50": round(1e3 * float(np.median(delays)), 1) if delays else None,
                "ms_90": round(1e3 * float(np.percentile(delays, 90)), 1) if delays else None,
            }
    print(json.dumps(told, indent=1))


if __name__ == "__main__":
    main()
