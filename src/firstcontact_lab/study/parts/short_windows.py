"""Study part ``short_windows``: hardness classes from the first milliseconds.

The predicted materials are left out of training.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from firstcontact.core import Record
from firstcontact.core.display import BLUE, GREY, ORANGE, RED
from firstcontact.core.text import counted, percent
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Task, Touches
from firstcontact.models.labelled_data import DURATION, LabelledWindows
from firstcontact.models.registry import window_estimators
from firstcontact.models.splits import leave_one_out
from firstcontact.models.training import Question, held_out
from firstcontact.models.values import Values
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import ABSENT, Cell, Line, Row, Table, optional
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects, with_ranks
from firstcontact_lab.study.parts.contacts import is_learned
from firstcontact_lab.study.parts.hardness import SCORE, spectral_centroid
from firstcontact_lab.study.scores import RankCorrelation, never_learned, rank_correlation

#: Lengths of windows that headlines and overviews show, ms.
SHOWN_MS = ("3", "15")


class ReadingScores(Record, frozen=True, kw_only=True):
    """Scores of one estimator on one kind of windows.

    The kinds differ in smoothing, and in labelled or detected contacts.
    """

    estimator: str
    conditioned: bool
    known_contacts: bool
    n: int
    material_held_out: dict[str, float]

    @property
    def title(self) -> tuple[str, str]:
        """(title of the estimator, text that describes the windows)."""
        signal = "behind the published smoothing" if self.conditioned else "signal as sent"
        start = "labelled" if self.known_contacts else "detected"
        return names.estimator(self.estimator).title, f"{signal}, {start} contacts"


class RealMaterialScores(Record, frozen=True, kw_only=True):
    rank: float
    n: int
    accuracy: dict[str, float]
    centroid_hz: float
    conditioned_centroid_hz: float
    sessions: dict[str, dict[str, float]] | None = None


class ShortWindows(Record, frozen=True, kw_only=True):
    n: int
    materials: int
    material_held_out: dict[str, float]
    chance: float
    score: str
    rho: float | None = None
    p: float | None = None
    most_rho: float
    conditioned_order: RankCorrelation
    readings: list[ReadingScores]
    by_material: dict[str, RealMaterialScores]

    def worst(self, ms: str) -> tuple[str, float]:
        """Return (material with the lowest accuracy after ``ms`` ms, this accuracy)."""
        shares = {m: e.accuracy[ms] for m, e in self.by_material.items() if ms in e.accuracy}
        name = min(shares, key=lambda m: shares[m])
        return name, shares[name]


#: Lengths of windows of a brief study, ms.
BRIEF = (3, 15)


@dataclass(frozen=True, slots=True)
class _Variant:
    estimator: str
    conditioned: bool
    labelled: bool


def short_windows(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if not subject.has_known_contacts:
        return missing("Short windows of materials left out: no pinch has a known first contact.")
    ways = _variants(subject)
    full = {reading: _windows(subject, reading, DURATION) for reading in ways}
    data = full[ways[0]]
    if lacking := _shortage(data):
        return missing(f"Short windows of materials left out: {lacking}.")
    lengths = BRIEF if settings.brief else Touches.SCORED_MS
    questions = {
        (reading, ms): Question(
            reading.estimator,
            Task.CLASSIFICATION,
            windows := _windows(subject, reading, 1e-3 * ms),
            leave_one_out(windows.objects),
            settings.options(reading.estimator),
        )
        for reading in ways
        for ms in lengths
    }
    answers = held_out(runner, list(questions.values()), settings.seed)
    right = {
        key: _by_material(question.data, predicted)
        for (key, question), predicted in zip(questions.items(), answers, strict=True)
    }
    ranks = {str(m): float(data.y[data.objects == m][0]) for m in np.unique(data.objects)}
    readings = [
        ReadingScores(
            estimator=reading.estimator,
            conditioned=reading.conditioned,
            known_contacts=reading.labelled,
            n=len(full[reading]),
            material_held_out={str(ms): _balanced(right[reading, ms], ranks) for ms in lengths},
        )
        for reading in ways
    ]
    first_reading = {str(ms): right[ways[0], ms] for ms in lengths}
    by_session = {
        str(ms): _by_session(subject, question.data, predicted)
        for ((reading, ms), question), predicted in zip(questions.items(), answers, strict=True)
        if reading == ways[0]
    }
    real = _set(subject, data, readings, first_reading, by_session, ranks, settings.seed)
    return PartResult([REAL({subject.set_name: real})], [accuracy_figure(real)])


def _variants(subject: Subject) -> list[_Variant]:
    """Return all pairs of an estimator and a kind of windows to score, the main pair first."""
    moves = [
        n for n, e in window_estimators().items() if e.moves and Task.CLASSIFICATION in e.tasks
    ]
    first, *alternatives = moves or [ESTIMATORS.default]
    known_contacts = not subject.detections
    ways = [_Variant(first, False, known_contacts)]
    if subject.detections:
        ways.append(_Variant(first, False, True))
    ways += [_Variant(other, False, known_contacts) for other in alternatives]
    return [
        *ways,
        _Variant(first, True, known_contacts),
        _Variant(ESTIMATORS.default, True, known_contacts),
    ]


def _windows(subject: Subject, reading: _Variant, duration: float) -> LabelledWindows:
    """Return windows of ``duration`` s, labelled by the hardness rank of their material.

    Pinches of a material without a name or a rank are left out.
    """
    dataset = subject.dataset
    rank = np.where(dataset.objects != "", dataset.hardness_rank, np.nan)
    contacts = subject.truth if reading.labelled else subject.starts
    real = subject.labelled_windows(duration, rank, contacts, conditioned=reading.conditioned)
    return replace(real, sessions=real.objects, specimens=real.objects)


def _shortage(data: LabelledWindows) -> str:
    """Return the reason why there are too few windows to score, or "" if there are enough."""
    materials, ranks = np.unique(data.objects), np.unique(data.y)
    if len(ranks) < 2 or len(materials) < 4:
        return "fewer than two hardness ranks or four materials have a window"
    if any(len(np.unique(data.y[data.objects == m])) > 1 for m in materials):
        return "a material has two hardness ranks"
    unknown = never_learned(leave_one_out(data.objects), data.y)
    if len(unknown):
        return f"the ranks {', '.join(f'{r:g}' for r in unknown)} have one material each"
    return ""


def _by_material(data: LabelledWindows, predicted: Values) -> dict[str, float]:
    right = predicted == data.y
    return {str(m): float(right[data.objects == m].mean()) for m in np.unique(data.objects)}


def _by_session(
    subject: Subject, data: LabelledWindows, predicted: Values
) -> dict[tuple[str, str], float]:
    sessions, right = subject.dataset.sessions[data.rows], predicted == data.y
    out = {}
    for material in np.unique(data.objects):
        members = data.objects == material
        named = np.unique(sessions[members])
        for session in named if len(named) > 1 else ():
            share = right[members & (sessions == session)].mean()
            out[str(material), str(session)] = float(share)
    return out


def _balanced(right: dict[str, float], ranks: dict[str, float]) -> float:
    of_ranks: dict[float, list[float]] = {}
    for material, share in right.items():
        of_ranks.setdefault(ranks[material], []).append(share)
    return float(np.mean([np.mean(shares) for shares in of_ranks.values()]))


def _set(
    subject: Subject,
    data: LabelledWindows,
    readings: list[ReadingScores],
    right: dict[str, dict[str, float]],
    by_session: dict[str, dict[tuple[str, str], float]],
    ranks: dict[str, float],
    seed: int,
) -> ShortWindows:
    conditioned = _windows(subject, _Variant("", True, readings[0].known_contacts), DURATION)
    raw_hz, smooth_hz = _centroids(data), _centroids(conditioned)
    materials = [m for m in ranks if m in smooth_hz]
    order = np.array([ranks[m] for m in materials])

    def correlation(hertz: dict[str, float]) -> RankCorrelation:
        return rank_correlation(order, np.array([hertz[m] for m in materials]), seed)

    def sessions(material: str) -> dict[str, dict[str, float]] | None:
        out: dict[str, dict[str, float]] = {}
        for ms, shares in by_session.items():
            for (name, session), share in shares.items():
                if name == material:
                    out.setdefault(session, {})[ms] = share
        return out or None

    raw = correlation(raw_hz)
    return ShortWindows(
        n=len(data),
        materials=len(ranks),
        material_held_out=readings[0].material_held_out,
        chance=1.0 / len(set(ranks.values())),
        score=SCORE,
        rho=raw.rho,
        p=raw.p,
        most_rho=_highest_rho(order),
        conditioned_order=correlation(smooth_hz),
        readings=readings,
        by_material={
            m: RealMaterialScores(
                rank=ranks[m],
                n=int((data.objects == m).sum()),
                accuracy={ms: material[m] for ms, material in right.items() if m in material},
                centroid_hz=raw_hz[m],
                conditioned_centroid_hz=smooth_hz[m],
                sessions=sessions(m),
            )
            for m in materials
        },
    )


def _centroids(data: LabelledWindows) -> dict[str, float]:
    hertz = spectral_centroid(data.X, data.rate)
    return {str(m): float(hertz[data.objects == m].mean()) for m in np.unique(data.objects)}


def _highest_rho(order: Values) -> float:
    """Return the highest Spearman's rho that scores without ties can reach for these ranks."""
    from scipy.stats import spearmanr

    return float(spearmanr(np.sort(order), np.arange(len(order))).statistic)


