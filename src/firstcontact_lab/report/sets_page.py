"""The page of several sets of recordings: one file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterator

from firstcontact.contact import DETECTORS
from firstcontact.core import percent
from firstcontact.models import Delays
from firstcontact_lab.report._tables import Cell, Row, Table, shown_number
from firstcontact_lab.report.page import duration
from firstcontact_lab.report.results.real import SHOWN_MS
from firstcontact_lab.report.results.sets import SetResults, SetsResults
from firstcontact_lab.report.template import filled

_ABSENT = "–"
#: What a detector had learned from, in words.
_LEARNED = {
    "twin": "the twin, moved over",
    "others": "the set's other specimens",
    "nothing": "learns nothing",
}


def tables(results: SetsResults) -> list[Table]:
    """The sets side by side, every detector and training, and what each file gave."""
    its = [overview(results), trainings(results), finders(results)]
    return [*its, *([noises(results)] if results.noises else []), *_files(results)]


def overview(results: SetsResults) -> Table:
    """A row a set."""
    head = [
        *("set", "sensor", "rate", "front end", "contacts", "found within 2 ms", "early"),
        *("false alarms a minute", "delay", "order of hardness", "class, material left out"),
    ]
    rows = [Row([Cell(name), *_overview(its)]) for name, its in results.sets.items()]
    title = DETECTORS[DETECTORS.default].title
    caption = (
        f"Real sets. Contacts by the {title} detector, at the rate of the recordings; it learned "
        "from the set's other specimens where there are some. Early: contacts with a trigger more "
        "than 2 ms before the label. False alarms: on the set's noise. Delay: from the label to "
        "the decision, median; small: 95th percentile. Order: Spearman over materials of a score "
        "that nothing was fitted to. Class: balanced accuracy of the hardness class, and that of a "
        "constant prediction."
    )
    return Table(caption, head, rows)


def trainings(results: SetsResults) -> Table:
    """A row a set, detector and training."""
    head = [
        *("set, detector", "learned from", "contacts", "found within 2 ms", "early", "late"),
        *("missed", "false alarms a minute", "delay"),
    ]
    rows = [
        Row(
            [
                Cell(f"{name}, {DETECTORS[key].title if key in DETECTORS else key}"),
                Cell(_LEARNED.get(way, way)),
                *map(Cell, (f"{f.n:,}", percent(f.placed_2_ms))),
                *map(Cell, map(str, (f.early_triggers, f.late, f.missed))),
                Cell(_alarms(f.noise_false_alarms_per_minute)),
                _delay(f.delay_ms),
            ]
        )
        for name, its in results.sets.items()
        for key, ways in (its.detectors or {}).items()
        for way, f in ways.items()
    ]
    return Table("Every detector, by what it had learned from.", head, rows)


def finders(results: SetsResults) -> Table:
    """The onset finder, which may look ahead, beside labels and the detector."""
    rows = [
        Row(
            [
                Cell(name),
                Cell(percent(its.finder.placed_2_ms)),
                _delay(its.finder.from_label_ms),
                _delay(its.finder.from_detector_ms),
            ]
        )
        for name, its in results.sets.items()
        if its.finder
    ]
    caption = (
        "The onset finder that labelling starts from, which looks ahead: share of the labels with "
        "an onset within 2 ms, and how far onsets are from the label and from the detector's "
        "(median; small: 95th percentile)."
    )
    return Table(caption, ["set", "within 2 ms", "from the label", "from the detector"], rows)


def noises(results: SetsResults) -> Table:
    """A row a detector and noise under the twin's pinches."""
    head = [
        *("noise under the twin's pinches, detector", "pinches", "placed within 3 ms"),
        *("decided within 3 ms", "false alarms a minute", "delay"),
        *("15 ms: error, Shore A", "unseen objects"),
    ]
    rows = []
    for name, its in (results.noises or {}).items():
        for kind, d in its.detectors.items():
            reads = kind == DETECTORS.default
            rows.append(
                Row(
                    [
                        Cell(
                            f"{name.replace('_', ' ')}, "
                            f"{DETECTORS[kind].title if kind in DETECTORS else kind}"
                        ),
                        *map(Cell, (f"{d.n:,}", percent(d.pinch_success))),
                        Cell(percent(d.decided_within_3_ms)),
                        Cell(_alarms(d.false_alarms_per_minute)),
                        _delay(d.delay_ms),
                        *(
                            Cell(_ABSENT if value is None or not reads else f"{value:.1f}")
                            for value in (its.rmse, its.rmse_unseen)
                        ),
                    ]
                )
            )
    caption = (
        "Twin results: the same simulated pinches over the modelled electronics and over a real "
        "sensor's quiet, with the modelled motor on top. Detectors and the estimator learned from "
        "other pinches, of other rigs, over the modelled noise. Errors are RMSE, from the "
        "contacts that the default detector found."
    )
    return Table(caption, head, rows)


