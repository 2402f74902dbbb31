"""Tables of short windows, of materials that were left out."""

from __future__ import annotations

from firstcontact.core import counted, percent
from firstcontact_lab.report import names
from firstcontact_lab.report._tables import Cell, Row, Table
from firstcontact_lab.report.results.real import Reading, RealSet
from firstcontact_lab.report.results.study import SubjectResults


def way(reading: Reading) -> tuple[str, str]:
    """Title of a reading, and what its windows are."""
    signal = "behind the published smoothing" if reading.conditioned else "signal as sent"
    start = "labelled" if reading.known_contacts else "detected"
    return names.estimator(reading.estimator).title, f"{signal}, {start} contacts"


def short_table(results: SubjectResults) -> Table | None:
    """Balanced accuracy of each reading at each length, and the order of hardness."""
    found = _only(results)
    if found is None:
        return None
    lengths = list(found.material_held_out)
    rows = []
    for number, reading in enumerate(found.readings):
        cells = [Cell(percent(reading.material_held_out[ms])) for ms in lengths]
        rows.append(Row([Cell(*way(reading)), *cells, Cell(f"{reading.n:,}")], number > 0))
    caption = (
        f"Class of hardness, {found.materials} materials, each left out: balanced accuracy "
        f"(a constant prediction: {percent(found.chance)}) by length of the window. {_order(found)}"
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in lengths), "Pinches"], rows)


def materials_table(results: SubjectResults) -> Table | None:
    """Accuracy and centroid of each material, softest first."""
    found = _only(results)
    if found is None:
        return None
    lengths = list(found.material_held_out)
    rows = [
        Row(
            [
                Cell(material.replace("_", " "), f"rank {its.rank:g}, {counted(its.n, 'pinch')}"),
                *(Cell(percent(its.accuracy[ms]) if ms in its.accuracy else "–") for ms in lengths),
                Cell(f"{its.centroid_hz:.0f} Hz"),
                Cell(f"{its.conditioned_centroid_hz:.0f} Hz"),
            ]
        )
        for material, its in sorted(found.by_material.items(), key=lambda i: (i[1].rank, i[0]))
    ]
    head = ["", *(f"{ms} ms" for ms in lengths), "Centroid as sent", "behind smoothing"]
    title, windows = way(found.readings[0])
    return Table(f"Each material, left out: share classed right. {title}, {windows}.", head, rows)


def _only(results: SubjectResults) -> RealSet | None:
    return next(iter((results.real or {}).values()), None)


def _order(found: RealSet) -> str:
    """The order of hardness, in a sentence."""
    smooth = found.conditioned_order
    if found.rho is None or found.p is None or smooth.rho is None:
        return ""
    text = (
        f"Order of hardness by the {found.score.split(',')[0]}, nothing fitted: ρ = {found.rho:.2f}"
        f" (n = {found.materials}, p = {found.p:.3f}; a perfect order has {found.most_rho:.2f}, as "
        f"materials of one rank are ties) on the signal as sent, {smooth.rho:.2f} behind the "
        "published smoothing."
    )
    return text.replace("-", "−")
