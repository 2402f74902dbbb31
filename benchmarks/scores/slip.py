"""Detections and false alarms of a slip detector on the twin: `python benchmarks/scores/slip.py`.

The threshold is set so that the detector gives few false alarms in holds without slip by one hand
(``SET_ON``). All results are for other hands. Slips are modelled
(docs/explanation/grasping.md#slip-sounds), so these are twin results.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass, replace

import numpy as np
from joblib import Parallel, delayed

from firstcontact.contact import SLIP_DETECTORS
from firstcontact.core import Block, Command, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import holding_force
from firstcontact.grasp import Grip
from firstcontact.twin import draw_pinch
from firstcontact.twin.draw import condition
from firstcontact.twin.drive import Drive
from firstcontact.twin.household import HOUSEHOLD, draw_household_specimen
from firstcontact.twin.outcome import Lift
from firstcontact.twin.plant import GraspPlant
from firstcontact.twin.slip_sound import SlipParameters

SET_ON, HELD_OUT = 1, (2, 3, 4)
COUPLINGS = (0.03, 0.1, 0.3, 1.0)
#: Allowed alarms per minute of quiet holds.
TARGET = 1.0
#: Time after the first contact when the detector starts to listen, s.
HOLDS = 0.25
LAYOUT = fingertip_layout()
#: Lift after a long hold without slip, and two lifts with slip.
QUIET = Lift(delay=2.5, duration=0.3)
LIFTS = {"gradual": Lift(delay=0.45, duration=0.3), "abrupt": Lift(delay=0.45)}
#: Ranges of mass, kg.
GROUPS = (("all", 0, 9), ("< 50 g", 0, 0.05), ("50 to 200 g", 0.05, 0.2), ("> 200 g", 0.2, 9))
#: Ratio of the force to the force that just holds the object.
FIRM, WEAK = 2.0, 0.7


@dataclass(frozen=True)
class Hold:
    """Simulated pinch and lift of one object.

    It has the samples, the sample numbers of contact, slip and drop, and the mass, kg.
    """

    data: np.ndarray
    contact: int
    slips: int | None
    drops: int | None
    mass: float


def hold(seed: int, place: int, ratio: float, lift: Lift, coupling: float) -> Hold | None:
    """Pinch a household object with ``ratio`` times the force that just holds it, and lift it.

    Return None if no finger touched it. ``coupling`` sets how loud a slip is.
    """
    rig = condition("paper-rig")
    specimen = draw_household_specimen(seed, rig, HOUSEHOLD[place], 0)
    specimen = replace(specimen, fragility=None)
    draw = draw_pinch(seed, rig, "slip", specimen, (specimen.name, round(100 * ratio)))
    sound = SlipParameters(coupling=coupling)
    plant = GraspPlant(draw, Drive(), specimen, lift=lift, longest=4.0, slip=sound, slip_seed=seed)
    mass = 2 * draw.object.face_mass
    force = min(ratio * holding_force(mass, specimen.friction), 12.0)
    plant.command(Command(0.10, 1.0))
    data, slips, drops, is_pressing = [], None, None, False
    while not plant.ended:
        data.append(plant.advance(25))
        if plant.contacts and not is_pressing:
            plant.command(Grip().pressing(force))
            is_pressing = True
        if slips is None and plant.slipping_since is not None:
            slips = round(plant.slipping_since * FINGERTIP_RATE)
        if drops is None and plant.lost:
            drops = plant.sample
    if not plant.contacts:
        return None
    return Hold(np.concatenate(data), plant.contacts[0].sample, slips, drops, mass)


def listen(pinch: Hold, threshold: float, begin: int) -> tuple[list[int], list[float]]:
    """Return the sample numbers of slip alarms, and the loudness of each block of 12 samples.

    The hand holds the object from sample ``begin`` on.
    """
    detector = SLIP_DETECTORS["power"](threshold)
    detector.start(LAYOUT)
    alarms, loud = [], []
    detector.update(Block(pinch.data[:begin], 0))
    detector.hold()
    for i in range(begin, len(pinch.data), 12):
        alarms += detector.update(Block(pinch.data[i : i + 12], i))
        loud.append(detector.loudness)
    return alarms, loud


def quiet(seed: int) -> list[Hold]:
    """Return pinches of several objects, held so firmly that none slips."""
    holds = [hold(seed, p, FIRM, QUIET, 0.1) for p in range(len(HOUSEHOLD))]
    return [h for h in holds if h is not None and h.slips is None]


def alarms_a_minute(holds: list[Hold], threshold: float) -> tuple[int, float]:
    """Return the number of slip alarms in these holds, and the total duration of the holds, s."""
    begins = [h.contact + round(HOLDS * FINGERTIP_RATE) for h in holds]
    count = sum(len(listen(h, threshold, b)[0]) for h, b in zip(holds, begins, strict=True))
    seconds = sum(len(h.data) - b for h, b in zip(holds, begins, strict=True)) / FINGERTIP_RATE
    return count, seconds - 0.1 * len(holds)


def _jolt_alarms(pinch: Hold, threshold: float) -> list[int]:
    begin = pinch.contact + round(HOLDS * FINGERTIP_RATE)
    lift = pinch.contact + LIFTS["abrupt"].begin
    return [a for a in listen(pinch, threshold, begin)[0] if lift <= a < lift + 600]


def slipping(seed: int, lift: str, coupling: float, threshold: float) -> list[dict]:
    """Return a row per slip, for the hand of this seed.

    It has the delay of the detection, s, True for a detection within 10 mm, and the number of
    alarms before the slip.
    """
    rows = []
    for place in range(len(HOUSEHOLD)):
        h = hold(seed, place, WEAK, LIFTS[lift], coupling)
        if h is None or h.slips is None:
            continue
        begin = h.contact + round(HOLDS * FINGERTIP_RATE)
        if h.slips < begin + round(0.1 * FINGERTIP_RATE):
            continue
        alarms, _ = listen(h, threshold, begin)
        late_alarms = [a for a in alarms if a >= h.slips]
        rows.append(
            {
                "thing": HOUSEHOLD[place].name,
                "mass": h.mass,
                "delay": (late_alarms[0] - h.slips) / FINGERTIP_RATE if late_alarms else math.inf,
                "in_time": bool(late_alarms) and (h.drops is None or late_alarms[0] < h.drops),
                "before": sum(a < h.slips for a in alarms),
            }
        )
    return rows


def main() -> None:
    """Set the threshold and print the results for the other hands."""
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
    results: dict = {"threshold": float(threshold), "quiet": {}, "slips": {}}
    results["set_on"] = alarms_a_minute(per_hand[SET_ON], threshold)
    for seed in HELD_OUT:
        results["quiet"][seed] = alarms_a_minute(per_hand[seed], threshold)
    # Here the detector starts too early on purpose: at a contact, or while the motor runs.
    for name, at in (("squeeze", 0.03), ("motor and contact", -0.115)):
        count = 0
        for h in per_hand[HELD_OUT[0]]:
            begin = max(h.contact + round(at * FINGERTIP_RATE), 0)
            stop = h.contact + round(HOLDS * FINGERTIP_RATE)
            count += bool([a for a in listen(h, threshold, begin)[0] if a < stop])
        results[name] = [count, len(per_hand[HELD_OUT[0]])]
    # Abrupt loss of support under a firm grip is a jolt, not a slip.
    for coupling in (0.1, 0.3):
        firm = [
            hold(HELD_OUT[0], p, FIRM, LIFTS["abrupt"], coupling) for p in range(len(HOUSEHOLD))
        ]
        firm = [h for h in firm if h is not None and h.slips is None]
        jolts = sum(bool(_jolt_alarms(h, threshold)) for h in firm)
        results[f"jolt, coupling {coupling}"] = [jolts, len(firm)]
    cases = [(lift, c) for lift in LIFTS for c in COUPLINGS]
    jobs = [(s, *case) for case in cases for s in HELD_OUT]
    rows = run(delayed(slipping)(*job, threshold) for job in jobs)
    for case in cases:
        mine = [r for job, rs in zip(jobs, rows, strict=True) if job[1:] == case for r in rs]
        for group, low, high in GROUPS:
            group_rows = [r for r in mine if low <= r["mass"] < high]
            delays = [r["delay"] for r in group_rows if r["in_time"]]
            results["slips"][f"{case[0]}, coupling {case[1]}, {group}"] = {
                "slips": len(group_rows),
                "in_time": sum(r["in_time"] for r in group_rows),
                "alarms_before": sum(r["before"] for r in group_rows),
                "ms_50": round(1e3 * float(np.median(delays)), 1) if delays else None,
                "ms_90": round(1e3 * float(np.percentile(delays, 90)), 1) if delays else None,
            }
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
