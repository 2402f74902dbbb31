"""Detectors held against several sets of recordings that others made."""

from __future__ import annotations

from firstcontact.core import Record
from firstcontact.models import Delays, DetectionScores


class Found(Record, frozen=True, kw_only=True):
    """How a detector did on some recordings at the rate they came at.

    Parameters
    ----------
    n
        Labelled contacts.
    placed_2_ms
        Share whose first trigger places the contact within 2 ms of its label (and of what
        a label that comes from a trigger may be late).
    early_triggers, late, missed
        Contacts whose first trigger is placed more than 2 ms too early, or too late, and those
        without one.
    delay_ms
        From the label to the sample that decided, over those within 2 ms.
    noise_false_alarms_per_minute
        In recordings of the set's own noise, of the worst of the trainings; None where it has
        none.
    """

    n: int
    placed_2_ms: float
    early_triggers: int
    late: int
    missed: int
    delay_ms: Delays | None = None
    noise_false_alarms_per_minute: float | None = None


class FinderFound(Record, frozen=True, kw_only=True):
    """How far onsets that were found looking ahead are from labels, and from a detector's.

    Parameters
    ----------
    placed_2_ms
        Share of the labelled contacts with an onset of the finder within 2 ms.
    from_label_ms, from_detector_ms
        Median and 95th percentile of the distance, ms.
    """

    placed_2_ms: float
    from_label_ms: Delays | None = None
    from_detector_ms: Delays | None = None


class Recorded(Record, frozen=True, kw_only=True):
    """One file of a set, by the detector that the set is scored with."""

    front_end: str
    n: int
    placed_2_ms: float
    early_triggers: int
    delay_ms: Delays | None = None


class SetResults(Record, frozen=True, kw_only=True):
    """What came of one set.

    Parameters
    ----------
    n, placed_2_ms, early_triggers, delay_ms, noise_false_alarms_per_minute
        Of the default detector with ``training``; see :class:`Found`.
    sensor, rate_hz, front_end
        What it was recorded with.
    training
        What that detector had learned from, a key of ``detectors``' entries.
    early_ms
        How much earlier than its label a contact may be.
    noise_seconds
        How much noise was listened to.
    detectors
        By detector, and by what it had learned from: the ``twin``, or the set's ``others``, with
        the tested specimen left out.
    files
        By recording, of the same detector and training.
    finder
        Of the onset finder, which looks ahead.
    order_rho, order_p
        Of hardness, by a score that nothing was fitted to.
    class_held_out
        Balanced accuracy of the hardness class with the material held out, by length in ms.
    chance
        Balanced accuracy of any constant prediction: all score the same.
    """

    n: int
    placed_2_ms: float | None = None
    early_triggers: int | None = None
    noise_false_alarms_per_minute: float | None = None
    delay_ms: Delays | None = None
    sensor: str
    rate_hz: float
    front_end: str
    pinches: int
    materials: int
    training: str | None = None
    early_ms: float = 0.0
    noise_seconds: float = 0.0
    detectors: dict[str, dict[str, Found]] | None = None
    files: dict[str, Recorded] | None = None
    finder: FinderFound | None = None
    order_rho: float | None = None
    order_p: float | None = None
    class_held_out: dict[str, float] | None = None
    chance: float | None = None


class NoiseFound(Record, frozen=True, kw_only=True):
    """The twin's pinches over some noise, by what learned from others over the modelled one.

    Parameters
    ----------
    noise
        What lies under them, in words.
    detectors
        By detector.
    estimator, estimated
        What read 15 ms from the default detector's contacts, and of how many pinches.
    rmse, rmse_unseen
        Of those, of objects that it had learned from (on other rigs) and of others, Shore A; None
        where there are none.
    """

    noise: str
    detectors: dict[str, DetectionScores]
    estimator: str
    estimated: int
    rmse: float | None = None
    rmse_unseen: float | None = None


class SetsResults(Record, frozen=True, kw_only=True):
    """``results.json`` of all sets, and of the twin over other noises."""

    command: str
    seconds: float
    versions: dict[str, str]
    sets: dict[str, SetResults]
    noises: dict[str, NoiseFound] | None = None
