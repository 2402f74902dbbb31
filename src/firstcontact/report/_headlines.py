"""Headlines of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firstcontact.contact.registry import DETECTORS
from firstcontact.report import _published as published
from firstcontact.report import names
from firstcontact.report.accepted import Accepted
from firstcontact.report.comparison import get, percent
from firstcontact.report.findings import Findings
from firstcontact.stiffness.registry import ESTIMATORS

Tree = Mapping[str, Any]


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


def _lines(
    shown: Sequence[Findings], path: str, text: Any, note: Any = lambda value: ""
) -> list[Line]:
    out = []
    for findings in shown:
        value = get(findings.tree, path)
        said = None if value is None else text(value)
        if said is not None:
            out.append(Line(findings.title, said, note(value)))
    return out


def _by_model(
    shown: Sequence[Findings], path: str, text: Any, note: Any = lambda value: ""
) -> list[Line]:
    """A line for each subject and published model, whichever scored better; or for all others."""
    out = []
    for findings in shown:
        above, _, below = path.partition("{}")
        found = names.estimators(get(findings.tree, above.strip(".")) or ())
        for model in [name for name in found if name in published.OBJECT_ERROR] or found:
            title = names.estimator(model).title
            for line in _lines([findings], f"{above}{model}{below}", text, note):
                name = f"{title}, {line.name}" if len(shown) > 1 else title
                out.append(Line(name, line.value, line.note))
    return out


def _contact_headline(shown: Sequence[Findings]) -> Headline:
    accepted = Accepted.of([f.tree for f in shown])

    def note(svm: Tree) -> str:
        said = []
        if "decided_within_3_ms" in svm:
            said.append(f"decided {accepted.decided} in {percent(svm['decided_within_3_ms'])}")
        delay = get(svm, "delay_ms.median")
        if delay is not None:
            after = " after its label" if accepted.early else ""
            said.append(f"median delay{after} {delay:.1f} ms")
        return ", ".join(said)

    by = next((str(b) for f in shown if (b := get(f.tree, "contact.not_found.by"))), "")
    by = by or DETECTORS.default
    return Headline(
        f"First contacts placed, {names.detector(by).title}",
        _lines(shown, f"contact.{by}", lambda s: percent(s["pinch_success"]), note),
        f"of pinches: right finger, contact placed {accepted.placed_fully}, nothing before it",
    )


def _answer_headline(shown: Sequence[Findings]) -> Headline:
    twin = any(get(f.tree, "data.source") == "twin" for f in shown)
    known = [f for f in shown if get(f.tree, "answer_ms.before_second") is not None]
    return Headline(
        "Answers before the second contact",
        _lines(
            known,
            "answer_ms",
            lambda a: percent(a["before_second"]),
            lambda a: f"median {a['median']:.1f} ms after the first" if "median" in a else "",
        ),
        "of pinches with a known second contact; 15 ms window, waits and look-aheads counted, "
        "without the estimate's own arithmetic" + (", twin" if twin else ""),
    )


def _ends(scores: Tree, key: str) -> str:
    ends = get(scores, f"intervals.{key}")
    return _whole(f"95 %: {ends[0]:.1f} to {ends[1]:.1f}") if ends else ""


def _accuracy_ends(scores: Tree) -> str:
    ends = get(scores, "intervals.accuracy") or ()
    shown = " to ".join(percent(end).removesuffix(" %") for end in ends)
    return _whole(f"95 %: {shown}") if shown else ""


def _whole(text: str) -> str:
    """The text with spaces that no line breaks at."""
    return text.replace(" ", "\N{NO-BREAK SPACE}")


def _accuracy_headline(shown: Sequence[Findings]) -> Headline:
    classes = [
        found
        for f in shown
        for model in names.estimators(get(f.tree, "blocks") or ())
        if (found := get(f.tree, f"blocks.{model}.by_session.classes"))
    ]
    return Headline(
        f"{len(classes[0])} levels of stiffness told apart" if classes else "",
        _by_model(
            shown,
            "blocks.{}.by_session",
            lambda s: percent(s["accuracy"]) if "accuracy" in s else None,
            _accuracy_ends,
        ),
        "accuracy in sessions that were not learned from",
    )


def _object_headline(shown: Sequence[Findings]) -> Headline:
    floors = [
        f"{floor:.1f}"
        for f in shown
        if (floor := get(f.tree, "objects.train_mean.rmse")) is not None
    ]
    beside = (
        f"; answering the mean always gives {' and '.join(dict.fromkeys(floors))}" if floors else ""
    )
    return Headline(
        "Unseen objects",
        _by_model(
            shown,
            "objects.{}",
            lambda s: f"{s['rmse']:.1f} Shore A",
            lambda s: _ends(s, "rmse"),
        ),
        f"RMSE per pinch{beside}",
    )


def _order_headline(shown: Sequence[Findings]) -> Headline:
    return Headline(
        "Order of hardness, nothing learned",
        _lines(
            shown,
            "hardness_order.spectral_centroid",
            lambda s: f"ρ = {s['rho']:.2f}".replace("-", "−") if "rho" in s else "–",
            lambda s: f"n = {s['n']}, p = {s['p']:.3f}" if "p" in s else f"n = {s['n']}",
        ),
        "Spearman over materials, first 15 ms",
    )


def _material_headline(shown: Sequence[Findings]) -> Headline:
    chance = get(shown[0].tree, "hardness_order.chance") if shown else None
    return Headline(
        "Class of a material never learned",
        _lines(
            shown,
            f"hardness_order.leave_one_material_out.classification.{ESTIMATORS.default}",
            lambda s: percent(s["accuracy"]) if "accuracy" in s else None,
            _accuracy_ends,
        ),
        "" if chance is None else f"accuracy; chance is {percent(chance)}",
    )


def _time_headline(shown: Sequence[Findings]) -> Headline:
    return Headline(
        "One estimate takes (p99)",
        _by_model(
            shown,
            "inference_us.{}",
            lambda e: f"{e['p99']:.0f} µs",
            lambda e: (
                f"{e['speedup']:.1f} × quicker than {e['reference']}" if "speedup" in e else ""
            ),
        ),
        f"regression, one window at a time, one thread, this machine{_apart(shown)}",
    )


def _quicker(entry: Tree) -> str:
    if "speedup" not in entry:
        return ""
    return f"{entry['speedup']:.1f} × quicker than {entry['reference']}"


def _apart(shown: Sequence[Findings]) -> str:
    """Calls that another process interrupted, and how busy the machine was."""
    trees = [tree for f in shown for tree in (get(f.tree, "inference_us") or {}).values()]
    entries = [tree for tree in trees if "load" in tree]
    if not entries:
        return ""
    busy = max(float(entry["load"]) for entry in entries)
    preempted = sum(entry["preempted"] for entry in entries)
    calls = sum(entry["calls"] for entry in entries)
    apart = f"; {preempted:,} of {calls:,} calls were preempted and are apart" if preempted else ""
    return f" (load {busy:.1f} on {entries[0]['cores']} cores){apart}"
