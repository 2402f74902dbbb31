"""Judgement of the policies for household objects: tuned on some picks, scored on others.

Policies get live estimates, or labels with added noise. They have a slip reflex or none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from firstcontact_lab.grasping._branches import DETECTION, LIFTS
from firstcontact_lab.grasping._families import folds
from firstcontact_lab.grasping._household_numbers import (
    Judged,
    Tables,
    baseline,
    candidate,
    conditions,
    household_policies,
    judged,
    labelled,
)

#: RMSE of the noise that is added to labels, Shore A; 0 for exact labels.
NOISES = (0.0, 3.0, 5.0, 10.0)
#: Kind of lift and latency of the slip detection in full closings with a slip reflex.
FULL = ("gradual", DETECTION[0])

#: Function from the name of an object to the settings of a policy that is judged on it.
SettingsOf = Callable[[str], Mapping[str, float]]


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """Outcomes of the policies on picks that were not used for tuning.

    Parameters
    ----------
    plain
        Outcomes of policies without a slip reflex, by name. Some policies get labels with noise as
        estimates.
    reflexes
        Outcomes of the two policies with a slip reflex: one ignores stiffness, the other uses it.
        The key names the lift and the latency of the slip detection.
    fold_of
        Fold of each object. The settings for a fold were tuned without the objects of the fold.
    """

    plain: Mapping[str, Judged]
    reflexes: Mapping[str, tuple[Judged, Judged]]
    fold_of: Mapping[str, int]

    @property
    def blind(self) -> Judged:
        """Outcomes of the policy that uses no stiffness."""
        return self.plain[baseline().name]

    @property
    def ours(self) -> Judged:
        """Outcomes of the policy that acts on the estimate."""
        return self.plain[candidate().name]

    @property
    def everyone(self) -> dict[str, Judged]:
        """Outcomes by policy. Lift and latency of policies with a slip reflex are ``FULL``."""
        names = (baseline(True).name, candidate(True).name)
        return {**self.plain, **dict(zip(names, self.reflexes[_full()], strict=True))}

    def chosen(self) -> dict[str, SettingsOf]:
        """Return by policy a function that takes an object, and returns its settings.

        These settings were tuned without the object.
        """
        return {name: self._fold_settings(policy) for name, policy in self.everyone.items()}

    def _fold_settings(self, policy: Judged) -> SettingsOf:
        return lambda kind: policy.chosen[self.fold_of[kind]].settings


def judgement(tables: Tables) -> Judgement:
    """Tune and judge all policies."""
    plain = {n: judged(tables, k) for n, k in household_policies().items() if not k.has_reflex()}
    for noise in NOISES:
        estimates = (
            labelled(tables.tuning, noise, tables.seed),
            labelled(tables.judged, noise, tables.seed + 1),
        )
        plain[_noise(noise)] = judged(tables, candidate(), estimates)
    reflexes = {
        name: (judged(tables, baseline(True), None, at), judged(tables, candidate(True), None, at))
        for name, at in conditions().items()
    }
    return Judgement(plain, reflexes, folds(sorted(set(tables.judged.kinds)), tables.folds))


def _full() -> str:
    place = (list(LIFTS).index(FULL[0]), DETECTION.index(FULL[1]))
    return next(name for name, at in conditions().items() if at == place)


def _noise(rmse: float) -> str:
    return "label" if rmse == 0 else f"label_rmse_{rmse:g}"
