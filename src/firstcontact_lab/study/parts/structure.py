"""Study part ``structure``: scores on simulated rigs with other motors, noise and mechanics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector, detect
from firstcontact.contact.closing_start import cut_closings
from firstcontact.contact.contacts import first_contact
from firstcontact.contact.detector_file import is_pretrained, pretrained_detector
from firstcontact.core import Contact, Dataset, Record
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.jobs import Runner
from firstcontact.models import adapt, train
from firstcontact.models.alignment import fit_detector
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.scores import Ends, cluster_intervals
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Cell, Row, Table, bounded, matrix
from firstcontact_lab.study.detection_scores import outcome
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects
from firstcontact_lab.study.structures import (
    MOTORS,
    draw_blocks,
    draw_empty,
    draw_objects,
    draw_structured,
)

Values = NDArray[np.float64]
#: Number of rigs of each kind of motor, and numbers of pinches of each rig.
SEEDS, BLOCKS_EACH, OBJECTS, EMPTY = 3, 6, 40, 4
LEVELS = (20.0, 29.0, 43.0, 52.0, 60.0)
#: Length of empty closings, s, and length of the pieces in which contacts are searched, as long as
#: usual closings.
LASTS, HEARD = 3.0, 0.25
#: Time after the contact of the scored estimates, s.
AT = 0.005
#: Times of the estimates of the unconditioned model, s.
TIMES = (0.002, 0.003, 0.005, 0.008, 0.015)
OUTCOMES = ("success", "false_alarms", "late", "misses", "wrong_finger")


class StructureScores(Record, frozen=True, kw_only=True):
    placed: float
    early: float
    late: float
    missed: float
    false_alarms_per_minute: float
    rmse: float
    coverage: float
    combined: float
    combined_coverage: float
    gain: float
    predicted: float
    intervals: dict[str, Ends]


class Structures(Record, frozen=True, kw_only=True):
    rigs: int
    seeds: list[int]
    pinches: int
    detectors: dict[str, StructureScores]
    unknown_rig: dict[str, float]


@dataclass(slots=True, eq=False)
class Counts:
    """Counts of outcomes and false alarms, and squared errors, of one detector on one rig."""

    outcomes: dict[str, int] = field(default_factory=lambda: dict.fromkeys(OUTCOMES, 0))
    alarms: int = 0
    minutes: float = 0.0
    estimates: int = 0
    errors: list[float] = field(default_factory=list)

    def row(self) -> list[float]:
        counts = [self.outcomes[name] for name in OUTCOMES]
        counts[3] += counts.pop()
        return [sum(counts), *counts, self.alarms, self.minutes, self.estimates, *self.errors]


#: Columns of :meth:`Counts.row` as a score: numerator, denominator.
_RATIOS: Mapping[str, tuple[int, int]] = {
    "placed": (1, 0),
    "early": (2, 0),
    "late": (3, 0),
    "missed": (4, 0),
    "false_alarms_per_minute": (5, 6),
    "predicted": (7, 0),
    "rmse": (8, 7),
    "coverage": (9, 7),
    "combined": (10, 7),
    "combined_coverage": (11, 7),
}


def structure(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if subject.name != "paper-rig":
        return PartResult()
    seeds = list(range(1, 2 if settings.brief else 1 + SEEDS))
    places = [(motor, seed) for motor in MOTORS for seed in seeds]
    count = OBJECTS // 4 if settings.brief else OBJECTS
    judged = runner.map(_judge_rig, places, count)
    scores = {
        name: score_rigs(np.array([counts[name].row() for counts, _ in judged]), settings.seed)
        for name in judged[0][0]
    }
    unknown = np.array([errors for _, errors in judged]).sum(axis=0)
    results = Structures(
        rigs=len(places),
        seeds=seeds,
        pinches=count,
        detectors=scores,
        unknown_rig={
            f"{1e3 * at:g}": float(np.sqrt(total / n))
            for at, (total, n) in zip(TIMES, unknown, strict=True)
            if n
        },
    )
    return PartResult([STRUCTURE(results)])


def _judge_rig(
    place: tuple[str, int], count: int
) -> tuple[dict[str, Counts], list[tuple[float, float]]]:
    motor, seed = place
    rig = draw_structured(seed, motor)
    blocks = draw_blocks(rig, LEVELS, BLOCKS_EACH, 3)
    objects, empty = draw_objects(rig, count), draw_empty(rig, EMPTY, LASTS)
    combined = train(blocks, RigModel.COMBINED)
    models = (combined.only(RigModel.kind), combined)
    detectors = {"shipped": pretrained_detector(), "own": fit_detector(blocks)}
    chosen = "shipped" if is_pretrained(combined.own_detector) else "own"
    out = {}
    for name, detector in detectors.items():
        for confirm in (False, True):
            counts = Counts()
            contacts = _first_contacts(detector, objects, confirm=confirm)
            for pinch, contact in zip(objects, contacts, strict=True):
                assert pinch.first is not None
                counts.outcomes[outcome(contact, pinch.first, FINGERTIP_RATE, 0.0)] += 1
            for model in models:
                predictions = model.predict(objects, AT, contacts)
                squares, truth = _squared_errors(predictions.value, objects), objects.shore_a
                inside = (predictions.low <= truth) & (truth <= predictions.high)
                counts.errors += [float(squares.sum()), float(inside.sum())]
                counts.estimates = len(squares)
            counts.alarms, counts.minutes = count_alarms(detector, empty, confirm=confirm)
            out[name if confirm else f"{name}, all count"] = counts
    out |= {key.replace(chosen, "adapt"): out[key] for key in list(out) if key.startswith(chosen)}
    unknown = adapt()
    contacts = _first_contacts(detectors["shipped"], objects, confirm=True)
    errors = [
        _squared_errors(unknown.predict(objects, at, contacts).value, objects) for at in TIMES
    ]
    return out, [(float(e.sum()), float(len(e))) for e in errors]


def _first_contacts(detector: Detector, dataset: Dataset, *, confirm: bool) -> list[Contact | None]:
    pinches = cut_closings(dataset)
    if confirm:
        return [first_contact(detector, pinch) for pinch in pinches]
    return [next(iter(detect(detector, pinch, confirm=False)), None) for pinch in pinches]


def _squared_errors(values: Values, dataset: Dataset) -> Values:
    errors = values - dataset.shore_a
    return np.asarray(errors[np.isfinite(errors)] ** 2)


def count_alarms(detector: Detector, empty: Dataset, *, confirm: bool) -> tuple[int, float]:
    """Return (number of false contacts in closings on nothing, duration of these in minutes)."""
    part = round(HEARD * FINGERTIP_RATE)
    alarms, seconds = 0, 0.0
    for pinch in cut_closings(empty):
        for start in range(0, len(pinch.data) - part + 1, part):
            data = pinch.data[start : start + part]
            piece = replace(pinch, data=data, first_sample=start, motor_start=start)
            alarms += bool(detect(detector, piece, confirm=confirm))
            seconds += HEARD - 0.04  # nothing is detected in 40 ms, until the steady state is known
    return alarms, seconds / 60.0


def score_rigs(rows: Values, seed: int) -> StructureScores:
    def ratio(sums: Values, name: str) -> Values:
        above, below = _RATIOS[name]
        value = np.asarray(sums[..., above] / np.maximum(sums[..., below], 1e-9))
        return np.sqrt(value) if name in ("rmse", "combined") else value

    statistics: dict[str, Callable[[Values], Values]] = {
        name: partial(ratio, name=name) for name in _RATIOS
    }
    statistics["gain"] = lambda sums: ratio(sums, "combined") - ratio(sums, "rmse")
    intervals = cluster_intervals(rows, statistics, np.arange(len(rows)), seed)
    total = rows.sum(axis=0)
    return StructureScores(
        **{name: float(statistic(total)) for name, statistic in statistics.items()},
        intervals=intervals,
    )


STRUCTURE = Field.optional("structure", Structures)
_ROWS: Sequence[Row[StructureScores]] = (
    Row("placed within 3 ms", lambda s: bounded(s, "placed"), "share"),
    Row("too early", lambda s: bounded(s, "early"), "share"),
    Row("too late", lambda s: bounded(s, "late"), "share"),
    Row("missed", lambda s: bounded(s, "missed"), "share"),
    Row("false alarms a minute", lambda s: bounded(s, "false_alarms_per_minute"), "rate"),
    Row("5 ms: RMSE of the network, Shore A", lambda s: bounded(s, "rmse"), "shore"),
    Row("truths in its intervals", lambda s: bounded(s, "coverage"), "share"),
    Row("RMSE averaged with a regression, Shore A", lambda s: bounded(s, "combined"), "shore"),
    Row("truths in the intervals of that", lambda s: bounded(s, "combined_coverage"), "share"),
    Row("difference of both RMSE", lambda s: bounded(s, "gain"), "bias"),
    Row("pinches with an estimate", lambda s: bounded(s, "predicted"), "share"),
)
_NAMES = {
    "shipped": "Shipped detector",
    "own": "Detector from its own blocks",
    "adapt": "Detector that adapt takes",
}


def structure_table(results: SubjectResults) -> Table | None:
    structures = results[STRUCTURE]
    if structures is None:
        return None
    caption = (
        f"{structures.rigs} rigs with other motors, noise floors, start-ups, pads and sensors than "
        f"the twin, {structures.pinches} pinches of unseen objects each. After each "
        "value: its 95 % bootstrap interval over rigs."
    )
    columns = []
    for name, scores in structures.detectors.items():
        kind, comma, mode = name.partition(",")
        columns.append((Cell(_NAMES[kind] + comma + mode), scores, False))
    return matrix(caption, _ROWS, columns)


def unknown_table(results: SubjectResults) -> Table | None:
    structures = results[STRUCTURE]
    if structures is None:
        return None

    def time_row(ms: str) -> Row[Structures]:
        return Row(f"{ms} ms", lambda s: s.unknown_rig[ms], "shore")

    rows = [time_row(ms) for ms in structures.unknown_rig]
    caption = "RMSE in Shore A of the unconditioned model, by the time after the contact."
    return matrix(caption, rows, [(Cell("rig not known"), structures, False)])


def _text(subjects: Subjects) -> str:
    return (
        "Simulated hands whose motor, noise floor, start-up, pad and sensor follow other laws than "
        "the twin's. No model was trained on such hands. Their objects lose more energy, and their "
        "labels scatter by 2 Shore A. A first contact is withdrawn if the signal shows no push "
        "within 3 ms after it; the rows “all count” keep such contacts."
    )


PART = Part(
    "structure",
    "Rigs of another structure",
    [Step("rigs of another structure", structure, late=True, cost=60)],
    _text,
    [structure_table, unknown_table],
    needs=(),
    by_default=False,
)
