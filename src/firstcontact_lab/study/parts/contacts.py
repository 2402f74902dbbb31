"""Contact detection, scored on sessions that the detector was not trained on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from firstcontact.contact import (
    DETECTORS,
    closing_starts,
    count_starts,
    cut_closings,
    describe_starts,
    untrained_name,
)
from firstcontact.core import ByName, Contact, Dataset, Record, Runner, percent
from firstcontact.models import TOLERANCE, DetectionScores, Group, Split, score_decisions
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import SHARE_TOLERANCE, Claim, Row, Table, lifted, row_table
from firstcontact_lab.study._contact_figures import delay_figure, detectors_figure
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.detection import detection_splits, judge_detectors, trigger_delays
from firstcontact_lab.study.part import Part, Step, Subjects, distinct, per_subject
from firstcontact_lab.study.parts.data import DATA
from firstcontact_lab.study.settings import StudySettings


@dataclass(frozen=True, slots=True)
class Accepted:
    """Tolerances for detected contacts, ms.

    Parameters
    ----------
    early
        Longest time by which a contact may precede its label.
    tolerance
        Largest distance of a placement from the contact.
    """

    early: float = 0.0
    tolerance: float = 1e3 * TOLERANCE

    @classmethod
    def from_results(cls, subjects: Subjects) -> Accepted:
        """Return the tolerances of a study. They are the same for all subjects."""
        early = (results[CONTACT].about.early_ms or 0.0 for results in subjects.values())
        return cls(max(early, default=0.0))

    @property
    def place(self) -> str:
        """Name of the reference of all times: "label" or "known contact"."""
        return "label" if self.early else "known contact"

    @property
    def placed(self) -> str:
        """Text about accepted placements, such as "within ±3 ms"."""
        if not self.early:
            return f"within ±{self.tolerance:g} ms"
        return f"−{self.early + self.tolerance:g} to +{self.tolerance:g} ms from its label"

    @property
    def placed_fully(self) -> str:
        """Accepted placements as the end of a sentence, after "placing the contact"."""
        if not self.early:
            return f"within ±{self.tolerance:g} ms of the known contact"
        return (
            f"from {self.early + self.tolerance:g} ms before its label, which may come up to "
            f"{self.early:g} ms late, to {self.tolerance:g} ms after it"
        )

    @property
    def decided(self) -> str:
        """Text about accepted decisions, such as "within 3 ms"."""
        if not self.early:
            return f"within {self.tolerance:g} ms"
        return f"−{self.early:g} to +{self.tolerance:g} ms from its label"

    @property
    def decided_fully(self) -> str:
        """Accepted decisions as the end of a sentence, after "the trigger came"."""
        if not self.early:
            late = f"{self.tolerance:g} ms after it"
            return f"no earlier than the known contact and no later than {late}"
        return f"from {self.early:g} ms before its label to {self.tolerance:g} ms after it"


class DetectionFolds(Record, frozen=True, kw_only=True):
    """Folds of the detection scores.

    ``held_out``: "sessions" or "pinches". ``shares``: groups (sessions, specimens) that are on both
    sides of a fold.
    """

    n: int
    held_out: str
    shares: list[str]


class MissingContacts(Record, frozen=True, kw_only=True):
    """Number of pinches in which the detector ``by`` found no contact, of ``of`` pinches."""

    by: str
    pinches: int
    of: int


class ContactConditions(Record, frozen=True, kw_only=True):
    """Conditions of the detection scores, and origin of the windows.

    ``windows_start_at``: name of the detector at whose contacts windows start, or "known".
    ``steady_state``: number of closings by how their start was found. ``folds``: folds of the
    scores. ``early_ms``: longest time by which a contact may precede its label. ``not_found``:
    contacts that the chosen detector missed.
    """

    windows_start_at: str | None = None
    steady_state: dict[str, int] | None = None
    folds: DetectionFolds | None = None
    early_ms: float | None = None
    not_found: MissingContacts | None = None


#: Scores by the name of the detector.
ContactResults = ByName[DetectionScores, ContactConditions]


#: Start of windows if the chosen detector cannot be trained: the labelled contacts.
KNOWN = "known"


def contacts(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Detect all first contacts out of fold, and score every detector against known contacts.

    The function sets ``subject.detections`` to the contacts of the detector in the settings.
    Detectors get each pinch from the start of its closing. If the detector in the settings cannot
    be trained, windows start at the known contacts. If an untrained detector finds more contacts
    than are known, windows start at its contacts.
    """
    starts = closing_starts(subject.dataset)
    dataset = cut_closings(subject.dataset, starts)
    has_contact = np.array([p.first is not None for p in dataset.pinches])
    splits = detection_splits(dataset, settings.seed)
    decisions, failed = judge_detectors(dataset, splits, settings.early, runner)
    if not any(DETECTORS[name].learns for name in decisions):
        everyone = np.arange(len(dataset))
        splits = [Split("all", everyone[:0], everyone)]
        decisions, _ = judge_detectors(dataset, splits, settings.early, runner)
    start = settings.detector if settings.detector in decisions else untrained_name()
    detections = tuple(decision.first for decision in decisions[start])
    missing = sum(contact is None for contact in detections)
    not_found = MissingContacts(by=start, pinches=missing, of=len(dataset))
    left_out = []
    if start == settings.detector:
        subject.detections = detections
    else:
        title = DETECTORS[start].title
        start_text = f"where the {title} fires"
        if has_contact.sum() >= len(dataset) - missing:
            start, start_text = KNOWN, "at the known contacts"
        else:
            subject.detections = detections
        failed[settings.detector] += f"; windows start {start_text}"
    left_out += [f"{DETECTORS[n].title} contact detector: {why}." for n, why in failed.items()]
    about = ContactConditions(
        windows_start_at=start,
        steady_state=count_starts(starts),
        folds=_describe_folds(splits) if has_contact.any() else None,
        early_ms=1e3 * settings.early if has_contact.any() else None,
        not_found=not_found,
    )
    scores: dict[str, DetectionScores] = {}
    figures: list[Figure] = []
    if has_contact.any():
        for name, given in decisions.items():
            step = DETECTORS[name].step
            scores[name] = score_decisions(given, dataset, step, settings.early)
        example = _example(dataset, detections)
        delays = {
            name: 1e3 * trigger_delays(dataset, [decision.first for decision in given])[1]
            for name, given in decisions.items()
        }
        figures.append(delay_figure(dataset, delays, settings.early))
        figures.append(
            detectors_figure(
                subject.dataset.pinches[example],
                {name: given[example].windows for name, given in decisions.items()},
                starts[example].sample,
                settings.early,
            )
        )
    else:
        left_out.append("Scores of contact detection: no pinch has a known first contact.")
    return PartResult([CONTACT(ByName(scores, about))], figures, left_out)


