"""Tables of answers at any time, and of estimators off their blocks."""

from __future__ import annotations

from firstcontact.learning.scores import AnytimeScores
from firstcontact.report import names
from firstcontact.report._tables import Cell, Row, Table, shown_number
from firstcontact.report.comparison import percent
from firstcontact.report.results.anytime import TITLES, OffBlocks
from firstcontact.report.results.study import SubjectResults
from firstcontact.stiffness.registry import ESTIMATORS

_ASKED = {"objects": "unseen objects", "blocks": "blocks of other sessions"}
#: Scores off the blocks in the order of columns, and their heads.
_COLUMNS = {
    "objects": "Unseen objects",
    "three_pinches": "Three pinches",
    "other_hand": "Another hand",
    "level_left_out": "Level left out",
    "blocks": "Blocks",
    "accuracy": "Nearest level",
    "bias_softest": "Bias, softest",
    "bias_hardest": "Bias, hardest",
}


def anytime_table(results: SubjectResults) -> Table | None:
    """Error, coverage, width and share called strange at each time."""
    found = results.anytime
    if found is None:
        return None
    rows = _side(found, _ASKED[found.asked])
    if found.fixed is not None:
        title = names.estimator(found.fixed.estimator).title
        cells = [Cell("–")] * (len(found.rmse) - 1)
        last = Cell(shown_number(found.fixed.rmse, 2), _ends(found.fixed.intervals.get("rmse"), 1))
        rows.insert(1, Row([Cell(f"RMSE, {title}", "whole window"), *cells, last], True))
    if found.blocks is not None:
        rows += _side(found.blocks, _ASKED["blocks"])
    caption = f"{TITLES['in_context']}: by the time after contact."
    if found.before_second is not None:
        caption += (
            f" An answer before the second contact in {percent(found.before_second)} of "
            f"{found.with_second:,} pinches."
        )
    caption += (
        f" The rig is known by its blocks ({found.way}); {found.too_short} pinches whose second "
        "contact came before any answer are not scored."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in found.rmse)], rows)


def _side(scores: AnytimeScores, asked: str) -> list[Row]:
    def cells(key: str, digits: int) -> list[Cell]:
        ends = scores.intervals.get(key, {})
        values: dict[str, float] = getattr(scores, key)
        return [Cell(shown_number(v, digits), _ends(ends.get(ms), 1)) for ms, v in values.items()]

    held = scores.intervals.get("coverage", {})
    covered = [
        Cell(percent(v), ", ".join(percent(e).removesuffix(" %") for e in held.get(ms, ())))
        for ms, v in scores.coverage.items()
    ]
    of = f"{asked}, {scores.n:,} pinches"
    return [
        Row([Cell("RMSE, Shore A", of), *cells("rmse", 2)]),
        Row([Cell("Truth in its interval", of), *covered]),
        Row([Cell("Width of it, Shore A", of), *cells("width", 1)]),
        Row([Cell("Called strange", of), *(Cell(percent(v)) for v in scores.strange.values())]),
    ]


def generalise_table(results: SubjectResults) -> Table | None:
    """Every estimator off its blocks; below them the floor and what told ones would do."""
    found = results.generalise
    if found is None:
        return None
    usual = found.estimators.get(ESTIMATORS.default)
    rows = [
        _row(title_of(name), its, found.sets, usual if its is not usual else None)
        for name, its in found.estimators.items()
    ]
    rows.append(
        _row("Floor", found.floor, found.sets, small="learned from these kinds on this rig")
    )
    rows += [
        _row(f"Ceiling: {title_of(name)}", its, found.sets, quiet=True)
        for name, its in found.ceiling.items()
    ]
    caption = (
        f"Off the blocks: RMSE and bias in Shore A over {found.sets} rigs with their specimens "
        f"(seeds {found.seeds[0]} to {found.seeds[-1]}), one pinch; small: 95 % bootstrap interval "
        "over rigs, and the share of the default estimator's."
    )
    return Table(caption, ["", *_COLUMNS.values()], rows)


def title_of(name: str) -> str:
    """Of an estimator, or of a row that no registry knows."""
    return TITLES.get(name) or names.estimator(name).title


def _row(
    title: str,
    its: OffBlocks,
    sets: int,
    usual: OffBlocks | None = None,
    small: str = "",
    quiet: bool = False,
) -> Row:
    cells = []
    for key in _COLUMNS:
        score = its.bounded(key)
        if score is None:
            cells.append(Cell("–"))
        elif key == "accuracy":
            cells.append(Cell(percent(score.value)))
        else:
            sign = "+" if key.startswith("bias") else ""
            said = _ends(score.ends, 1)
            base = None if usual is None or sign else usual.bounded(key)
            if base is not None and base.value > 0:
                said += f" · {score.value / base.value:.2f}"
            cells.append(Cell(shown_number(score.value, 1, sign), said))
    if its.options:
        small = ", ".join(f"{key} {value}" for key, value in its.options.items())
    if its.sets < sets:
        small = f"{small}{', ' if small else ''}{its.sets} of {sets} rigs"
    return Row([Cell(title, small), *cells], quiet)


def _ends(ends: tuple[float, float] | None, digits: int) -> str:
    return ", ".join(shown_number(end, digits) for end in ends or ())
