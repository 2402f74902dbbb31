"""``firstcontact train``: a model and its card out of recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import tyro

from firstcontact.cli.extras import need
from firstcontact.core.errors import InputError

if TYPE_CHECKING:
    from firstcontact.core import Contact, Dataset
    from firstcontact.study.splits import Split
    from firstcontact.study.training import Examples


@dataclass(frozen=True)
class Train:
    """Learn a stiffness model from the pinches of role "train", and save it with its card."""

    data: tyro.conf.Positional[Path]
    """A recording, or a folder of recordings."""
    out: Path
    """Folder for the model; a model in it is replaced."""
    model: Literal["svm", "cnn", "peak", "train_mean"] = "svm"
    """What learns."""
    task: Literal["regression", "classification"] = "regression"
    """Any Shore A, or one of those learned from."""
    contacts: Literal["auto", "truth", "detected"] = "auto"
    """Where windows start: known contacts or found ones; auto: known if there are any."""
    window_ms: float = 15.0
    """Length of the window after the contact, ms."""
    seed: int = 0
    """Of the split, the search and the training."""

    def run(self) -> None:
        """Score on held-out sessions, then learn from everything and save."""
        if self.model == "cnn":
            need("cnn", "torch", "onnx", "onnxruntime")
        if not 1.0 <= self.window_ms <= 1000.0 or self.seed < 0:
            raise InputError("--window-ms must lie between 1 and 1000, and --seed not below 0")
        from firstcontact.recording import load_dataset
        from firstcontact.stiffness import Card, Task, make_estimator, save_model

        dataset = load_dataset(self.data)
        dataset = dataset.take(~dataset.test)
        if not len(dataset):
            raise InputError(
                f'{self.data}: all pinches have role "test": none is there to learn from'
            )
        target, values = _target(dataset, self.data)
        truth = _aligned_by_truth(self.contacts, dataset, self.data)
        split = _split(dataset, values, self.seed)

        def learn(data: Examples) -> Any:
            groups = data.sessions if (data.sessions != "").all() else None
            estimator = make_estimator(self.model, Task(self.task), data.rate)
            return estimator.fit(data.X, data.y, groups, self.seed)

        def cut(asked: Dataset, learned_from: Dataset, wanted: Any) -> tuple[Examples, str]:
            from firstcontact.study.training import examples

            found, how = starts(asked, learned_from, truth)
            cut = examples(asked, found, 1e-3 * self.window_ms, wanted)
            if len(cut) < 2:
                raise InputError(
                    f"{self.data}: {len(cut)} of {len(asked)} pinches have a contact, a "
                    f"whole window of {self.window_ms:g} ms and a {target}: import longer pinches"
                )
            return cut, how

        known, held = dataset.take(split.train), dataset.take(split.test)
        part, _ = cut(known, known, values[split.train])
        asked, how = cut(held, known, values[split.test])
        scores = score(Task(self.task), asked, learn(part).predict(asked.X), self.seed)
        whole, _ = cut(dataset, dataset, values)
        card = Card(
            data={
                "source": dataset.source,
                "pinches": len(whole),
                "sessions": sorted({str(s) for s in whole.sessions}),
                "specimens": sorted({str(s) for s in whole.specimens}),
                "target": target,
                "levels": sorted({float(v) for v in whole.y}),
                "contacts": how,
                "seed": self.seed,
                "notes": list(dataset.notes),
            },
            split=f"scores: {_words(split, dataset)}; the saved model learned from all pinches",
            scores=scores,
        )
        save_model(learn(whole), self.out, card)
        print(f"{self.model} ({self.task}) learned from {len(whole)} pinches: {self.out}")
        print(f"held out ({_words(split, dataset)}): {in_words(scores)}")


def _target(dataset: Dataset, path: Path) -> tuple[str, Any]:
    import numpy as np

    for name, values in (("shore_a", dataset.shore_a), ("hardness_rank", dataset.hardness_rank)):
        if np.isfinite(values).any():
            return name, values
    raise InputError(f"{path}: no pinch has a shore_a or a hardness_rank: import it with labels")


def _aligned_by_truth(asked: str, dataset: Dataset, path: Path) -> bool:
    known = any(p.first is not None for p in dataset.pinches)
    if asked == "truth" and not known:
        raise InputError(
            f"{path}: no pinch has a known first contact: use --contacts detected, "
            "or import it with first_contact"
        )
    return asked == "truth" or (asked == "auto" and known)


def starts(
    asked: Dataset, learned_from: Dataset | None, truth: bool
) -> tuple[Sequence[Contact | None], str]:
    """First contacts of pinches, and how they were found, in words.

    Parameters
    ----------
    asked
        The pinches.
    learned_from
        What the SVM detector may learn from; without known contacts in it the
        threshold is used, which learns nothing.
    truth
        Take the known contacts instead.
    """
    if truth:
        return [p.first for p in asked.pinches], "known (strips or labels)"
    from firstcontact.contact import detect, make_detector

    if learned_from is not None and any(p.first is not None for p in learned_from.pinches):
        detector = make_detector("svm").fit(learned_from)
    else:
        detector = make_detector("three_sigma").fit(asked)
    found = [next(iter(detect(detector, pinch)), None) for pinch in asked.pinches]
    return found, f"detected ({detector.name})"


def _split(dataset: Dataset, values: Any, seed: int) -> Split:
    """One fold of five: whole sessions where they are known, else pinches."""
    import numpy as np

    from firstcontact.stiffness.folds import inner_folds
    from firstcontact.study.splits import Group, Split, by_session

    if np.isfinite(values).sum() < 10:
        raise InputError(
            f"{int(np.isfinite(values).sum())} labelled pinches are too few to learn from and to "
            "score: record ten or more"
        )
    sessions = np.unique(dataset.sessions)
    levels = np.nan_to_num(values, nan=-1.0)
    if len(sessions) > 1 and "" not in sessions:
        return by_session(dataset.sessions, levels, seed)[0]
    train, held = next(inner_folds(levels, None, seed, k=5))
    return Split("random fifth", train, held, frozenset({Group.SESSION, Group.SPECIMEN}))


def _words(split: Split, dataset: Dataset) -> str:
    held = sorted({str(s) for s in dataset.sessions[split.test]})
    if set(held) & {str(s) for s in dataset.sessions[split.train]}:
        return "random pinches, which flatters: there are no two known sessions"
    return f"session{'s' if len(held) > 1 else ''} {', '.join(held)}"


def score(task: str, asked: Examples, predicted: Any, seed: int) -> dict[str, Any]:
    """Scores of a model on pinches that it did not learn from."""
    from firstcontact.study.metrics import classification_scores, regression_scores

    of = regression_scores if task == "regression" else classification_scores
    return of(asked.y, predicted, asked.clusters, seed)


def in_words(scores: dict[str, Any]) -> str:
    """Scores on one line."""
    names = [n for n in ("accuracy", "rmse", "mae", "mse", "bias") if n in scores]
    numbers = [
        f"{name} {100 * scores[name]:.1f} %" if name == "accuracy" else f"{name} {scores[name]:.2f}"
        for name in names
    ]
    return f"{', '.join(numbers)}, {scores['n']} pinches"
