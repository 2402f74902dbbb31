"""How often intervals of the grasp study hold the truth: `python benchmarks/grasp_intervals.py`.

The truth is known in a made-up world: kinds are drawn around the things of the household, within
its groups, and two fixed rules press them by the reading of their stiffness and without it. Each
repetition draws as many kinds, hands and specimens as the study judges and computes the interval of
"drops less where both damage a tenth" in two ways: with the boldness found anew in each resample,
as the study has it, and with the boldness of all picks kept and what is damaged more charged as
dropped. No number of the study goes in.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import holding_force
from firstcontact.twin import HOUSEHOLD
from firstcontact_lab.grasping._front import SCALES, front, resampled, scale_at
from firstcontact_lab.grasping._household_numbers import less
from firstcontact_lab.grasping._table import Outcomes

Values = NDArray[np.float64]
Draws = tuple[Outcomes, Outcomes]
#: Standard deviations: of kinds around the household's things (logarithm of weight and of limit;
#: Shore A), of hands, of specimens, of readings.
KINDS, SHORE, HANDS, SPECIMENS, READING = 0.4, 8.0, 0.10, 0.15, 8.0
#: Of the two rules: a force for all; forces for soft and for firm things and where the step is.
BLIND, SOFT, FIRM, MIDDLE, WIDTH = 2.7, 2.0, 6.0, 28.0, 5.0
PICKED_HANDS, PICKED = 4, 2
#: Shares of kinds that are read as they are; others are read as another kind.
RELATED = (1.0, 0.7, 0.0)

GROUPS = np.array([thing.group for thing in HOUSEHOLD])
WEIGHT = np.array(
    [holding_force(t.numbers.mass.value, t.numbers.friction.value) for t in HOUSEHOLD]
)
LIMIT = np.array([np.inf if t.numbers.limit is None else t.numbers.limit.value for t in HOUSEHOLD])
READ = np.array([t.numbers.shore_a.value for t in HOUSEHOLD])


def drawn(
    rng: np.random.Generator, each: int, hands: int, specimens: int, related: float
) -> tuple[Draws, NDArray[np.str_], NDArray[np.intp], NDArray[np.str_]]:
    """So many times each group's number of kinds, pinched: outcomes of both rules, who and what."""
    place = np.concatenate(
        [
            rng.choice(np.flatnonzero(group == GROUPS), each * int((group == GROUPS).sum()))
            for group in np.unique(GROUPS)
        ]
    )
    n = len(place)
    weight = WEIGHT[place] * np.exp(KINDS * rng.standard_normal(n))
    limit = LIMIT[place] * np.exp(KINDS * rng.standard_normal(n))
    own = rng.random(n) < related
    read = READ[np.where(own, place, rng.permutation(place))] + SHORE * rng.standard_normal(n)
    kind, hand, _ = (a.ravel() for a in np.indices((n, hands, specimens)))

    def scatter(by: float, size: int = len(kind)) -> Values:
        return by * rng.standard_normal(size)

    needed = weight[kind] * np.exp(scatter(SPECIMENS))
    bears = limit[kind] * np.exp(scatter(SPECIMENS))
    harder = np.exp(scatter(HANDS, hands))[hand]
    seen = read[kind] + scatter(READING) + (READING * rng.standard_normal(hands))[hand]
    step = SOFT + (FIRM - SOFT) / (1 + np.exp(-np.clip((seen - MIDDLE) / WIDTH, -50, 50)))

    def outcomes(force: Values) -> Outcomes:
        pressed = SCALES[:, None] * (force * harder)
        return Outcomes((pressed < needed).astype(float), (1.15 * pressed > bears).astype(float))

    both = outcomes(step), outcomes(np.full(len(kind), BLIND))
    return both, kind.astype(str), hand, GROUPS[place][kind]


def anew(ours: Outcomes, theirs: Outcomes, weights: Values | None) -> Values:
    """Drops where each resample damages a tenth."""
    return less(*(front(o, weights).drops_at() for o in (ours, theirs)))


def kept(ours: Outcomes, theirs: Outcomes, weights: Values) -> Values:
    """Drops as bold as over all picks; what is damaged more than theirs counts as dropped."""
    a, b = (int(np.argmin(np.abs(SCALES - scale_at(front(o))))) for o in (ours, theirs))
    apart = front(ours).damaged[a] - front(theirs).damaged[b]
    mine, others = front(ours, weights), front(theirs, weights)
    dropped = mine.dropped[a] + mine.damaged[a] - others.damaged[b] - apart
    return less(dropped, others.dropped[b])


def main() -> None:
    """Print the coverage of both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=400)
    parser.add_argument("--resamples", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    rng = np.random.default_rng(asked.seed)
    ways: dict[str, Callable[[Outcomes, Outcomes, Values], Values]] = {"anew": anew, "kept": kept}
    for related in RELATED:
        (ours, theirs), *_ = drawn(rng, 60, 40, 1, related)
        truth = float(anew(ours, theirs, None))
        print(f"{100 * related:.0f} % of kinds read as they are: {truth:+.2f} in truth")
        found: dict[str, list[tuple[float, float]]] = {way: [] for way in ways}
        values = []
        for number in range(asked.repetitions):
            (ours, theirs), *who = drawn(rng, 1, PICKED_HANDS, PICKED, related)
            weights = resampled(*who, asked.resamples, asked.seed + number)
            values.append(float(anew(ours, theirs, None)))
            for way, of in ways.items():
                low, high = np.percentile(of(ours, theirs, weights), [2.5, 97.5])
                found[way].append((float(low), float(high)))
        print(f"  found: mean {np.mean(values):+.2f}, scatter {np.std(values):.2f}")
        for way, ends in found.items():
            low, high = np.array(ends).T
            print(
                f"  {way}: holds the truth {100 * np.mean((low <= truth) & (truth <= high)):.1f} %"
                f" (all above it {100 * np.mean(low > truth):.1f} %,"
                f" all below {100 * np.mean(high < truth):.1f} %),"
                f" median width {np.median(high - low):.2f},"
                f" excludes zero {100 * np.mean(low > 0):.1f} %"
            )


if __name__ == "__main__":
    main()
