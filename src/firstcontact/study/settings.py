"""How large a study is."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Settings:
    """Size and seed of a study.

    Parameters
    ----------
    block_pinches, object_pinches
        Twin pinches for each of the 5 blocks and of the 8 objects.
    durations
        Window lengths to compare, s.
    folds
        Folds of a split by session.
    epochs
        Epochs of the CNN.
    calls
        Single-window predictions that are timed.
    early
        How much earlier than its label a contact may be, s: labels that come
        from a trigger are late.
    seed
        Of everything drawn.
    workers
        Processes.
    """

    block_pinches: int = 500
    object_pinches: int = 50
    durations: tuple[float, ...] = (0.002, 0.003, 0.005, 0.008, 0.010, 0.015)
    folds: int = 5
    epochs: int = 40
    calls: int = 10_000
    early: float = 0.0
    seed: int = 0
    workers: int = 2

    def quick(self) -> Settings:
        """The same study, small: every part runs, no number is to be quoted."""
        return replace(
            self,
            block_pinches=40,
            object_pinches=10,
            durations=(0.003, 0.008, 0.015),
            folds=3,
            epochs=8,
            calls=2_000,
        )
