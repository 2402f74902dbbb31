"""Time to act: from the contact to the estimate, on the board and on this machine."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.models import Task
from firstcontact_lab.report import names
from firstcontact_lab.report._tables import Cell, Row, Table
from firstcontact_lab.report.results.anytime import NETWORK_TITLES
from firstcontact_lab.report.results.board import BoardTime
from firstcontact_lab.report.results.study import SubjectResults

_CAPTION = (
    "Contact to estimate: the samples that it takes and the arithmetic, on the emulated Cortex-M7 "
    "(instructions counted by make embedded, 1.5 cycles each at 600 MHz assumed) and here (p99). "
    "Neither has the time until the contact is decided; here the cable and waiting for packets "
    "come on top, which firstcontact live measures. The any-time network: its first answer. Of "
    "models with several forms the cheapest and the dearest."
)


def board_table(results: SubjectResults) -> Table | None:
    """Samples, instructions and time of each form on the board; this machine beside it."""
    if not results.board:
        return None
    rows = [_row(results, form, time) for form, time in _ends(results.board).items()]
    heads = ["", "Samples", "Instructions", "On the board", "This machine, no cable"]
    return Table(_CAPTION, heads, rows)


def _ends(board: Mapping[str, BoardTime]) -> dict[str, BoardTime]:
    """The cheapest and the dearest form of each model, in the order of the file."""
    models: dict[tuple[str, str], list[str]] = {}
    for form, time in board.items():
        models.setdefault((time.estimator, time.task), []).append(form)
    shown = {
        end(forms, key=lambda form: board[form].instructions)
        for forms in models.values()
        for end in (min, max)
    }
    return {form: time for form, time in board.items() if form in shown}


def _row(results: SubjectResults, form: str, time: BoardTime) -> Row:
    usual = names.estimator(time.estimator).title
    title = NETWORK_TITLES.get(time.estimator, usual)
    if time.task == Task.CLASSIFICATION:
        title += ", classification"
    here = _p99_here(results, time)
    return Row(
        [
            Cell(title, form),
            Cell(f"{time.samples}", f"{time.signal_ms:.1f} ms"),
            Cell(f"{time.instructions:,}", f"{time.microseconds:.0f} µs"),
            Cell(f"{time.signal_ms + 1e-3 * time.microseconds:.2f} ms"),
            Cell("–" if here is None else f"{time.signal_ms + 1e-3 * here:.2f} ms"),
        ]
    )


def _p99_here(results: SubjectResults, time: BoardTime) -> float | None:
    """How long this machine takes for the whole model that a form was made from, us."""
    if time.estimator in NETWORK_TITLES:
        return None if results.anytime_us is None else results.anytime_us.p99
    found = (results.inference_us or {}).get(time.estimator)
    if found is not None and time.task == Task.CLASSIFICATION:
        its = found.classification
        return None if its is None else its.p99
    return None if found is None else found.p99