def accuracy_figure(real: ShortWindows) -> Figure:
    lengths = [float(ms) for ms in real.material_held_out]
    with canvas(size=(6.2, 4.0)) as (figure, axes):
        ax = axes[0, 0]
        for number, reading in enumerate(real.readings):
            first = number == 0
            ax.plot(
                lengths,
                [100 * share for share in reading.material_held_out.values()],
                color=_colour(reading, real.readings[0]),
                ls="--" if reading.known_contacts and not first else "-",
                marker="o",
                ms=6 if first else 4,
                lw=2.4 if first else 1.3,
                label=", ".join(reading.title),
                zorder=3 if first else 2,
            )
        ax.axhline(100 * real.chance, color=RED, ls=":", lw=1.2, label="constant prediction")
        ax.set_xticks(lengths, [f"{ms:g}" for ms in lengths])
        ax.set(xlabel="Length of the window (ms)", ylabel="Balanced accuracy (%)", ylim=(0, 103))
        figure.legend(loc="outside lower center", ncols=1)
        image = uri(figure)
    return Figure(
        "short",
        "Hardness from the first milliseconds",
        "Each material was left out of the training of the model that predicts it. Balanced: the "
        "mean over materials, then over classes.",
        image,
    )


def _colour(reading: ReadingScores, first: ReadingScores) -> str:
    if reading.estimator != first.estimator:
        return names.estimator(reading.estimator).colour if not reading.conditioned else GREY
    return ORANGE if reading.conditioned else BLUE


