"""Tables of contact detection and of the time to an answer, from ``results.json`` alone."""

from __future__ import annotations

from collections.abc import Callable

from firstcontact.contact import describe_starts
from firstcontact.core import percent
from firstcontact.models import DetectionScores
from firstcontact_lab.report import names
from firstcontact_lab.report._tables import Cell, Row, Table
from firstcontact_lab.report.accepted import Accepted
from firstcontact_lab.report.results.contact import DetectionFolds
from firstcontact_lab.report.results.study import SubjectResults


def contact_table(results: SubjectResults) -> Table | None:
    """All detectors, per window and per pinch."""
    detectors = names.detectors(results.contact)
    if not detectors:
        return None
    entries = [results.contact[name] for name in detectors]

    def row(
        label: str,
        value: Callable[[DetectionScores], float | None],
        form: str = "{:,}",
        small: str = "",
    ) -> Row:
        values = [value(scores) for scores in entries]
        cells = (Cell("–" if v is None else form.format(v)) for v in values)
        return Row([Cell(label, small), *cells])

    def shares(
        label: str, value: Callable[[DetectionScores], float | None], small: str = ""
    ) -> Row:
        values = [value(scores) for scores in entries]
        return Row([Cell(label, small), *(Cell("–" if v is None else percent(v)) for v in values)])

    accepted = Accepted.of([results])
    waited = entries[0].lookahead_ms
    counted = f"; {waited:.1f} ms of it is the resampler's look-ahead" if waited else ""
    rows = [
        shares("Windows right", lambda s: s.window_accuracy, "all 20 ms windows that were counted"),
        shares("Quiet windows silent", lambda s: s.quiet_windows_silent),
        shares("Contact windows found", lambda s: s.contact_windows_found),
        shares(
            f"Contact placed {accepted.placed}",
            lambda s: s.pinch_success,
            "share of pinches: first trigger on the right finger, placing the contact "
            f"{accepted.placed_fully}, nothing before it",
        ),
        shares(
            f"... and decided {accepted.decided}",
            lambda s: s.decided_within_3_ms,
            f"the same, and the trigger came {accepted.decided_fully}",
        ),
        row(
            "False alarms a minute",
            lambda s: s.false_alarms_per_minute,
            "{:,.2f}",
            "of closing without contact",
        ),
        row(
            f"Delay after {'its label' if accepted.early else 'contact'}, median",
            lambda s: s.median_delay,
            "{:.2f} ms",
            f"to the decision, over all first triggers on the right finger that are not early"
            f"{counted}",
        ),
        row(
            "Delay, 95th percentile",
            lambda s: s.delay_ms.p95 if s.delay_ms else None,
            "{:.2f} ms",
        ),
        row(
            "Pinches: contact too soon to be seen",
            lambda s: s.too_soon,
            small="before the motor had settled and its steady state was known; counted below, too",
        ),
        row("Pinches: placed too early", lambda s: s.false_alarms),
        row("Pinches: wrong finger", lambda s: s.wrong_finger),
        row("Pinches: placed too late", lambda s: s.late),
        row("Pinches: never", lambda s: s.misses),
    ]
    return Table(_caption(results), ["", *(names.detector(d).title for d in detectors)], rows)


def _caption(results: SubjectResults) -> str:
    about = results.contact.about
    folds = about.folds or DetectionFolds(n=1, held_out="sessions", shares=[])
    n = next(results.contact[name].n for name in names.detectors(results.contact))
    text = f"Out of fold: {folds.n} folds, whole {folds.held_out} held out; {n:,} pinches."
    if "specimen" in folds.shares:
        unseen = results.data and results.data.test_pinches
        text += " Specimens lie on both sides" + (", but for unseen objects." if unseen else ".")
    if ways := about.steady_state:
        words = describe_starts(ways)
        text += f" {words[0].upper()}{words[1:]}."
    if early := about.early_ms:
        text += (
            f" Labels may come up to {early:g} ms late: triggers and quiet windows are judged "
            "accordingly, and the delay after a label is shorter than after the contact."
        )
    return text


def answer_table(results: SubjectResults) -> Table | None:
    """When a window is complete after contact, and how often the other finger had not touched."""
    found = results.answer_ms
    if not found:
        return None
    lengths = sorted(found.window_length_ms.items(), key=lambda item: float(item[0]))
    both = any(its.before_second is not None for _, its in lengths)
    rows = []
    for ms, its in lengths:
        cells = [Cell(f"{ms} ms window", _arithmetic(results) if ms == "15" else "")]
        cells += [Cell("–" if v is None else f"{v:.2f} ms") for v in (its.median, its.p95)]
        if its.before_second is not None:
            cells.append(Cell(percent(its.before_second)))
        rows.append(Row([*cells, Cell(f"{its.n:,}", f"of {its.of:,}")]))
    caption = (
        f"From the {Accepted.of([results]).place} to a complete window: the decision waited for, "
        "the look-ahead of the filters counted. A pinch whose first trigger is missed, early or on "
        "the wrong finger has no answer"
    )
    if both:
        caption += (
            " and counts as not answered. Samples before the second contact leave out computing "
            "and transport."
        )
    else:
        caption += "."
    if results.twin:
        caption += " Twin results."
    head = ["", "Median", "p95", *(["Samples before second contact"] if both else []), "Answers"]
    return Table(caption, head, rows)


def _arithmetic(results: SubjectResults) -> str:
    """What the estimate itself adds, where it has been timed."""
    times = [
        f"{names.estimator(model).title} {1e-3 * time.p50:.2f} ms"
        for model, time in (results.inference_us or {}).items()
    ]
    return f"plus the estimate (p50): {', '.join(times)}" if times else ""
