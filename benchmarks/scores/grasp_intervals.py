"""Coverage of the grasp study's intervals: `python benchmarks/scores/grasp_intervals.py`.

The truth is known in a synthetic world. Kinds of objects are drawn at random; their weights and
limits are near those of the household objects. Two fixed rules grip them: the first knows a
stiffness reading, the second does not. Each repetition draws as many kinds, hands and specimens as
the study has. It computes the interval of the reduction in drops with stiffness, at 10 % damage, in
two ways. *Chosen again*: each resample finds new force scales for both rules, as in the study.
*Kept*: the scales come from all picks, and additional damage counts as drops. The study's numbers
are not used.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.physics import holding_force
from firstcontact.twin.household import HOUSEHOLD
from firstcontact_lab.grasping.judgement import relative_reduction
from firstcontact_lab.grasping.table import Outcomes
from firstcontact_lab.grasping.tuning import SCALES, bootstrap_weights, compute_front, find_scale

Values = NDArray[np.float64]
Draws = tuple[Outcomes, Outcomes]
#: Standard deviations: of kinds around the household's objects (logarithm of weight and of limit;
#: Shore A), of hands, of specimens and of readings.
KINDS, SHORE, HANDS, SPECIMENS, READING = 0.4, 8.0, 0.10, 0.15, 8.0
#: Parameters of the two rules: one force for all objects; forces for soft and firm objects, and
#: centre and width of the step.
BLIND, SOFT, FIRM, MIDDLE, WIDTH = 2.7, 2.0, 6.0, 28.0, 5.0
PICKED_HANDS, PICKED = 4, 2
#: Shares of kinds with their own stiffness reading; the others get the reading of another kind.
RELATED = (1.0, 0.7, 0.0)

GROUPS = np.array([t.group for t in HOUSEHOLD])
WEIGHT = np.array(
    [holding_force(t.numbers.mass.value, t.numbers.friction.value) for t in HOUSEHOLD]
)
LIMIT = np.array([np.inf if t.numbers.limit is None else t.numbers.limit.value for t in HOUSEHOLD])
READ = np.array([t.numbers.shore_a.value for t in HOUSEHOLD])


def drawn(
    rng: np.random.Generator, each: int, hands: int, specimens: int, related: float
) -> tuple[Draws, NDArray[np.str_], NDArray[np.intp], NDArray[np.str_]]:
    """Draw kinds of objects, and pinches of them.

    Return the outcomes of both rules, and the kind, hand and group of each pinch. A share
    ``related`` of the kinds has a stiffness that fits weight and limit; the others have a random
    one. Each group has ``each`` times as many kinds as in the study.
    """
    place = np.concatenate(
        [
            rng.choice(np.flatnonzero(group == GROUPS), each * int((group == GROUPS).sum()))
            for group in np.unique(GROUPS)
        ]
    )
    n = len(place)
    weight = WEIGHT[place] * np.exp(KINDS * rng.standard_normal(n))
    limit = LIMIT[place] * np.exp(KINDS * rng.standard_normal(n))
    is_own = rng.random(n) < related
    read = READ[np.where(is_own, place, rng.permutation(place))] + SHORE * rng.standard_normal(n)
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


def rescaled(ours: Outcomes, theirs: Outcomes, weights: Values | None) -> Values:
    """Return the reduction in drops by rule ``ours``, in each resample.

    Each resample scales the forces of both rules to 10 % damage.
    """
    return relative_reduction(*(compute_front(o, weights).drop_share() for o in (ours, theirs)))


def fixed(ours: Outcomes, theirs: Outcomes, weights: Values) -> Values:
    """Return the reduction in drops by rule ``ours``, with the same force scales in all resamples.

    Additional damage counts as drops.
    """
    a, b = (int(np.argmin(np.abs(SCALES - find_scale(compute_front(o))))) for o in (ours, theirs))
    apart = compute_front(ours).damaged[a] - compute_front(theirs).damaged[b]
    first, second = compute_front(ours, weights), compute_front(theirs, weights)
    dropped = first.dropped[a] + first.damaged[a] - second.damaged[b] - apart
    return relative_reduction(dropped, second.dropped[b])


def main() -> None:
    """Print the coverage of both intervals."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=400)
    parser.add_argument("--resamples", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    settings = parser.parse_args()
    rng = np.random.default_rng(settings.seed)
    methods: dict[str, Callable[[Outcomes, Outcomes, Values], Values]] = {
        "chosen again": rescaled,
        "kept": fixed,
    }
    for related in RELATED:
        (ours, theirs), *_ = drawn(rng, 60, 40, 1, related)
        truth = float(rescaled(ours, theirs, None))
        print(f"{100 * related:.0f} % of kinds with their own reading: true value {truth:+.2f}")
        intervals: dict[str, list[tuple[float, float]]] = {method: [] for method in methods}
        values = []
        for number in range(settings.repetitions):
            (ours, theirs), *units = drawn(rng, 1, PICKED_HANDS, PICKED, related)
            weights = bootstrap_weights(*units, settings.resamples, settings.seed + number)
            values.append(float(rescaled(ours, theirs, None)))
            for method, compute in methods.items():
                low, high = np.percentile(compute(ours, theirs, weights), [2.5, 97.5])
                intervals[method].append((float(low), float(high)))
        print(f"  estimates: mean {np.mean(values):+.2f}, scatter {np.std(values):.2f}")
        for method, ends in intervals.items():
            low, high = np.array(ends).T
            covered = np.mean((low <= truth) & (truth <= high))
            print(
                f"  {method}: holds the truth {100 * covered:.1f} %"
                f" (all above it {100 * np.mean(low > truth):.1f} %,"
                f" all below {100 * np.mean(high < truth):.1f} %),"
                f" median width {np.median(high - low):.2f},"
                f" excludes zero {100 * np.mean(low > 0):.1f} %"
            )


if __name__ == "__main__":
    main()
