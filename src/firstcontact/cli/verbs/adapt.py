"""``firstcontact adapt``: an any-time model of one's own rig, in seconds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from firstcontact.cli.choices import one_of
from firstcontact.contact import DETECTORS
from firstcontact.core import InputError, counted, percent, same_rate
from firstcontact.models import check_replaceable, replaced

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from firstcontact.contact import Detector
    from firstcontact.core import Dataset
    from firstcontact.models import Alignment, Digests, InContextModel


class UnknownRigError(InputError):
    """Pinches from which no rig can be known."""


@dataclass(frozen=True)
class Adapt:
    """Make a model that answers at any time after a contact, from a few pinches of known things."""

    data: tyro.conf.Positional[Path | None] = None
    """A recording, or a folder of them, of things of known Shore A; left out: a model that knows
    no rig, with intervals as wide as that makes them."""
    out: Path = Path("model")
    """Folder for the model and its detector; those that are in it are replaced whole."""
    detector: Annotated[str | None, one_of(DETECTORS)] = None
    """What finds contacts; left out: the usual one where it can learn from these pinches, else one
    that learns nothing; without recordings the one that was trained on the twin."""
    seed: int = 0
    """Of the folds in which the ways to know the rig are compared."""

    def run(self) -> None:
        """Find the contacts, tell the pre-trained model of the rig, and save it."""
        former = check_replaceable(self.out, (), anytime=True)
        from firstcontact.core import replacing_folder

        with replacing_folder(self.out) as making:
            lines = self._made(making)
        for line in lines:
            print(line)
        if former:
            print(replaced(self.out))

    def _made(self, making: Path) -> list[str]:
        """Make model and detector in a folder; what to say when it is in its place."""
        from firstcontact.contact import make_detector, pretrained_detector, save_detector
        from firstcontact.models import pretrained, save_anytime

        if not 0 <= self.seed < 1 << 32:
            raise InputError("--seed must lie between 0 and 4294967295")
        base = pretrained()
        if self.data is None:
            detector = pretrained_detector()
            if self.detector is not None and self.detector != detector.name:
                if DETECTORS.find(self.detector).learns:
                    raise InputError(f"--detector {self.detector} learns: name recordings, too")
                detector = make_detector(self.detector)
            save_detector(detector, making)
            save_anytime(base, making, {})
            return [f"any-time model of an unknown rig and detector {detector.name}: {self.out}"]
        from firstcontact.cli.verbs.train import at_rate
        from firstcontact.models import fit_detector, pinch_digests
        from firstcontact.recording import load_dataset

        dataset = load_dataset(self.data)
        dataset = dataset.take(~dataset.test)
        if not len(dataset):
            raise InputError(f'{self.data}: all pinches have role "test": none is there to use')
        digests = pinch_digests(dataset.pinches)
        if not same_rate(dataset.layout.rate, base.rate):
            # The detector, too, is for the rate that the model takes: they listen to one stream.
            dataset = at_rate(dataset, base.rate, self.data)
        detector = fit_detector(dataset, self.detector)
        lines = adapted(base, dataset, digests, detector, self.data, making, self.seed)
        save_detector(detector, making)
        return [*lines, f"any-time model and detector {detector.name}: {self.out}"]


def adapted(
    base: InContextModel,
    dataset: Dataset,
    digests: Digests,
    detector: Detector,
    data: Path,
    out: Path,
    seed: int,
    contacts: Alignment | None = None,
) -> list[str]:
    """Tell a pre-trained model of these pinches' rig and save it; what there is to say.

    The pinches have the model's rate; ``digests`` are of them as they were recorded, and
    ``contacts`` theirs, where they were found already.

    Raises
    ------
    UnknownRigError
        Pinches from which no rig can be known.
    """
    import numpy as np

    from firstcontact.core import Serial
    from firstcontact.models import LabelledTouches, adapt_network, found_as_live, save_anytime

    contacts = contacts or found_as_live(dataset, detector, seed, Serial())
    if not np.isfinite(dataset.shore_a).any():
        raise UnknownRigError(
            f"{data}: no pinch has a Shore A, and a rig is known by objects of known Shore A: "
            "record with --shore or a plan with a column shore, or import with a column shore_a"
        )
    known = LabelledTouches.of(dataset, contacts.contacts)
    try:
        made = adapt_network(base, known.touches, known.shore_a, known.named_sessions, seed)
    except InputError as error:
        raise UnknownRigError(f"{data}: {error}") from None
    if made.refusal:
        raise UnknownRigError(f"{data}: {made.refusal}")
    levels = [float(level) for level in np.unique(known.shore_a)]
    about: dict[str, Any] = {
        "pinches": len(known),
        "levels": levels,
        "contacts": contacts.how,
        "source": dataset.source,
        "sessions": _names(known.sessions),
        "specimens": _names(known.specimens),
        "scores": {f"held out, {way}": round(score, 3) for way, score in made.scores.items()},
    }
    if made.check is not None:
        about["scores"] |= {
            "held out, always the mean": round(made.mean_rmse, 3),
            "held out, least coverage": round(made.check.coverage, 3),
            "intervals widened": round(float(made.check.scales.max()), 3),
        }
    save_anytime(made.model, out, about, digests[known.which])
    lines = [
        f"the rig is known by {counted(len(known), 'pinch')} of "
        f"{counted(len(levels), 'Shore A level')}"
    ]
    if made.check is None:
        return [*lines, "errors and intervals are not checked: too few pinches to hold some out"]
    compared = ", ".join(f"{way}: rmse {score:.2f}" for way, score in made.scores.items())
    widest = made.check.scales.max()
    widened = f"now up to {widest:.2f} times as wide" if widest > 1 else "kept"
    return [
        *lines,
        f"fingers as one or each by itself, on pinches held out: {compared} Shore A (always "
        f"answering the mean: {made.mean_rmse:.2f}); kept: {made.way}",
        f"{100 * base.level:.0f} % intervals held at least {percent(made.check.coverage)} of "
        f"{counted(made.check.n, 'pinch')} held out, at each time: {widened}",
    ]


def _names(names: NDArray[np.str_]) -> list[str]:
    return sorted({str(name) for name in names})
