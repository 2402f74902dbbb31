"""Headlines of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firstcontact.study.comparison import get, percent
from firstcontact.study.figures.style import NAMES
from firstcontact.study.state import Findings

Tree = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Line:
    """One value of a card."""

    name: str
    value: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class Card:
    """A headline."""

    title: str
    lines: Sequence[Line]
    foot: str


def cards(shown: Sequence[Findings]) -> list[Card]:
    """Headlines of what has been found so far."""
    all_ = [_contact_card(shown), _accuracy_card(shown), _object_card(shown)]
    all_ += [_order_card(shown), _material_card(shown), _time_card(shown)]
    return [card for card in all_ if card is not None and card.lines]


def _lines(
    shown: Sequence[Findings], path: str, text: Any, note: Any = lambda value: ""
) -> list[Line]:
    out = []
    for findings in shown:
        value = get(findings.tree, path)
        if value is not None:
            out.append(Line(NAMES.get(findings.name, findings.name), text(value), note(value)))
    return out


def _contact_card(shown: Sequence[Findings]) -> Card:
    def note(svm: Tree) -> str:
        delay = get(svm, "delay_ms.median")
        return "" if delay is None else f"median delay {delay:.1f} ms"

    return Card(
        "First contacts found, SVM",
        _lines(shown, "contact.svm", lambda s: percent(s["pinch_success"]), note),
        "of pinches: right finger, within ±3 ms, nothing before it",
    )


def _best(trees: Sequence[Tree], path: str, key: str, low: bool) -> str:
    """The model that a card shows: the better one on the first subject."""
    found = {m: get(trees[0], path.format(m) + f".{key}") for m in ("svm", "cnn")}
    found = {m: v for m, v in found.items() if v is not None}
    if not found:
        return "svm"
    return (min if low else max)(found, key=lambda m: found[m])


def _ends(scores: Tree, key: str, factor: float = 1.0, digits: int = 1) -> str:
    ends = get(scores, f"intervals.{key}")
    return f"95 %: {factor * ends[0]:.{digits}f} – {factor * ends[1]:.{digits}f}" if ends else ""


def _accuracy_card(shown: Sequence[Findings]) -> Card | None:
    if not shown:
        return None
    model = _best([f.tree for f in shown], "blocks.{}.by_session", "accuracy", low=False)
    levels = len(get(shown[0].tree, f"blocks.{model}.by_session.classes") or ())
    return Card(
        f"{levels} blocks told apart, {NAMES[model]}",
        _lines(
            shown,
            f"blocks.{model}.by_session",
            lambda s: percent(s["accuracy"]),
            lambda s: _ends(s, "accuracy", 100),
        ),
        "accuracy in sessions that were not learned from",
    )


def _object_card(shown: Sequence[Findings]) -> Card | None:
    if not shown:
        return None
    model = _best([f.tree for f in shown], "objects.{}", "rmse", low=True)
    floor = get(shown[0].tree, "objects.train_mean.rmse")
    beside = "" if floor is None else f"; answering the mean always gives {floor:.1f}"
    return Card(
        f"Unseen objects, {NAMES[model]}",
        _lines(
            shown,
            f"objects.{model}",
            lambda s: f"{s['rmse']:.1f} Shore A",
            lambda s: _ends(s, "rmse"),
        ),
        f"RMSE per pinch{beside}",
    )


def _order_card(shown: Sequence[Findings]) -> Card:
    return Card(
        "Order of hardness, nothing learned",
        _lines(
            shown,
            "hardness_order.spectral_centroid",
            lambda s: f"ρ = {s['rho']:.2f}".replace("-", "−") if "rho" in s else "–",
            lambda s: f"n = {s['n']}, p = {s['p']:.3f}" if "p" in s else f"n = {s['n']}",
        ),
        "Spearman over materials, first 15 ms",
    )


def _material_card(shown: Sequence[Findings]) -> Card:
    chance = get(shown[0].tree, "hardness_order.chance") if shown else None
    return Card(
        "Class of a material never learned",
        _lines(
            shown,
            "hardness_order.leave_one_material_out.classification.svm",
            lambda s: percent(s["accuracy"]),
            lambda s: _ends(s, "accuracy", 100),
        ),
        "" if chance is None else f"accuracy; chance is {percent(chance)}",
    )


def _time_card(shown: Sequence[Findings]) -> Card:
    found = get(shown[0].tree, "inference_us") if shown else None
    lines = [
        Line(NAMES[m], f"{e['p99']:.0f} µs", f"{e['speedup']:.1f} × quicker than {e['reference']}")
        for m, e in (found or {}).items()
    ]
    return Card("One estimate takes (p99)", lines, "one window at a time, one thread, this machine")
