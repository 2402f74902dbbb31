"""Card of a window model: provenance when it is saved, checked record when it is read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Annotated, Any, Literal

import msgspec

from firstcontact.core import Count, Name, Notes, Rate, Sha256
from firstcontact.models._interval import Interval
from firstcontact.models._spec import Task

#: Largest window that a model may ask for: samples, and the numbers of classes beside it.
Samples = Annotated[int, msgspec.Meta(ge=1, le=1_000_000)]
Classes = Annotated[tuple[float, ...], msgspec.Meta(max_length=1000)]
ShoreA = Annotated[float, msgspec.Meta(ge=0, le=100)]


@dataclass(frozen=True, slots=True)
class LearnedFrom:
    """The pinches that a model learned from.

    Parameters
    ----------
    source
        As the recordings' headers say: "twin", "real" and so on.
    pinches
        How many.
    sessions, specimens
        Their names, each once.
    target
        Which label was learned.
    levels
        Distinct values of it.
    objects
        Mean Shore A of each named object.
    contacts
        How the windows were aligned, in words.
    seed
        Of the folds and the training.
    notes
        What was done to the data, one sentence each.
    recorded_rate_hz
        Before they were resampled to the model's rate; None where they were not.
    """

    source: Name = ""
    pinches: Count = 0
    sessions: tuple[Name, ...] = ()
    specimens: tuple[Name, ...] = ()
    target: Literal["shore_a", "hardness_rank"] = "shore_a"
    levels: tuple[float, ...] = ()
    objects: Mapping[Name, ShoreA] = field(default_factory=dict)
    contacts: Notes = ""
    seed: Count = 0
    notes: tuple[Notes, ...] = ()
    recorded_rate_hz: Rate | None = None

    def to_json(self) -> dict[str, Any]:
        """A JSON-ready form."""
        return asdict(self)


@dataclass(frozen=True)
class Provenance:
    """Provenance of a model: training data, held-out scores, and interval.

    Parameters
    ----------
    data
        What it learned from.
    split
        How what the scores were computed on was held out, in words.
    scores
        On data that the scored model did not learn from.
    interval
        Around the answers of a regression; None where there is none.
    conformal
        What the interval was computed from and how many truths it held, or
        ``none`` with the reason why there is no interval.
    detector
        SHA-256 of the card of the detector that goes with the model; None for
        one that goes with any.
    """

    data: LearnedFrom = field(default_factory=LearnedFrom)
    split: str = ""
    scores: Mapping[str, Any] = field(default_factory=dict)
    interval: Interval | None = None
    conformal: Mapping[str, Any] = field(default_factory=dict)
    detector: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelCard:
    """A card as it stands in the file; see :class:`Provenance`.

    Parameters
    ----------
    kind
        Of the model, in the registry.
    task, rate_hz, samples, channels, classes
        What it takes and answers.
    channel_order
        What each channel of a window is.
    data, split, scores, interval, detector
        See :class:`Provenance`. Scores, calibration and training are for people:
        nothing is computed from them.
    calibration
        What is called ``conformal`` in :class:`Provenance`; files keep the name that they had.
    training
        What the training chose.
    versions
        Of the libraries.
    sha256
        Of the weights.
    pinches_sha256
        Of the digests of the pinches learned from; None where there are none.
    """

    kind: Name
    task: Task
    rate_hz: Rate
    samples: Samples
    channels: Annotated[int, msgspec.Meta(ge=1, le=2)]
    channel_order: tuple[Name, ...]
    classes: Classes
    data: LearnedFrom
    sha256: Sha256
    split: Notes = ""
    scores: Mapping[Name, Any] = field(default_factory=dict)
    interval: Interval | None = None
    calibration: Mapping[Name, Any] = field(default_factory=dict)
    training: Mapping[Name, Any] = field(default_factory=dict)
    versions: Mapping[Name, Name] = field(default_factory=dict)
    detector: Sha256 | None = None
    pinches_sha256: Sha256 | None = None
