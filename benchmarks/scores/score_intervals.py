"""Coverage of the bootstrap intervals of scores: `python benchmarks/scores/score_intervals.py`.

The truth is known: each cluster (object, rig or session) has its own error, which its pinches
share, and each pinch has a further error. All errors are normal. The share of repetitions whose
95 % interval holds the true RMSE should be 95 %. *Percentiles* are the plain percentiles of the
same resamples.
"""

from __future__ import annotations

import argparse

import numpy as np

from firstcontact.models.scores import cluster_intervals, resampled_sums

#: Standard deviations of the errors that clusters and pinches have, Shore A; pinches in a cluster.
CLUSTER, PINCH, EACH = 6.0, 3.0, 50


def coverage(clusters: int, repeats: int, seed: int) -> tuple[float, float]:
    """Return the coverage of the package's 95 % intervals, and of plain percentiles."""
    rng = np.random.default_rng(seed)
    names = np.repeat(np.arange(clusters), EACH)
    truth = np.hypot(CLUSTER, PINCH)
    held = np.zeros(2)
    for repeat in range(repeats):
        shared = np.repeat(rng.normal(0, CLUSTER, clusters), EACH)
        squares = (shared + rng.normal(0, PINCH, len(names))) ** 2
        columns = np.stack([np.ones(len(names)), squares], axis=1)
        ours = cluster_intervals(
            columns, {"rmse": lambda s: np.sqrt(s[..., 1] / s[..., 0])}, names, repeat
        )["rmse"]
        means = resampled_sums(squares.reshape(clusters, EACH).mean(axis=1), repeat) / clusters
        plain = np.sqrt(np.quantile(means, (0.025, 0.975)))
        held += [low <= truth <= high for low, high in (ours, plain)]
    return float(held[0] / repeats), float(held[1] / repeats)


def main() -> None:
    """Print the coverage for several numbers of clusters."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=1000, help="repetitions")
    parser.add_argument("--seed", type=int, default=0, help="random seed")
    settings = parser.parse_args()
    for clusters in (6, 8, 12, 24, 33):
        ours, plain = coverage(clusters, settings.repeats, settings.seed)
        print(
            f"{clusters} clusters: {100 * ours:.0f} %; percentiles {100 * plain:.0f} %", flush=True
        )


if __name__ == "__main__":
    main()