def _describe_folds(splits: Sequence[Split]) -> DetectionFolds:
    shares = sorted(set().union(*(s.shares for s in splits)))
    held_out = "pinches" if Group.SESSION in shares else "sessions"
    return DetectionFolds(n=len(splits), held_out=held_out, shares=[str(s) for s in shares])


def _example(dataset: Dataset, detections: Sequence[Contact | None]) -> int:
    """Return the index of the middle pinch among those with a known and a detected contact."""
    able = [
        i
        for i, (p, c) in enumerate(zip(dataset.pinches, detections, strict=True))
        if p.first is not None and c is not None
    ]
    able = able or [i for i, p in enumerate(dataset.pinches) if p.first is not None]
    return able[len(able) // 2]


CONTACT: Field[ContactResults] = Field("contact", ContactResults, ByName({}, ContactConditions()))
#: Accuracy of detection (section IV of the paper). The paper does not define what is counted.
PUBLISHED = {"three_sigma": 0.906, "svm": 1.0}


class Target(NamedTuple):
    """Target of a detector: smallest shares of right windows and pinches, largest median delay.

    The delay is in ms.
    """

    windows: float
    pinches: float
    delay: float


#: The project's own target for the detector that is perfect in the paper.
TARGET = {"svm": Target(windows=0.999, pinches=0.995, delay=3.0)}


def window_starts(subjects: Subjects) -> list[str]:
    """Return the detectors at whose contacts windows start; "known" stands for known contacts."""
    starts = (results[CONTACT].about.windows_start_at for results in subjects.values())
    return distinct(start for start in starts if start is not None)


def is_learned(results: SubjectResults) -> bool:
    """Return True if windows start at contacts of a trained detector."""
    return names.learned(results[CONTACT].about.windows_start_at)


def _start_text(start: str) -> str:
    windows = "the windows for stiffness start"
    title = names.detector(start).title
    if names.learned(start):
        return (
            f"The contact of each pinch comes from a detector ({title}) that was not trained on "
            f"this pinch, and {windows} there."
        )
    if start in DETECTORS:
        return f"{windows.capitalize()} where the {title} fires, which needs no training."
    return f"No detector could be trained: {windows} at the known contacts."


def _text(subjects: Subjects) -> str:
    sentences = [
        "Detectors decide on windows of 20 ms.",
        *map(_start_text, window_starts(subjects)),
    ]
    if any(names.detectors(results[CONTACT]) for results in subjects.values()):
        sentences.append(
            "A detector decides later than the contact that it places. Both times are scored."
        )
    return " ".join(sentences)


def detector_rows(accepted: Accepted) -> list[Row[DetectionScores]]:
    """Return the row definitions of one detector. Remarks explain how each number was counted."""
    suffix = " after its label" if accepted.early else ""
    return [
        Row("windows right", lambda s: s.window_accuracy, "share", remark="of all 20 ms windows"),
        Row(
            "contact windows found",
            lambda s: s.contact_windows_found,
            "share",
            remark="The first window that includes at least 1 ms after the contact, at most one "
            "per pinch. If it is missed, the next window may find the contact, but later.",
        ),
        Row(
            f"placed {accepted.placed}",
            lambda s: s.pinch_success,
            "share",
            remark="Share of pinches whose first trigger is on the right finger and places the "
            f"contact {accepted.placed_fully}.",
        ),
        Row(
            f"and decided {accepted.decided}",
            lambda s: s.decided_within_3_ms,
            "share",
            remark=f"A stricter count: the decision also comes {accepted.decided_fully}.",
        ),
        Row(
            "false alarms a minute",
            lambda s: s.false_alarms_per_minute,
            "rate",
            remark="of closing without contact",
        ),
        Row(
            f"median delay of the decision{suffix}",
            lambda s: s.median_delay,
            "ms",
            remark="All first triggers on the right finger that are not early.",
        ),
    ]


#: Further rows of one detector, for the report's table.
_DETAILS: Sequence[Row[DetectionScores]] = (
    Row("95th percentile of the delay", lambda s: s.delay_ms.p95 if s.delay_ms else None, "ms"),
    Row("quiet windows silent", lambda s: s.quiet_windows_silent, "share"),
    Row(
        "pinches: contact too soon to be seen",
        lambda s: s.too_soon,
        remark="before the motor had settled and its steady state was known; also counted below",
    ),
    Row("pinches: placed too early", lambda s: s.false_alarms),
    Row("pinches: wrong finger", lambda s: s.wrong_finger),
    Row("pinches: placed too late", lambda s: s.late),
    Row("pinches: never", lambda s: s.misses),
)


def contact_table(results: SubjectResults, notes: bool = True) -> Table | None:
    """Return a table of the scores of all detectors, per window and per pinch."""
    detectors = {
        names.detector(name).title: results[CONTACT][name]
        for name in names.detectors(results[CONTACT])
    }
    if not detectors:
        return None
    rows = detector_rows(Accepted.from_results({"": results}))
    caption = _caption(results, next(iter(detectors.values())))
    if not notes:
        return row_table(rows, detectors, caption)
    return row_table([*rows, *_DETAILS], detectors, caption, notes=True)


def _caption(results: SubjectResults, scores: DetectionScores) -> str:
    about = results[CONTACT].about
    folds = about.folds or DetectionFolds(n=1, held_out="sessions", shares=[])
    text = f"Out of fold: {folds.n} folds, whole {folds.held_out} held out; {scores.n:,} pinches."
    if "specimen" in folds.shares:
        data = results[DATA]
        unseen = data and data.test_pinches
        text += " Specimens lie on both sides" + (", but for unseen objects." if unseen else ".")
    if ways := about.steady_state:
        words = describe_starts(ways)
        text += f" {words[0].upper()}{words[1:]}."
    if scores.lookahead_ms:
        text += f" Delays contain {scores.lookahead_ms:.1f} ms of the resampler's look-ahead."
    if early := about.early_ms:
        text += (
            f" Labels may come up to {early:g} ms late: triggers and quiet windows are judged "
            "accordingly, and the delay after a label is shorter than after the contact."
        )
    missing = about.not_found
    if missing and missing.pinches and about.windows_start_at != KNOWN:
        text += (
            f" {missing.pinches:,} of {missing.of:,} pinches have no detected contact, so no "
            "window and no estimate."
        )
    return text


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    accepted = Accepted.from_results(subjects)
    rows = []
    for name in DETECTORS.names:
        prefix, published = f"Contact, {names.detector(name).title}: ", PUBLISHED.get(name)
        for place, row in enumerate(detector_rows(accepted)):

            def find(results: SubjectResults, name: str = name) -> DetectionScores | None:
                return results[CONTACT].get(name)

            if published is None:
                rows.append(lifted(row, prefix, find))
            elif place == 0:
                remark = (
                    "The paper does not define its accuracy; windows are the closest reading. "
                    f"{_silence(name, subjects)}".strip()
                )
                claim = Claim(published, SHARE_TOLERANCE)
                rows.append(lifted(row, prefix, find, percent(published), remark, claim=claim))
            else:
                target = _target_remark(name, subjects, accepted) if row.unit == "ms" else ""
                rows.append(lifted(row, prefix, find, remark=f"{row.remark} {target}".strip()))
    return rows


def _silence(name: str, subjects: Subjects) -> str:
    """Return a sentence with the accuracy that a detector would have if it never fired."""

    def quiet(results: SubjectResults) -> str | None:
        scores = results[CONTACT].get(name)
        return percent(scores.quiet_windows / scores.windows) if scores and scores.windows else None

    shares = per_subject(subjects, quiet)
    return f"Scores of a detector that never fires: {', '.join(shares)}." if shares else ""


def _missed(scores: DetectionScores, target: Target) -> list[str]:
    """Return the names of the quantities, such as "delay", that do not reach the target."""
    windows, delay = scores.window_accuracy, scores.median_delay
    reached = {
        "windows": windows is not None and windows >= target.windows,
        "pinches": scores.pinch_success >= target.pinches,
        "delay": delay is not None and delay <= target.delay,
    }
    return [part for part, is_reached in reached.items() if not is_reached]


def _target_remark(name: str, subjects: Subjects, accepted: Accepted) -> str:
    """Return a sentence on the target of a detector, and on the subjects that reach it."""
    target = TARGET.get(name)
    if accepted.early or target is None:
        return ""  # the count is less strict than the target

    def verdict(results: SubjectResults) -> str | None:
        scores = results[CONTACT].get(name)
        if scores is None:
            return None
        missed = _missed(scores, target)
        return f"not reached ({', '.join(missed)})" if missed else "reached"

    verdicts = per_subject(subjects, verdict)
    if not verdicts:
        return ""
    return (
        f"Target of at least {percent(target.windows)} of windows, "
        f"{percent(target.pinches)} of pinches placed within ±3 ms, and a median delay of at "
        f"most {target.delay:g} ms: {'; '.join(verdicts)}."
    )


PART = Part(
    "contact",
    "Contact detection",
    [Step("contact detection", contacts, cost=25)],
    _text,
    [lambda results: contact_table(results, notes=False), contact_table],
    _rows,
    needs=("data",),
)