def render(results: SetsResults) -> str:
    """HTML."""
    return filled(
        "firstcontact_lab.report",
        "sets.html",
        results=results,
        tables=tables(results),
        elapsed=duration(results.seconds),
    )


def in_words(results: SetsResults) -> Iterator[str]:
    """The first table for a terminal, a line a number."""
    for name, its in results.sets.items():
        yield f"{name}:"
        for head, cell in zip(overview(results).head[1:], _overview(its), strict=True):
            yield f"  {head}: {cell.text}{f' ({cell.small})' if cell.small else ''}"


def _overview(its: SetResults) -> list[Cell]:
    held_out = its.class_held_out or {}
    lengths = [ms for ms in SHOWN_MS if ms in held_out]
    classes = " / ".join(percent(held_out[ms]) for ms in lengths)
    chance = "" if its.chance is None else f"; constant: {percent(its.chance)}"
    return [
        Cell(its.sensor),
        Cell(f"{its.rate_hz:g} Hz"),
        Cell(its.front_end),
        Cell(f"{its.n:,}", f"of {its.pinches:,} recordings" if its.n < its.pinches else ""),
        Cell(
            _ABSENT if its.placed_2_ms is None else percent(its.placed_2_ms),
            f"label up to {its.early_ms:g} ms late" if its.early_ms else "",
        ),
        Cell(_ABSENT if its.early_triggers is None else str(its.early_triggers)),
        Cell(
            _alarms(its.noise_false_alarms_per_minute),
            f"{its.noise_seconds:.0f} s" if its.noise_seconds else "",
        ),
        _delay(its.delay_ms),
        Cell(
            _ABSENT if its.order_rho is None else shown_number(its.order_rho, 2),
            "" if its.order_p is None else f"p = {its.order_p:.3f}",
        ),
        Cell(classes or _ABSENT, f"{' / '.join(lengths)} ms{chance}" if lengths else ""),
    ]


def _files(results: SetsResults) -> Iterator[Table]:
    for name, its in results.sets.items():
        if not its.files:
            continue
        rows = [
            Row(
                [
                    Cell(session),
                    Cell(f.front_end or _ABSENT),
                    Cell(str(f.n)),
                    Cell(percent(f.placed_2_ms)),
                    Cell(str(f.early_triggers)),
                    _delay(f.delay_ms),
                ]
            )
            for session, f in (its.files or {}).items()
        ]
        head = ["file", "front end", "contacts", "found within 2 ms", "early", "delay"]
        learned = _LEARNED.get(its.training or "", "")
        yield Table(f"{name}, file by file; learned from {learned}.", head, rows)


def _delay(delays: Delays | None) -> Cell:
    if delays is None:
        return Cell(_ABSENT)
    return Cell(f"{shown_number(delays.median, 2)} ms", f"{shown_number(delays.p95, 2)} ms")


def _alarms(a_minute: float | None) -> str:
    return _ABSENT if a_minute is None else f"{a_minute:.1f}"
