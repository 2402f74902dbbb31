"""Overlap between evaluation data and a model's training data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset
from firstcontact.models._learned_from import Digests, pinch_digests

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class TrainOverlap:
    """Masks of pinches by their relation to a model's training, shape (pinches,).

    Parameters
    ----------
    seen
        Learned from: the same samples, whatever they are called.
    namesakes
        Of a source, session and specimen that it learned from, with other
        samples. They may be new, or the same ones resampled, filtered or cut
        anew; of a model that kept no digests, they may be the same ones.
    same_session, same_specimen
        Of a session, or else a specimen, that it learned from, by name.
    new
        None of these.
    by_samples
        Whether the model says what it learned from by samples.
    """

    seen: Mask
    namesakes: Mask
    same_session: Mask
    same_specimen: Mask
    new: Mask
    by_samples: bool

    def groups(self) -> Mapping[str, Mask]:
        """Each group under its title, unseen ones first."""
        namesakes = (
            "names as in the training, other samples" if self.by_samples else "seen in training"
        )
        return {
            "not seen in training": self.new,
            "sessions of the training by name, other specimens": self.same_session,
            "specimens of the training, other sessions": self.same_specimen,
            namesakes: self.namesakes,
            **({"seen in training": self.seen} if self.by_samples else {}),
        }

    def warnings(self, scored: NDArray[np.intp]) -> list[str]:
        """Return warnings about the pinches at these positions, one line each."""
        seen, namesakes = int(self.seen[scored].sum()), int(self.namesakes[scored].sum())
        apart = "reported apart and say nothing of its errors in use"
        lines = []
        if seen:
            lines.append(
                f"warning: {seen} pinches are ones that the model learned from, sample by sample: "
                f"they are {apart}"
            )
        if namesakes and self.by_samples:
            lines.append(
                f"note: {namesakes} pinches have the session and specimen of others that the model "
                "learned from, and other samples: new ones, or the same resampled or cut anew; "
                "they are reported apart"
            )
        elif namesakes:
            lines.append(
                f"warning: {namesakes} pinches are of sessions and specimens that the model "
                "learned from, by name (an older firstcontact trained it and kept no more): they "
                f"are {apart}"
            )
        return lines


class Named(Protocol):
    """A card that names what was learned from."""

    @property
    def source(self) -> str: ...
    @property
    def sessions(self) -> tuple[str, ...]: ...
    @property
    def specimens(self) -> tuple[str, ...]: ...


def train_overlap(dataset: Dataset, learned_from: Named, digests: Digests | None) -> TrainOverlap:
    """Group pinches by their relation to a model's training.

    Parameters
    ----------
    dataset
        As it was loaded: resampled pinches have other samples.
    learned_from, digests
        Out of the model's folder; digests are None where it has none.
    """
    seen = np.zeros(len(dataset), dtype=np.bool_)
    if digests is not None:
        seen = np.isin(pinch_digests(dataset.pinches), digests)
    specimen = np.isin(dataset.specimens, learned_from.specimens) & ~dataset.test & ~seen
    # Other people's sessions have the same names: only of the same source do they say anything.
    session = np.isin(dataset.sessions, learned_from.sessions) & ~dataset.test & ~seen
    session &= learned_from.source == dataset.source
    return TrainOverlap(
        seen,
        specimen & session,
        session & ~specimen,
        specimen & ~session,
        ~(seen | specimen | session),
        digests is not None,
    )