REAL = Field.optional("real", dict[str, ShortWindows])


def _text(subjects: Subjects) -> str:
    text = (
        "The class of hardness from the first milliseconds, by models that were not trained on the "
        "material. Accuracy is the mean over materials, then over classes, so a material with many "
        "pinches counts as much as one with few. For each left-out material, the kind of input and "
        "the regularisation are chosen on the other materials, each left out in turn."
    )
    if any(map(is_learned, subjects.values())):
        text += (
            " The detector that places windows was not trained on the session, but perhaps on the "
            "material in another session."
        )
    return text


def real_set(results: SubjectResults) -> ShortWindows | None:
    """Return the results on real recordings, or None if the dataset is simulated."""
    return next(iter((results[REAL] or {}).values()), None)


def short_table(results: SubjectResults) -> Table | None:
    real = real_set(results)
    if real is None:
        return None
    lengths = list(real.material_held_out)
    lines = []
    for place, reading in enumerate(real.readings):
        cells = [Cell(percent(reading.material_held_out[ms])) for ms in lengths]
        name = Cell(*reading.title)
        lines.append(Line([name, *cells, Cell(f"{reading.n:,}")], place > 0))
    caption = (
        f"Balanced accuracy of the hardness class by window length, with each of {real.materials} "
        f"materials left out. A constant prediction has {percent(real.chance)}. {_order(real)}"
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in lengths), "Pinches"], lines)


