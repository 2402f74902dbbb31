"""Published beside here, with a remark that the numbers themselves decide."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TypeVar

from firstcontact.core import percent
from firstcontact.models import DetectionScores, bounded
from firstcontact_lab.report import _published as published
from firstcontact_lab.report import names
from firstcontact_lab.report.accepted import Accepted
from firstcontact_lab.report.results.stiffness import BlockScores, ObjectScores, SplitScores
from firstcontact_lab.report.results.study import SubjectResults

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Compared:
    """A row of the table.

    Parameters
    ----------
    label
        What is compared.
    published
        As printed in the paper, "–" where it says nothing.
    here
        One text a subject, "–" where not known (yet).
    remark
        Where the two differ or cannot be compared.
    """

    label: str
    published: str
    here: Sequence[str]
    remark: str


def compare(found: Sequence[SubjectResults], subjects: Sequence[str], twin: bool) -> list[Compared]:
    """Rows for what is there; a row that no subject has is left out.

    Parameters
    ----------
    found
        What is known of each subject.
    subjects
        Names of the subjects, as they are written.
    twin
        Whether they are the twin's.
    """
    rows = [
        *_offset(found, twin),
        *_contact(found, subjects),
        *_answer(found),
        *_accuracy(found, subjects),
        *_objects(found, subjects),
        *_inference(found),
    ]
    return [row for row in rows if any(text != "–" for text in row.here)]


def _each(
    records: Sequence[R | None],
    value: Callable[[R], float | None],
    text: Callable[[float], str] = percent,
) -> list[str]:
    """A value of each record as text, "–" where it is not known."""
    values = [None if record is None else value(record) for record in records]
    return ["–" if v is None else text(v) for v in values]


def _milliseconds(value: float) -> str:
    return f"{value:.2f} ms"


def _offset(found: Sequence[SubjectResults], twin: bool) -> list[Compared]:
    source = (
        "The published value is an input of the twin, so agreement proves nothing."
        if twin
        else "Another hand or way of closing gives another distribution."
    )
    offsets = [results.offset_ms for results in found]
    return [
        Compared(
            "First to second contact, mean",
            _milliseconds(published.OFFSET_MEAN),
            _each(offsets, lambda its: its.mean, _milliseconds),
            source,
        ),
        Compared(
            "First to second contact, SD",
            _milliseconds(published.OFFSET_SD),
            _each(offsets, lambda its: its.sd, _milliseconds),
            source,
        ),
        Compared(
            "Second contact inside the 15 ms window",
            "–",
            _each(offsets, lambda its: its.share_below_15, lambda share: percent(share, 0)),
            "The paper gives mean and SD only.",
        ),
    ]


def _contact(found: Sequence[SubjectResults], subjects: Sequence[str]) -> list[Compared]:
    rows = []
    accepted = Accepted.of(found)
    after = " after its label" if accepted.early else ""
    for key, value in published.CONTACT.items():
        name = f"Contact, {names.detector(key).title}"
        scores = [results.contact.get(key) for results in found]
        target = _target_remark(key, scores, subjects, accepted)
        rows += [
            Compared(
                f"{name}: 20 ms windows judged right",
                percent(value),
                _each(scores, lambda its: its.window_accuracy),
                "The paper does not say what its accuracy counts; windows are the closest reading. "
                f"{_quiet_remark(scores, subjects)}".strip(),
            ),
            Compared(
                f"{name}: contact windows found",
                "–",
                _each(scores, lambda its: its.contact_windows_found),
                "The first that holds 1 ms of the contact, at most one a pinch. Missing it costs "
                "time, not the pinch: the next may find it.",
            ),
            Compared(
                f"{name}: contact placed {accepted.placed}",
                "–",
                _each(scores, lambda its: its.pinch_success),
                "Share of pinches. First trigger on the right finger, placing the contact "
                f"{accepted.placed_fully}, nothing before it. It is placed looking back, after "
                "the trigger.",
            ),
            Compared(
                f"{name}: and decided {accepted.decided}",
                "–",
                _each(scores, lambda its: its.decided_within_3_ms),
                f"The stricter count: the trigger itself comes {accepted.decided_fully}.",
            ),
            Compared(
                f"{name}: median delay of the decision{after}",
                "–",
                _each(scores, lambda its: its.median_delay, _milliseconds),
                f"All first triggers on the right finger that are not early. {target}".strip(),
            ),
        ]
    return rows


def _quiet_remark(scores: Sequence[DetectionScores | None], subjects: Sequence[str]) -> str:
    """What the accuracy over windows is worth: the score of a detector that never fires."""
    said = [
        f"{percent(its.quiet_windows / its.windows)} ({name})"
        for its, name in zip(scores, subjects, strict=True)
        if its is not None and its.windows
    ]
    if not said:
        return ""
    return (
        f"Share of quiet windows, which a detector that never fires has right: {', '.join(said)}."
    )


def _missed(scores: DetectionScores, target: published.Target) -> list[str]:
    """Which parts of a target are not reached."""
    windows, delay = scores.window_accuracy, scores.median_delay
    reached = {
        "windows": windows is not None and windows >= target.windows,
        "pinches": scores.pinch_success >= target.pinches,
        "delay": delay is not None and delay <= target.delay,
    }
    return [part for part, done in reached.items() if not done]


def _target_remark(
    detector: str,
    scores: Sequence[DetectionScores | None],
    subjects: Sequence[str],
    accepted: Accepted,
) -> str:
    """Whether a detector's target is reached, and where, of the subjects that have been judged."""
    target = published.TARGET.get(detector)
    if accepted.early or target is None:
        return ""  # what is counted here is less strict than the target
    said = []
    for its, name in zip(scores, subjects, strict=True):
        if its is not None:
            missed = _missed(its, target)
            words = f"not reached ({', '.join(missed)})" if missed else "reached"
            said.append(f"{name}: {words}")
    if not said:
        return ""
    return (
        f"Target of at least {percent(target.windows)} of windows, "
        f"{percent(target.pinches)} of pinches placed within ±3 ms, and a median delay of at "
        f"most {target.delay:g} ms: {'; '.join(said)}."
    )


