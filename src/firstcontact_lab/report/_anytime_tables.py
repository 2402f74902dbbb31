"""Tables of answers at any time, and of estimators off their blocks."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import counted, percent
from firstcontact.models import ESTIMATORS, AnytimeScores, Ends
from firstcontact_lab.report import names
from firstcontact_lab.report._tables import Cell, Row, Table, shown_number
from firstcontact_lab.report.results.anytime import TITLES, Generalised, OffBlocks
from firstcontact_lab.report.results.study import SubjectResults

ABSENT = "–"
_ASKED = {"objects": "unseen objects", "blocks": "blocks of other sessions"}
#: Scores off the blocks in the order of columns, and their heads: a table each.
_OBJECTS = {
    "objects": "Unseen objects",
    "three_pinches": "Three pinches",
    "bias_softest": "Bias, softest",
    "bias_hardest": "Bias, hardest",
}
_OTHERS = {
    "other_hand": "Another hand",
    "level_left_out": "Level left out",
    "blocks": "Blocks",
    "accuracy": "Nearest level",
}


def anytime_table(results: SubjectResults) -> Table | None:
    """Error, coverage, width and share called strange at each time."""
    found = results.anytime
    if found is None:
        return None
    rows = _side(found, _ASKED[found.asked])
    if found.fixed is not None:
        title = names.estimator(found.fixed.estimator).title
        cells = [Cell(ABSENT)] * (len(found.rmse) - 1)
        last = Cell(
            shown_number(found.fixed.rmse, 2), shown_ends(found.fixed.intervals.get("rmse"), 1)
        )
        rows.insert(1, Row([Cell(f"RMSE, {title}", "whole window"), *cells, last], True))
    if found.blocks is not None:
        rows += _side(found.blocks, _ASKED["blocks"])
    caption = f"{TITLES['in_context']}: by the time after contact."
    if found.before_second is not None:
        caption += (
            f" The samples for an answer lie before the second contact in "
            f"{percent(found.before_second)} of {found.with_second:,} pinches; computing and "
            "transport are left out."
        )
    caption += (
        f" The rig is known by its blocks ({found.way}); "
        f"{counted(found.too_short, 'pinch')} whose "
        "second contact came before any answer "
        f"{'is' if found.too_short == 1 else 'are'} not scored."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in found.rmse)], rows)


def _side(scores: AnytimeScores, asked: str) -> list[Row]:
    def cells(key: str, digits: int) -> list[Cell]:
        ends = scores.intervals.get(key, {})
        values: dict[str, float] = getattr(scores, key)
        return [
            Cell(shown_number(v, digits), shown_ends(ends.get(ms), 1)) for ms, v in values.items()
        ]

    held = scores.intervals.get("coverage", {})
    covered = [Cell(percent(v), _shares(held.get(ms))) for ms, v in scores.coverage.items()]
    return [
        Row([Cell("RMSE, Shore A", f"{asked}, {counted(scores.n, 'pinch')}"), *cells("rmse", 2)]),
        Row([Cell("Truth in its interval", asked), *covered]),
        Row([Cell("Width of it, Shore A", asked), *cells("width", 1)]),
        Row([Cell("Called strange", asked), *(Cell(percent(v)) for v in scores.strange.values())]),
    ]


def objects_off_blocks(results: SubjectResults) -> Table | None:
    """Every estimator on objects that it has not met, the floor, and what told ones would do."""
    return _table(results.generalise, _OBJECTS, "Unseen objects: RMSE and bias")


def others_off_blocks(results: SubjectResults) -> Table | None:
    """The same with another hand, with a level left out, and on blocks of other sessions."""
    return _table(results.generalise, _OTHERS, "Other hands, levels and sessions: RMSE")


def _table(found: Generalised | None, columns: Mapping[str, str], title: str) -> Table | None:
    if found is None:
        return None
    rigs = "1 rig" if found.sets == 1 else f"{found.sets} rigs"
    seeds = ", ".join(map(str, found.seeds))
    default = names.estimator(ESTIMATORS.default).title
    caption = (
        f"{title} in Shore A over {rigs} (seeds {seeds}), one pinch. Small: 95 % bootstrap "
        f"interval over rigs; share of the error of {default}."
    )
    usual = found.estimators.get(ESTIMATORS.default)
    sides = [(title_of(name), its, "", False) for name, its in found.estimators.items()]
    sides.append(("Floor", found.floor, "learned from these kinds on this rig", False))
    sides += [(f"Ceiling: {title_of(name)}", its, "", True) for name, its in found.ceiling.items()]
    rows = []
    for name, its, small, quiet in sides:
        cells = [_cell(its, key, None if quiet or its is usual else usual) for key in columns]
        if any(cell.text != ABSENT for cell in cells):
            rows.append(Row([Cell(name, small or _about(its, found.sets)), *cells], quiet))
    return Table(caption, ["", *columns.values()], rows)


def title_of(name: str) -> str:
    """Of an estimator, or of a row that no registry knows."""
    return TITLES.get(name) or names.estimator(name).title


def _about(its: OffBlocks, sets: int) -> str:
    """How it learned, where that is not as usual."""
    said = [f"{key} {value}" for key, value in (its.options or {}).items()]
    if its.sets < sets:
        said.append(f"{its.sets} of {sets} rigs")
    return ", ".join(said)


def _cell(its: OffBlocks, key: str, usual: OffBlocks | None) -> Cell:
    score = its.bounded(key)
    if score is None:
        return Cell(ABSENT)
    if key == "accuracy":
        return Cell(percent(score.value), _shares(score.ends))
    said = [shown_ends(score.ends, 1)] if score.ends else []
    bias = key.startswith("bias")
    base = None if usual is None or bias or its.sets != usual.sets else usual.bounded(key)
    if base is not None and base.value > 0:
        said.append(f"× {score.value / base.value:.2f}")
    return Cell(shown_number(score.value, 1, "+" if bias else ""), "; ".join(said))


def _shares(ends: Ends | None) -> str:
    return ", ".join(percent(end).removesuffix(" %") for end in ends or ())


def shown_ends(ends: Ends | None, digits: int) -> str:
    """Format the ends of an interval, "" if there is none."""
    return ", ".join(shown_number(end, digits) for end in ends or ())
