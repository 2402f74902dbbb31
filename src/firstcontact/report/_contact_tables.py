"""Tables of contact detection and of the time to an answer, from ``results.json`` alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firstcontact.contact.closing_start import told
from firstcontact.report import names
from firstcontact.report._tables import Cell, Row, Table
from firstcontact.report.accepted import Accepted
from firstcontact.report.comparison import get, percent

Tree = Mapping[str, Any]


def contact_table(tree: Tree) -> Table | None:
    """All detectors, per window and per pinch."""
    detectors = names.detectors(tree.get("contact", ()))
    if not detectors:
        return None
    entries = [tree["contact"][name] for name in detectors]

    def row(label: str, path: str, form: str, small: str = "") -> Row:
        values = [get(e, path) for e in entries]
        cells = (Cell("–" if v is None else form.format(v)) for v in values)
        return Row([Cell(label, small), *cells])

    def shares(label: str, path: str, small: str = "") -> Row:
        values = [get(e, path) for e in entries]
        return Row([Cell(label, small), *(Cell("–" if v is None else percent(v)) for v in values)])

    accepted = Accepted.of([tree])
    waited = entries[0].get("lookahead_ms")
    counted = f"; {waited:.1f} ms of it is the resampler's look-ahead" if waited else ""
    rows = [
        shares("Windows right", "window_accuracy", "all 20 ms windows that were counted"),
        shares("Quiet windows silent", "quiet_windows_silent"),
        shares("Contact windows found", "contact_windows_found"),
        shares(
            f"Contact placed {accepted.placed}",
            "pinch_success",
            "share of pinches: first trigger on the right finger, placing the contact "
            f"{accepted.placed_fully}, nothing before it",
        ),
        shares(
            f"... and decided {accepted.decided}",
            "decided_within_3_ms",
            f"the same, and the trigger came {accepted.decided_fully}",
        ),
        row(
            "False alarms a minute",
            "false_alarms_per_minute",
            "{:,.2f}",
            "of closing without contact",
        ),
        row(
            f"Delay after {'its label' if accepted.early else 'contact'}, median",
            "delay_ms.median",
            "{:.2f} ms",
            f"to the decision, over all first triggers on the right finger that are not early"
            f"{counted}",
        ),
        row("Delay, 95th percentile", "delay_ms.p95", "{:.2f} ms"),
        row(
            "Pinches: contact too soon to be seen",
            "too_soon",
            "{:,}",
            "before the motor had settled and its steady state was known; counted below, too",
        ),
        row("Pinches: placed too early", "false_alarms", "{:,}"),
        row("Pinches: wrong finger", "wrong_finger", "{:,}"),
        row("Pinches: placed too late", "late", "{:,}"),
        row("Pinches: never", "misses", "{:,}"),
    ]
    return Table(_caption(tree), ["", *(names.detector(d).title for d in detectors)], rows)


def _caption(tree: Tree) -> str:
    folds = tree["contact"].get("folds", {})
    n = next(tree["contact"][name]["n"] for name in names.detectors(tree["contact"]))
    text = (
        f"Out of fold: {folds.get('n', 1)} folds, whole {folds.get('held_out', 'sessions')} held "
        f"out; {n:,} pinches."
    )
    if "specimen" in folds.get("shares", ()):
        unseen = get(tree, "data.test_pinches")
        text += " Specimens lie on both sides" + (", but for unseen objects." if unseen else ".")
    if ways := tree["contact"].get("steady_state"):
        words = told(ways)
        text += f" {words[0].upper()}{words[1:]}."
    if early := tree["contact"].get("early_ms"):
        text += (
            f" Labels may come up to {early:g} ms late: triggers and quiet windows are judged "
            "accordingly, and the delay after a label is shorter than after the contact."
        )
    return text


def answer_table(tree: Tree) -> Table | None:
    """When a window is complete after contact, and how often the other finger had not touched."""
    found = get(tree, "answer_ms")
    if not found:
        return None
    lengths = sorted(found["window_length_ms"].items(), key=lambda item: float(item[0]))
    both = any("before_second" in entry for _, entry in lengths)
    rows = []
    for ms, entry in lengths:
        cells = [Cell(f"{ms} ms window", _arithmetic(tree) if ms == "15" else "")]
        cells += [Cell(f"{entry[k]:.2f} ms" if k in entry else "–") for k in ("median", "p95")]
        if both:
            cells.append(Cell(percent(entry["before_second"])))
        rows.append(Row([*cells, Cell(f"{entry['n']:,}", f"of {entry['of']:,}")]))
    caption = (
        f"From the {Accepted.of([tree]).place} to a complete window: the decision waited for, the "
        "look-ahead of the filters counted. A pinch whose first trigger is missed, early or on "
        "the wrong finger has no answer"
    )
    caption += " and counts as not answered before the second contact." if both else "."
    if get(tree, "data.source") == "twin":
        caption += " Twin results."
    head = ["", "Median", "p95", *(["Before second contact"] if both else []), "Answers"]
    return Table(caption, head, rows)


def _arithmetic(tree: Tree) -> str:
    """What the estimate itself adds, where it has been timed."""
    times = [
        f"{names.estimator(model).title} {1e-3 * entry['p50']:.2f} ms"
        for model, entry in (get(tree, "inference_us") or {}).items()
    ]
    return f"plus the estimate (p50): {', '.join(times)}" if times else ""
