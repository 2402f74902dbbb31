"""Headlines of the report."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from firstcontact.contact import DETECTORS
from firstcontact.core import percent
from firstcontact.models import ESTIMATORS, DetectionScores, Scores
from firstcontact_lab.report import _published as published
from firstcontact_lab.report import names
from firstcontact_lab.report.accepted import Accepted
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.results.real import SHOWN_MS, RealSet
from firstcontact_lab.report.results.stiffness import InferenceTimes
from firstcontact_lab.report.results.study import SubjectResults

R = TypeVar("R")
#: Largest share of preempted calls, and largest load for each core, with which times count. The
#: study's own workers make a load of one for each core in the minute before.
MOST_PREEMPTED = 0.01
MOST_LOAD = 2.0


@dataclass(frozen=True, slots=True)
class Line:
    """One value of a headline."""

    name: str
    value: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class Headline:
    """A headline."""

    title: str
    lines: Sequence[Line]
    foot: str


def headlines(shown: Sequence[Findings]) -> list[Headline]:
    """Headlines of what has been found so far."""
    all_ = [
        _contact_headline(shown),
        _answer_headline(shown),
        _accuracy_headline(shown),
        _object_headline(shown),
    ]
    all_ += [_order_headline(shown), _material_headline(shown), _time_headline(shown)]
    return [headline for headline in all_ if headline.lines]


def _line(
    name: str, record: R | None, text: Callable[[R], str | None], note: Callable[[R], str] | None
) -> list[Line]:
    if record is None or (said := text(record)) is None:
        return []
    return [Line(name, said, note(record) if note else "")]


def _lines(
    shown: Sequence[Findings],
    find: Callable[[SubjectResults], R | None],
    text: Callable[[R], str | None],
    note: Callable[[R], str] | None = None,
) -> list[Line]:
    return [line for f in shown for line in _line(f.title, find(f.results), text, note)]


def _by_model(
    shown: Sequence[Findings],
    find: Callable[[SubjectResults], Mapping[str, R | None]],
    text: Callable[[R], str | None],
    note: Callable[[R], str] | None = None,
) -> list[Line]:
    """A line for each subject and published model, whichever scored better; or for all others."""
    out = []
    for findings in shown:
        records = find(findings.results)
        found = names.estimators(records)
        for model in [name for name in found if name in published.OBJECT_ERROR] or found:
            title = names.estimator(model).title
            name = f"{title}, {findings.title}" if len(shown) > 1 else title
            out += _line(name, records[model], text, note)
    return out


def _contact_headline(shown: Sequence[Findings]) -> Headline:
    accepted = Accepted.of([f.results for f in shown])

    def note(scores: DetectionScores) -> str:
        said = f"decided {accepted.decided} in {percent(scores.decided_within_3_ms)}"
        if scores.median_delay is None:
            return said
        after = " after its label" if accepted.early else ""
        return f"{said}, median delay{after} {scores.median_delay:.1f} ms"

    placed = (f.results.contact.about.not_found for f in shown)
    by = next((its.by for its in placed if its), DETECTORS.default)
    return Headline(
        f"First contacts placed, {names.detector(by).title}",
        _lines(shown, lambda r: r.contact.get(by), lambda s: percent(s.pinch_success), note),
        f"of pinches: right finger, contact placed {accepted.placed_fully}, nothing before it",
    )


def _answer_headline(shown: Sequence[Findings]) -> Headline:
    twin = any(f.results.twin for f in shown)
    lines = []
    for f in shown:
        any_time = _line(
            f"{f.title}, at any time",
            f.results.anytime,
            lambda a: None if a.before_second is None else percent(a.before_second),
            lambda a: _whole(f"RMSE at 5 ms {a.rmse['5']:.1f}") if "5" in a.rmse else "",
        )
        lines += any_time
        lines += _line(
            f"{f.title}, 15 ms" if any_time else f.title,
            f.results.answer_ms,
            lambda a: None if a.before_second is None else percent(a.before_second),
            lambda a: "" if a.median is None else f"median {a.median:.1f} ms after the first",
        )
    return Headline(
        "Samples for an answer before the second contact",
        lines,
        "of pinches with a known second contact; waits and look-aheads counted, computing and "
        "transport left out, which live counts" + (", twin" if twin else ""),
    )


def _error_ends(scores: Scores) -> str:
    ends = scores.intervals.get("rmse")
    return _whole(f"95 %: {ends[0]:.1f} to {ends[1]:.1f}") if ends else ""


def _accuracy_ends(scores: Scores) -> str:
    ends = scores.intervals.get("accuracy", ())
    shown = " to ".join(percent(end).removesuffix(" %") for end in ends)
    return _whole(f"95 %: {shown}") if shown else ""


def _whole(text: str) -> str:
    """The text with spaces that no line breaks at."""
    return text.replace(" ", "\N{NO-BREAK SPACE}")


def _accuracy_headline(shown: Sequence[Findings]) -> Headline:
    classes = [
        its.classes
        for f in shown
        for model in names.estimators(f.results.blocks)
        if (its := f.results.blocks[model].by_session) and its.classes
    ]
    return Headline(
        f"{len(classes[0])} levels of stiffness told apart" if classes else "",
        _by_model(
            shown,
            lambda r: {model: scores.by_session for model, scores in r.blocks.items()},
            lambda s: None if s.accuracy is None else percent(s.accuracy),
            _accuracy_ends,
        ),
        "accuracy in sessions that were not learned from",
    )


def _object_headline(shown: Sequence[Findings]) -> Headline:
    floors = [
        f"{scores.rmse:.1f}" for f in shown if (scores := f.results.objects.get("train_mean"))
    ]
    beside = (
        f"; answering the mean always gives {' and '.join(dict.fromkeys(floors))}" if floors else ""
    )
    return Headline(
        "Unseen objects",
        _by_model(shown, lambda r: r.objects, lambda s: f"{s.rmse:.1f} Shore A", _error_ends),
        f"RMSE per pinch{beside}",
    )


def _order_headline(shown: Sequence[Findings]) -> Headline:
    return Headline(
        "Order of hardness, nothing learned",
        _lines(
            shown,
            lambda r: r.hardness_order.spectral_centroid if r.hardness_order else None,
            lambda s: "–" if s.rho is None else f"ρ = {s.rho:.2f}".replace("-", "−"),
            lambda s: f"n = {s.n}" if s.p is None else f"n = {s.n}, p = {s.p:.3f}",
        ),
        "Spearman over materials, first 15 ms",
    )


def _material_headline(shown: Sequence[Findings]) -> Headline:
    """The overview of all sets has the same number: balanced where there are short windows."""
    short = _lines(shown, _short, _balanced, lambda s: f"after {' / '.join(_lengths(s))} ms")
    if short:
        chances = dict.fromkeys(percent(r.chance) for f in shown if (r := _short(f.results)))
        return Headline(
            "Class of a material never learned",
            short,
            f"balanced accuracy; a constant prediction has {' and '.join(chances)}",
        )
    orders = [order for f in shown if (order := f.results.hardness_order)]
    scores = [s for o in orders if (s := o.classes_left_out().get(ESTIMATORS.default))]
    floors = dict.fromkeys(percent(s.best_constant) for s in scores)
    return Headline(
        "Class of a material never learned",
        _lines(
            shown,
            lambda r: (
                r.hardness_order.classes_left_out().get(ESTIMATORS.default)
                if r.hardness_order
                else None
            ),
            lambda s: percent(s.accuracy),
            _accuracy_ends,
        ),
        f"accuracy; the best constant prediction has {' and '.join(floors)}",
    )


def _short(results: SubjectResults) -> RealSet | None:
    return next(iter((results.real or {}).values()), None)


def _lengths(found: RealSet) -> list[str]:
    return [ms for ms in SHOWN_MS if ms in found.material_held_out]


def _balanced(found: RealSet) -> str:
    return " / ".join(percent(found.material_held_out[ms]) for ms in _lengths(found))


def _time_headline(shown: Sequence[Findings]) -> Headline:
    title = "One estimate takes (p99)"
    if busy := _busy(shown):
        remedy = "To measure again, run the study with another --out and nothing else beside it"
        return Headline(title, [Line("Machine too busy", "–", busy)], remedy)
    return Headline(
        title,
        _by_model(
            shown, lambda r: r.inference_us or {}, lambda time: f"{time.p99:.0f} µs", _quicker
        ),
        f"regression, one window at a time, one thread, this machine{_apart(shown)}",
    )


def _quicker(time: InferenceTimes) -> str:
    if time.speedup is None:
        return ""
    return f"{time.speedup:.1f} × quicker than {time.reference}"


def _times(shown: Sequence[Findings]) -> tuple[list[InferenceTimes], int, int]:
    """Times of all models, their preempted calls, and all their calls."""
    times = [time for f in shown for time in (f.results.inference_us or {}).values()]
    return times, sum(time.preempted for time in times), sum(time.calls for time in times)


def _busy(shown: Sequence[Findings]) -> str:
    """Return why the times are not this machine's own, "" where they are."""
    times, preempted, calls = _times(shown)
    if preempted > MOST_PREEMPTED * calls:
        return (
            f"{preempted:,} of {calls:,} calls were preempted: {percent(preempted / calls)}, and "
            f"at most {percent(MOST_PREEMPTED, 0)} may be"
        )
    busiest = max(times, key=lambda time: time.load / time.cores, default=None)
    if busiest is not None and busiest.load > MOST_LOAD * busiest.cores:
        most = MOST_LOAD * busiest.cores
        return f"load {busiest.load:.1f} on {busiest.cores} cores; at most {most:g} may be"
    return ""


def _apart(shown: Sequence[Findings]) -> str:
    """Calls that another process interrupted, and how busy the machine was."""
    times, preempted, calls = _times(shown)
    if not times:
        return ""
    busy = max(time.load for time in times)
    apart = f"; {preempted:,} of {calls:,} calls were preempted and are apart" if preempted else ""
    return f" (load {busy:.1f} on {times[0].cores} cores){apart}"