def _answer(found: Sequence[SubjectResults]) -> list[Compared]:
    label = "Label of the first contact" if Accepted.of(found).early else "First contact"
    answers = [results.answer_ms for results in found]
    return [
        Compared(
            f"{label} to a complete 15 ms window, median",
            "–",
            _each(answers, lambda its: its.median, _milliseconds),
            "With the look-ahead of the filters and the wait for the decision, without the "
            "estimate's arithmetic.",
        ),
        Compared(
            "Samples for an answer before the second contact",
            "–",
            _each(answers, lambda its: its.before_second),
            "Of all pinches with a known second contact; missed, early and wrong-finger triggers "
            "count as not answered. Computing and transport are left out.",
        ),
        Compared(
            "– at any time",
            "–",
            _each([results.anytime for results in found], lambda its: its.before_second),
            "From 2 ms on, by the network that is told of the rig.",
        ),
    ]


def _accuracy(found: Sequence[SubjectResults], subjects: Sequence[str]) -> list[Compared]:
    rows = []
    for model, value in published.ACCURACY.items():
        title = names.estimator(model).title
        blocks = [results.blocks.get(model, BlockScores()) for results in found]
        random, session = [b.random_90_10 for b in blocks], [b.by_session for b in blocks]
        rows += [
            Compared(
                f"Blocks, {title}: accuracy, random 90/10",
                percent(value),
                list(map(_with_interval, random)),
                _interval_remark(random, subjects, value),
            ),
            Compared(
                f"Blocks, {title}: accuracy, by session",
                "–",
                list(map(_with_interval, session)),
                "Whole sessions held out, as a new session would be.",
            ),
        ]
    return rows


def _with_interval(scores: SplitScores | None) -> str:
    found = bounded(scores, "accuracy")
    if found is None:
        return "–"
    ends = ", ".join(percent(end).removesuffix(" %") for end in found.ends or ())
    return percent(found.value) + (f" [{ends}]" if ends else "")


def _interval_remark(
    scores: Sequence[SplitScores | None], subjects: Sequence[str], value: float
) -> str:
    """Where the published value lies, for each subject that has been judged."""
    said = []
    for its, name in zip(scores, subjects, strict=True):
        if its is not None and (ends := its.intervals.get("accuracy")):
            where = (
                "inside" if ends[0] <= value <= ends[1] else "above" if value > ends[1] else "below"
            )
            said.append(f"{where} that of {name} ({its.n:,} test pinches)")
    mixes = "The split does not look at sessions and specimens: they lie on both sides."
    if not said:
        return mixes
    return f"Of the 95 % intervals, the published value lies {' and '.join(said)}. {mixes}"


def _objects(found: Sequence[SubjectResults], subjects: Sequence[str]) -> list[Compared]:
    rows = []
    for model, value in published.OBJECT_ERROR.items():
        title = names.estimator(model).title
        scores = [results.objects.get(model) for results in found]
        errors: Sequence[tuple[str, str, Callable[[ObjectScores], float], str]] = (
            ("RMSE", "–", lambda its: its.rmse, _error_remark(value, scores, subjects)),
            ("MAE", "–", lambda its: its.mae, "Shore A. Not published."),
            ("MSE", f"{value} “MSE”", lambda its: its.mse, _MSE),
        )
        rows += [
            Compared(
                f"Unseen objects, {title}: {name}",
                paper,
                _each(scores, error, lambda v: f"{v:.2f}"),
                remark,
            )
            for name, paper, error, remark in errors
        ]
    return rows


_MSE = (
    "Shore A squared. The paper calls its number an MSE but gives it in Shore A: "
    "which was meant cannot be told, so compare with both."
)


def _error_remark(
    value: float, scores: Sequence[ObjectScores | None], subjects: Sequence[str]
) -> str:
    root = sqrt(value)
    said = []
    for its, name in zip(scores, subjects, strict=True):
        if its is not None:
            here = its.rmse
            verdict = "above both" if here > value else "below both" if here < root else "between"
            said.append(f"{name}: {verdict}")
    if not said:
        return "Shore A."
    return (
        f"Shore A. The published {value} would be an RMSE of {root:.2f} if it is an MSE, of "
        f"{value} if it is one already; {'; '.join(said)}."
    )


def _inference(found: Sequence[SubjectResults]) -> list[Compared]:
    return [
        Compared(
            f"One window, {names.estimator(model).title}: p99",
            f"{value} ms",
            _each(
                [(results.inference_us or {}).get(model) for results in found],
                lambda its: its.p99,
                lambda us: f"{1e-3 * us:.3f} ms",
            ),
            "Other computers: not comparable. The ratio to the training library on this one is. "
            "Without calls that another process interrupted.",
        )
        for model, value in published.INFERENCE.items()
    ]