def materials_table(results: SubjectResults) -> Table | None:
    real = real_set(results)
    if real is None:
        return None
    lengths = list(real.material_held_out)

    def shares(accuracy: dict[str, float]) -> list[Cell]:
        return [Cell(percent(accuracy[ms]) if ms in accuracy else ABSENT) for ms in lengths]

    lines = []
    worst, _ = real.worst(lengths[-1])
    for material, entry in sorted(real.by_material.items(), key=lambda i: (i[1].rank, i[0])):
        name = material.replace("_", " ")
        about = f"rank {entry.rank:g}, {counted(entry.n, 'pinch')}"
        hertz = [Cell(f"{hz:.0f} Hz") for hz in (entry.centroid_hz, entry.conditioned_centroid_hz)]
        lines.append(Line([Cell(name, about), *shares(entry.accuracy), *hertz]))
        lines += [
            Line([Cell(name, f"session {session}"), *shares(accuracy), *2 * [Cell(ABSENT)]], True)
            for session, accuracy in (entry.sessions or {}).items()
            if material == worst
        ]
    head = ["", *(f"{ms} ms" for ms in lengths), "Centroid as sent", "behind smoothing"]
    title, windows = real.readings[0].title
    caption = (
        f"Share of correctly classified windows of each left-out material. {title}, {windows}."
    )
    if real.by_material[worst].sessions:
        caption += " The worst material is also shown by session."
    return Table(caption, head, lines)


def _order(real: ShortWindows) -> str:
    smooth = real.conditioned_order
    if real.rho is None or real.p is None or smooth.rho is None:
        return ""
    text = (
        f"Order of hardness by the {real.score.split(',')[0]}, without any fit: ρ = {real.rho:.2f}"
        f" (n = {real.materials}, p = {real.p:.3f}) on the signal as sent, {smooth.rho:.2f} after "
        f"the published smoothing. A perfect order has {real.most_rho:.2f}, because materials of "
        "one rank are ties."
    )
    return text.replace("-", "−")


#: Balanced accuracy of the hardness class of held-out materials, at ``SHOWN_MS``.
BALANCED = Row[SubjectResults](
    "Hardness class, Log spectrum without smoothing, material left out: balanced accuracy, "
    f"{' / '.join(SHOWN_MS)} ms",
    optional(
        real_set,
        lambda real: " / ".join(
            percent(real.material_held_out[ms]) for ms in SHOWN_MS if ms in real.material_held_out
        ),
    ),
    "share",
)
WORST = Row[SubjectResults](
    f"– of the worst material, {' / '.join(SHOWN_MS)} ms",
    optional(
        real_set,
        lambda real: " / ".join(
            f"{percent(share)} ({name.replace('_', ' ')})"
            for name, share in (real.worst(ms) for ms in SHOWN_MS if ms in real.material_held_out)
        ),
    ),
    "share",
)
CHANCE = Row[SubjectResults](
    "– of a constant prediction", optional(real_set, lambda real: real.chance), "share"
)


PART = Part(
    "short",
    "Short windows of materials left out",
    [Step("short windows", with_ranks(short_windows))],
    _text,
    [short_table, materials_table],
    lambda subjects: [BALANCED, WORST, CHANCE],
)
