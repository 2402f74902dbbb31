"""Study part ``stiffness``: errors of a predicted stiffness or modulus over time.

The predictions are for held-out sessions, by time after the contact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from firstcontact.contact.detector_file import pretrained_detector
from firstcontact.core import Contact, Dataset, Record
from firstcontact.core.display import GREY, INK
from firstcontact.core.quantity import PHYSICAL, QUANTITIES, SHORE_A, Quantity
from firstcontact.core.text import percent
from firstcontact.jobs import Runner
from firstcontact.models import Task, Touches
from firstcontact.models.alignment import TOLERANCE, detect_alignment
from firstcontact.models.interval import held_out_coverage
from firstcontact.models.labelled_data import LabelledWindows, labelled_windows
from firstcontact.models.scores import RegressionScores, regression_scores
from firstcontact.models.splits import Group, Split, leave_one_out
from firstcontact.models.training import Question, held_out
from firstcontact.models.values import Values
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import banded_line, canvas, uri
from firstcontact_lab.report.tables import ABSENT, Cell, Line, Table
from firstcontact_lab.study.detection import trigger_delays
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject
from firstcontact_lab.study.scores import learns_one_value

#: Estimators that are scored, yardsticks last.
SCORED = ("svm", "log_spectrum", "peak", "train_mean")
#: Nominal coverage of the intervals.
LEVEL = 0.9


class Placed(Record, frozen=True, kw_only=True):
    """Distances of contacts from their labels, for the package's detector.

    The detector was not trained on these recordings.
    """

    pinches: int
    found: int
    #: Contacts within 3 ms of their labels.
    placed: int
    #: Median time from the label to the contact, and to the decision, ms.
    contact_ms: float
    decision_ms: float


class TimedScores(Record, frozen=True, kw_only=True):
    """Scores of one estimator with one length of signal, over held-out sessions."""

    errors: RegressionScores
    #: Root mean square error in the unit.
    rmse_in_unit: float
    #: Share of intervals from other sessions that hold the truth, and their mean width.
    coverage: float | None = None
    width: float | None = None


class LevelLeftOut(Record, frozen=True, kw_only=True):
    """Mean prediction for pinches whose stiffness was left out of training, by time in ms."""

    predicted: dict[str, float]


class StiffnessResults(Record, frozen=True, kw_only=True):
    """Errors of one predicted quantity, by time in ms and estimator.

    Errors of a logarithmic quantity are those of its natural logarithm.
    """

    quantity: str
    pinches: int
    sessions: int
    placed: Placed | None = None
    by_time: dict[str, dict[str, TimedScores]]
    levels_left_out: dict[str, dict[str, LevelLeftOut]]

    def relative_error(self, ms: str, estimator: str) -> float:
        """Return the RMSE of an estimator, divided by the RMSE of always predicting the mean."""
        scores = self.by_time[ms]
        return scores[estimator].errors.rmse / scores["train_mean"].errors.rmse


def stiffness(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    quantity = subject.dataset.quantity
    if quantity not in PHYSICAL or quantity is SHORE_A:
        return PartResult()
    contacts = detect_alignment(subject.dataset, pretrained_detector()).contacts
    lengths = (5, 15) if settings.brief else Touches.SCORED_MS
    found, reason = score_by_time(
        subject.dataset, quantity, contacts, SCORED, lengths, settings.seed, runner
    )
    if found is None:
        return missing(f"{quantity.axis}: {reason}")
    return PartResult([STIFFNESS(found)], [time_figure({subject.name: found})])


def score_by_time(
    dataset: Dataset,
    quantity: Quantity,
    contacts: Sequence[Contact | None],
    estimators: Sequence[str],
    lengths: Sequence[int],
    seed: int,
    runner: Runner,
    *,
    with_levels: bool = True,
) -> tuple[StiffnessResults | None, str]:
    """Score estimators on held-out sessions, and on left-out values of the quantity.

    Return (results, ""), or (None, reason) if the pinches do not permit this. The smallest and the
    largest value are never left out. ``lengths`` are the signal lengths, ms.
    """
    target = quantity.scaled(
        dataset.shore_a if quantity is SHORE_A else dataset.label_values(quantity)
    )
    cuts = {ms: labelled_windows(dataset, contacts, 1e-3 * ms, target) for ms in lengths}
    cuts = {ms: cut.take(~cut.test) for ms, cut in cuts.items()}
    whole = cuts[max(lengths)]
    if not whole.has_sessions:
        return None, "the windows are not from two or more named sessions."
    questions: dict[tuple[str, str, str], Question] = {}
    for ms, data in cuts.items():
        sessions = _session_splits(data)
        if learns_one_value(sessions, data.y):
            return None, "with a session held out, a single level is left to learn from."
        inner = np.unique(data.y)[1:-1]
        levels = [s for s in leave_one_out(data.y) if data.y[s.test[0]] in inner]
        for name in estimators:
            questions[str(ms), name, "sessions"] = Question(name, Task.REGRESSION, data, sessions)
            if with_levels and levels and not names.is_baseline(name):
                questions[str(ms), name, "levels"] = Question(name, Task.REGRESSION, data, levels)
    answers = dict(zip(questions, held_out(runner, list(questions.values()), seed), strict=True))
    by_time: dict[str, dict[str, TimedScores]] = {}
    left_out: dict[str, dict[str, dict[str, float]]] = {}
    for (time, name, kind), predicted in answers.items():
        data = questions[time, name, kind].data
        if kind == "sessions":
            by_time.setdefault(time, {})[name] = _timed_scores(data, predicted, quantity, seed)
            continue
        for level in np.unique(data.y[np.isfinite(predicted)]):
            label = f"{float(quantity.restored(level)):.4g}"
            mean = float(quantity.restored(predicted[data.y == level].mean()))
            left_out.setdefault(label, {}).setdefault(name, {})[time] = mean
    return StiffnessResults(
        quantity=quantity.name,
        pinches=len(whole),
        sessions=len(np.unique(whole.sessions)),
        placed=_contact_distances(dataset, contacts),
        by_time=by_time,
        levels_left_out={
            level: {name: LevelLeftOut(predicted=values) for name, values in models.items()}
            for level, models in left_out.items()
        },
    ), ""


def _session_splits(data: LabelledWindows) -> list[Split]:
    """Return splits that each hold out one session."""
    return leave_one_out(data.sessions, [Group.SPECIMEN])


def _timed_scores(
    data: LabelledWindows, predicted: Values, quantity: Quantity, seed: int
) -> TimedScores:
    folds = np.unique(data.sessions, return_inverse=True)[1]
    checked = held_out_coverage(predicted, data.y, folds, LEVEL, quantity.limits)
    truth, value = map(quantity.restored, (data.y, predicted))
    return TimedScores(
        errors=regression_scores(data.y, predicted, data.sessions, seed),
        rmse_in_unit=float(np.sqrt(np.mean((value - truth) ** 2))),
        coverage=checked.get("coverage"),
        width=checked.get("mean_width"),
    )


def _contact_distances(dataset: Dataset, contacts: Sequence[Contact | None]) -> Placed | None:
    """Return the distances of detected contacts from their labels, or None without labels."""
    places, delays = trigger_delays(dataset, contacts)
    is_found = np.isfinite(places)
    if not is_found.any():
        return None
    return Placed(
        pinches=sum(pinch.first is not None for pinch in dataset),
        found=int(is_found.sum()),
        placed=int((np.abs(places[is_found]) <= TOLERANCE).sum()),
        contact_ms=1e3 * float(np.median(places[is_found])),
        decision_ms=1e3 * float(np.median(delays[is_found])),
    )


STIFFNESS = Field.optional("stiffness", StiffnessResults)


def time_figure(
    results: Mapping[str, StiffnessResults], estimators: Sequence[str] = SCORED
) -> Figure:
    """Draw RMSE over time, as a share of the RMSE of always predicting the mean.

    Each dataset has its own line style.
    """
    with canvas(size=(6.6, 4.2)) as (figure, axes):
        ax = axes[0, 0]
        for (title, found), style in zip(results.items(), ("o-", "s--", "^:"), strict=False):
            times = [float(ms) for ms in found.by_time]
            scored = found.by_time[next(iter(found.by_time))]
            for name in (n for n in scored if n in estimators and n != "train_mean"):
                appearance = names.estimator(name)
                values = [found.relative_error(ms, name) for ms in found.by_time]
                colour = GREY if names.is_baseline(name) else appearance.colour
                label = f"{appearance.title}, {title.replace('_', ' ')}"
                banded_line(ax, times, values, [None], style, colour, label)
        ax.axhline(1.0, color=INK, ls=":", lw=1.2, label="always the mean")
        ax.set(
            xlabel="Time after the contact (ms)", ylabel="Error / error of the mean", ylim=(0, None)
        )
        figure.legend(loc="outside lower center", ncols=2)
        image = uri(figure)
    return Figure(
        "stiffness",
        "Error over the time after the contact",
        "Root mean square error with each session held out, relative to that of always predicting "
        "the mean. Errors of a stiffness or modulus are those of its logarithm.",
        image,
    )


def time_table(results: SubjectResults) -> Table | None:
    found = results[STIFFNESS]
    if found is None:
        return None
    quantity, lines = QUANTITIES[found.quantity], []
    for name in next(iter(found.by_time.values())):
        cells = []
        for scores in (scores[name] for scores in found.by_time.values()):
            ends = scores.errors.intervals.get("rmse", ())
            factors = " to ".join(quantity.error_words(end) for end in ends)
            text = f"{quantity.error_words(scores.errors.rmse)}; {scores.rmse_in_unit:.3g}"
            cells.append(Cell(text.replace("x", "×"), factors.replace("x", "×")))
        lines.append(Line([Cell(names.estimator(name).title), *cells], names.is_baseline(name)))
    caption = (
        f"RMSE of the {quantity.title} by time after the contact, as a factor, and in "
        f"{quantity.unit}. Each of {found.sessions} sessions was held out in turn."
    )
    if placed := found.placed:
        side = "before" if placed.contact_ms < 0 else "after"
        caption += (
            f" The package's detector found {placed.found} of {placed.pinches} contacts, "
            f"{placed.placed} within 3 ms of the label. Their median is "
            f"{abs(placed.contact_ms):.2g} ms {side} the label, and that of the decisions "
            f"{placed.decision_ms:.2g} ms after it."
        )
    return Table(caption, ["", *(f"{ms} ms" for ms in found.by_time)], lines)


def interval_table(results: SubjectResults) -> Table | None:
    found = results[STIFFNESS]
    if found is None:
        return None
    quantity, lines = QUANTITIES[found.quantity], []
    for name in (n for n in next(iter(found.by_time.values())) if not names.is_baseline(n)):
        cells = []
        for scores in (scores[name] for scores in found.by_time.values()):
            is_checked = scores.coverage is not None and scores.width is not None
            width = quantity.width_words(scores.width or 0.0).replace("x", "×")
            cells.append(
                Cell(percent(scores.coverage or 0.0), width) if is_checked else Cell(ABSENT)
            )
        lines.append(Line([Cell(names.estimator(name).title), *cells]))
    caption = (
        f"Share of {percent(LEVEL, 0)} intervals that hold the truth, and the ratio of their ends. "
        "Intervals were made from the other sessions. Their level holds if sessions are alike: a "
        "session that differs from all others, such as the fastest one, is held less often."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in found.by_time)], lines)


def level_table(results: SubjectResults) -> Table | None:
    found = results[STIFFNESS]
    if found is None or not found.levels_left_out:
        return None
    lines = [
        Line([
            Cell(f"{level} {QUANTITIES[found.quantity].unit}", names.estimator(name).title),
            *(Cell(f"{value:.3g}") for value in model.predicted.values()),
        ])
        for level, models in found.levels_left_out.items()
        for name, model in models.items()
    ]  # fmt: skip
    caption = "Mean prediction for a level that was left out of the training."
    return Table(caption, ["", *(f"{ms} ms" for ms in found.by_time)], lines)


TABLES = (time_table, interval_table, level_table)
PART = Part(
    "stiffness",
    "Stiffness in physical units",
    [Step("stiffness", stiffness, cost=10)],
    lambda subjects: (
        "The stiffness or modulus from the first milliseconds after the contact, at contacts of "
        "the package's detector, which learned from none of these recordings. Models learn and "
        "are scored on the logarithm, so that errors are factors. Each session is held out in turn."
    ),
    TABLES,
    needs=("data",),
)
