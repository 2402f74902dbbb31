"""Study part ``contacts``: scores of contact detectors on sessions not used for training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS
from firstcontact.contact.closing_start import (
    closing_starts,
    count_starts,
    cut_closings,
    describe_starts,
)
from firstcontact.contact.registry import untrained_name
from firstcontact.core import Dataset, Record
from firstcontact.core.display import INK
from firstcontact.core.records import ByName
from firstcontact.core.text import percent
from firstcontact.jobs import Runner
from firstcontact.models.splits import Group, Split
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import (
    SHARE_TOLERANCE,
    Claim,
    Row,
    Table,
    row_for_results,
    row_table,
)
from firstcontact_lab.study.detection import detection_splits, judge_detectors, trigger_delays
from firstcontact_lab.study.detection_scores import (
    TOLERANCE,
    DetectionScores,
    resampler_lookahead,
    score_decisions,
)
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects, distinct
from firstcontact_lab.study.parts.data import DATA

_LATE = 1e3 * TOLERANCE


@dataclass(frozen=True, slots=True)
class Accepted:
    """Tolerance of contact scores: how far a correct contact may precede its label, ms.

    The properties are texts about this tolerance.
    """

    early: float

    @classmethod
    def from_results(cls, subjects: Subjects) -> Accepted:
        """Return the tolerance of a study, which is the same for all of its datasets."""
        early = (results[CONTACT].about.early_ms or 0.0 for results in subjects.values())
        return cls(max(early, default=0.0))

    @property
    def place(self) -> str:
        return "label" if self.early else "known contact"

    @property
    def placed(self) -> str:
        """Text on the accepted positions of contacts, such as "within ±3 ms"."""
        if not self.early:
            return f"within ±{_LATE:g} ms"
        return f"−{self.early + _LATE:g} to +{_LATE:g} ms from its label"

    @property
    def decided(self) -> str:
        """Text on the accepted times of decisions, such as "within 3 ms"."""
        if not self.early:
            return f"within {_LATE:g} ms"
        return f"−{self.early:g} to +{_LATE:g} ms from its label"


class DetectionFolds(Record, frozen=True, kw_only=True):
    n: int
    held_out: str
    shares: list[str]


class MissingContacts(Record, frozen=True, kw_only=True):
    by: str
    pinches: int
    of: int


class ContactConditions(Record, frozen=True, kw_only=True):
    windows_start_at: str | None = None
    steady_state: dict[str, int] | None = None
    folds: DetectionFolds | None = None
    early_ms: float | None = None
    not_found: MissingContacts | None = None


ContactResults = ByName[DetectionScores, ContactConditions]


#: Triggers further from the contact than this, ms, are counted at the edges.
EDGE = 15.0
#: Start of windows if the chosen detector cannot be trained: the labelled contacts.
KNOWN = "known"


def contacts(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
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
        delays = {
            name: 1e3 * trigger_delays(dataset, [decision.first for decision in given])[1]
            for name, given in decisions.items()
        }
        figures.append(delay_figure(dataset, delays, settings.early))
    else:
        left_out.append("Scores of contact detection: no pinch has a known first contact.")
    return PartResult([CONTACT(ByName(scores, about))], figures, left_out)


def delay_figure(
    dataset: Dataset, delays: Mapping[str, NDArray[np.float64]], early: float
) -> Figure:
    late = f" (labels may come up to {1e3 * early:g} ms late)" if early else ""
    waited = 1e3 * resampler_lookahead(dataset)
    counted = f" The resampler's look-ahead of {waited:.1f} ms is counted." if waited else ""
    zero = "label" if early else "known contact"
    rate = dataset.layout.rate
    with canvas(len(delays), 1, (6.2, 1.2 + 1.4 * len(delays)), sharex=True) as (figure, axes):
        for ax, (name, values) in zip(axes[:, 0], delays.items(), strict=True):
            detections = values[np.isfinite(values)] + waited
            # Each bar covers a whole number of samples, the same number in each bar.
            width = 1e3 * max(1, round(0.0005 * rate)) / rate
            reach = np.ceil(EDGE / width - 0.5) + 0.5
            bins = width * np.arange(-reach, reach + 1)
            ax.hist(
                np.clip(detections, bins[0], bins[-1]), bins=bins, color=names.detector(name).colour
            )
            ax.axvline(0, color=INK, lw=1, ls="--")
            n_early = int((detections < -EDGE).sum())
            missed = int(sum(p.first is not None for p in dataset.pinches) - len(detections))
            ax.set_title(names.detector(name).title)
            ax.text(
                0.05,
                0.93,
                f"{n_early:,} earlier than −{EDGE:g} ms\n{missed:,} never",
                transform=ax.transAxes,
                va="top",
                fontsize=8,
            )
            ax.set_ylabel("Pinches")
            ax.grid(axis="x", visible=False)
        axes[-1, 0].set_xlabel(f"First decision after the {zero} (ms)")
        axes[-1, 0].set_xlim(-EDGE - 1, EDGE + 1)
        image = uri(figure)
    return Figure(
        "delays",
        "Time of the first detection",
        f"Decisions left of the line ({zero}) came too early{late}. The outermost bars contain all "
        f"decisions beyond the axis.{counted}",
        image,
    )


def _describe_folds(splits: Sequence[Split]) -> DetectionFolds:
    shares = sorted(set().union(*(s.shares for s in splits)))
    held_out = "pinches" if Group.SESSION in shares else "sessions"
    return DetectionFolds(n=len(splits), held_out=held_out, shares=[str(s) for s in shares])


CONTACT: Field[ContactResults] = Field("contact", ContactResults, ByName({}, ContactConditions()))
#: Accuracy of detection (section IV of the paper). The paper does not define what is counted.
PUBLISHED = {"three_sigma": 0.906, "svm": 1.0}


def window_starts(subjects: Subjects) -> list[str]:
    """Return the names of the detectors whose contacts start the studied windows.

    The name "known" means true contacts.
    """
    starts = (results[CONTACT].about.windows_start_at for results in subjects.values())
    return distinct(start for start in starts if start is not None)


def is_learned(results: SubjectResults) -> bool:
    """Return True if windows start at the contacts of a trained detector."""
    return names.is_trained_detector(results[CONTACT].about.windows_start_at)


def _start_text(start: str) -> str:
    if start not in DETECTORS:
        return "No detector could be trained: windows start at the known contacts."
    title = names.detector(start).title
    kind = (
        "trained on other pinches"
        if names.is_trained_detector(start)
        else "which needs no training"
    )
    return f"Windows for stiffness start at contacts of the {title} detector, {kind}."


def _text(subjects: Subjects) -> str:
    return " ".join(
        ["Detectors decide on windows of 20 ms.", *map(_start_text, window_starts(subjects))]
    )


def detector_rows(accepted: Accepted) -> list[Row[DetectionScores]]:
    suffix = " after its label" if accepted.early else ""
    return [
        Row("windows right", lambda s: s.window_accuracy, "share"),
        Row("contact windows found", lambda s: s.contact_windows_found, "share"),
        Row(f"placed {accepted.placed}", lambda s: s.pinch_success, "share"),
        Row(f"and decided {accepted.decided}", lambda s: s.decided_within_3_ms, "share"),
        Row("false alarms a minute", lambda s: s.false_alarms_per_minute, "rate"),
        Row(f"median delay of the decision{suffix}", lambda s: s.median_delay, "ms"),
    ]


_DETAILS: Sequence[Row[DetectionScores]] = (
    Row("95th percentile of the delay", lambda s: s.delay_ms.p95 if s.delay_ms else None, "ms"),
    Row("pinches: steady state not yet known", lambda s: s.too_soon),
    Row("pinches: placed too early", lambda s: s.false_alarms),
    Row("pinches: wrong finger", lambda s: s.wrong_finger),
    Row("pinches: placed too late", lambda s: s.late),
    Row("pinches: never", lambda s: s.misses),
)


def contact_table(results: SubjectResults, *, details: bool = False) -> Table | None:
    detectors = {
        names.detector(name).title: results[CONTACT][name]
        for name in names.detectors(results[CONTACT])
    }
    if not detectors:
        return None
    rows = _DETAILS if details else detector_rows(Accepted.from_results({"": results}))
    return row_table(rows, detectors, _caption(results, next(iter(detectors.values()))))


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
        first, *further = detector_rows(accepted)

        def find(results: SubjectResults, name: str = name) -> DetectionScores | None:
            return results[CONTACT].get(name)

        def silence(results: SubjectResults, name: str = name) -> str:
            scores = results[CONTACT].get(name)
            if scores is None or not scores.windows:
                return ""
            return f"a detector that never fires: {percent(scores.quiet_windows / scores.windows)}"

        if published is None:
            rows.append(row_for_results(first, prefix, find))
        else:
            claim = Claim(published, SHARE_TOLERANCE)
            text = percent(published)
            rows.append(row_for_results(first, prefix, find, text, claim=claim, note=silence))
        rows += [row_for_results(row, prefix, find) for row in further]
    return rows


PART = Part(
    "contact",
    "Contact detection",
    [Step("contact detection", contacts, cost=25)],
    _text,
    [contact_table, lambda results: contact_table(results, details=True)],
    _rows,
    needs=("data",),
)
