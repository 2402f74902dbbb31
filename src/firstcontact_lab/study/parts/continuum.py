"""Study part ``continuum``: comparison of the twin's touches with finite elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np

from firstcontact.core import Record
from firstcontact.core.display import INK
from firstcontact.jobs import Runner
from firstcontact.twin.mechanics import FingerParameters, ObjectParameters, contact_arms
from firstcontact.twin.objects import OBJECTS as OBJECTS_BY_NAME
from firstcontact.twin.objects import block
from firstcontact_lab.continuum.comparison import Comparison, compare, twin_touch
from firstcontact_lab.continuum.touch import DURATION, INTERVAL
from firstcontact_lab.continuum.waveforms import compare_file
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import Cell, Row, Table, matrix, number
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects

BLOCKS = {f"block {level}": float(level) for level in (10, 20, 29, 43, 60)}
OBJECTS = (*BLOCKS, "apple 1", "orange 1", "avocado 1", "tennis ball 1")
FRUIT = ("apple 1", "orange 1", "avocado 1")
#: Shore A of the blocks on whose peaks fruit is read.
READ = range(5, 96, 5)
BRIEF = ("block 20", "block 60", "apple 1")
DIMPLES, RIGID = "pad on dimples", "rigid tip"


class TouchScores(Record, frozen=True, kw_only=True):
    """Peak voltages (V) and relative differences of one touch, by twin and finite elements."""

    twin: float
    elements: float
    peak: float
    rms: float
    rms_of_peak: float | None = None


class LossBias(Record, frozen=True, kw_only=True):
    """Bias in Shore A of an object, judged by its peak voltage, for each kind of damping."""

    none: float
    fast: float
    both: float


class Continuum(Record, frozen=True, kw_only=True):
    """Comparison of the twin with finite elements.

    ``tips`` has scores by tip and object. ``powers`` has exponents and ``lines`` has R² of fits to
    the peak voltages.
    """

    tips: dict[str, dict[str, TouchScores]]
    powers: dict[str, float]
    lines: dict[str, float]
    loss: dict[str, LossBias]
    waveforms: dict[str, TouchScores] = msgspec.field(default_factory=dict)


def continuum(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Compare touches by the twin's standard finger with finite elements."""
    if subject.name != "paper-rig":
        return PartResult()
    names = BRIEF if settings.brief else OBJECTS
    jobs = [(tip, name) for tip in (DIMPLES, RIGID) for name in names]
    touches = dict(zip(jobs, runner.map(_compare, jobs), strict=True))
    by_tip = {tip: {name: touches[tip, name] for name in names} for tip in (DIMPLES, RIGID)}
    scores = {
        tip: {name: _scores(comparison) for name, comparison in found.items()}
        for tip, found in by_tip.items()
    }
    series = {
        f"elements, {tip}": {n: s.elements for n, s in found.items()}
        for tip, found in scores.items()
    }
    series["twin"] = {name: s.twin for name, s in scores[DIMPLES].items()}
    fitted = {name: fits(peaks) for name, peaks in series.items()}
    results = Continuum(
        tips=scores,
        powers={name: power for name, (power, _) in fitted.items()},
        lines={name: line for name, (_, line) in fitted.items()},
        loss=loss_biases(FRUIT),
        waveforms=_of_file(settings.waveforms),
    )
    figures = [_figure(tip, found) for tip, found in by_tip.items()]
    return PartResult([CONTINUUM(results)], figures)


def _compare(job: tuple[str, str]) -> Comparison:
    tip, name = job
    return compare(OBJECTS_BY_NAME[name], FingerParameters(), is_rigid=tip == RIGID)


def _of_file(path: str) -> dict[str, TouchScores]:
    touches = compare_file(Path(path)) if path else {}
    return {name: _scores(touch) for name, touch in touches.items()}


def _scores(comparison: Comparison) -> TouchScores:
    return TouchScores(
        twin=float(comparison.twin.max()),
        elements=float(comparison.elements.max()),
        peak=comparison.peak,
        rms=comparison.rms,
        rms_of_peak=comparison.rms_of_peak,
    )


def fits(peaks: Mapping[str, float]) -> tuple[float, float]:
    """Fit the peak voltages of blocks over their Shore A, and return (exponent, R²).

    The exponent is that of a power law. R² is that of a straight line.
    """
    shore = np.array([BLOCKS[name] for name in peaks if name in BLOCKS])
    volts = np.array([peak for name, peak in peaks.items() if name in BLOCKS])
    power = np.polyfit(np.log(shore), np.log(volts), 1)[0]
    return float(power), float(np.corrcoef(shore, volts)[0, 1] ** 2)


def loss_biases(names: Sequence[str]) -> dict[str, LossBias]:
    """Return by how many Shore A each object seems too hard, judged by its peak voltage.

    The keys are the names of the objects.
    """
    finger = FingerParameters()
    times = np.arange(0.0, DURATION, INTERVAL)

    def peak(target: ObjectParameters) -> float:
        return float(twin_touch(contact_arms(finger, target), finger, times).max())

    peaks = [peak(block(level).nominal) for level in READ]
    biases = {}
    for name in names:
        kind = OBJECTS_BY_NAME[name]
        versions = {
            "none": kind.nominal._replace(arm_share=0.0, slow_share=0.0),
            "fast": kind.nominal._replace(slow_share=0.0),
            "both": kind.nominal,
        }
        biases[name] = LossBias(**{
            arms: float(np.interp(peak(target), peaks, READ)) - kind.shore_a
            for arms, target in versions.items()
        })  # fmt: skip
    return biases


def _figure(tip: str, touches: Mapping[str, Comparison]) -> Figure:
    rows = -(-len(touches) // 2)
    with canvas(rows, 2, (6.2, 0.4 + 1.6 * rows), sharex=True, sharey=True) as (figure, axes):
        for ax in axes.flat[len(touches) :]:
            ax.set_visible(False)
        for ax, (name, touch) in zip(axes.flat, touches.items(), strict=False):
            ax.plot(1e3 * touch.times, touch.elements, color=INK, lw=1.1, label="elements")
            ax.plot(1e3 * touch.times, touch.twin, "--", color="#D55E00", label="twin")
            ax.set_title(f"{name}: {_percent(touch.peak)}")
        for ax in axes[-1]:
            ax.set_xlabel("Time after contact (ms)")
        for ax in axes[:, 0]:
            ax.set_ylabel("Piezo (V)")
        axes[0, 0].legend()
        image = uri(figure)
    caption = "In the titles: difference of the twin's peak from that of the elements."
    return Figure(tip.replace(" ", "-"), f"Twin and finite elements, {tip}", caption, image)


def _percent(share: float) -> str:
    return f"{number(100 * share, 1, '+')} %"


CONTINUUM = Field.optional("continuum", Continuum)
_ROWS: Sequence[Row[TouchScores]] = (
    Row("peak of the twin, V", lambda s: s.twin, "p"),
    Row("peak of the elements, V", lambda s: s.elements, "p"),
    Row("difference of the peaks", lambda s: _percent(s.peak)),
    Row("RMS of the difference", lambda s: s.rms, "share"),
    Row("RMS over the peak", lambda s: s.rms_of_peak, "share"),
)


#: Largest scores of a group of touches: number, peak, RMS, RMS as a share of the peak.
_Largest = tuple[int, float, float, float]
_LARGEST_ROWS: Sequence[Row[_Largest]] = (
    Row("touches", lambda m: m[0]),
    Row("largest difference of the peaks", lambda m: m[1], "share"),
    Row("largest RMS", lambda m: m[2], "share"),
    Row("largest RMS over the peak", lambda m: m[3], "share"),
)


_LOSS_ROWS: Sequence[Row[LossBias]] = (
    Row("without loss", lambda b: b.none, "bias"),
    Row("with the fast loss", lambda b: b.fast, "bias"),
    Row("with fast and slow loss", lambda b: b.both, "bias"),
)


def _tables(results: SubjectResults) -> list[Table | None]:
    found = results[CONTINUUM]
    if found is None:
        return []
    tables: list[Table | None] = [
        matrix(
            f"Touches with {'a ' if tip == RIGID else 'the '}{tip}.",
            _ROWS,
            [(Cell(name), scores, False) for name, scores in touches.items()],
        )
        for tip, touches in found.tips.items()
    ]
    claim: Sequence[Row[str]] = (
        Row("exponent of a power law", lambda name: found.powers[name], "rho"),
        Row("R² of a straight line with an intercept", lambda name: found.lines[name], "p"),
    )
    caption = (
        "How the peak amplitude of the blocks grows with Shore A. A soft pad lowers the exponent."
    )
    tables.append(matrix(caption, claim, [(Cell(name), name, False) for name in found.powers]))
    caption = (
        "Bias of the Shore A that the peak of a touch has on the scale of the blocks, for objects "
        "without and with loss (+ is too hard)."
    )
    loss = [(Cell(name), bias, False) for name, bias in found.loss.items()]
    tables.append(matrix(caption, _LOSS_ROWS, loss))
    caption = "Touches of the file of `--waveforms`, in groups."
    groups = [(Cell(name), largest, False) for name, largest in largest_of(found).items()]
    tables.append(matrix(caption, _LARGEST_ROWS, groups))
    caption = "Touches of the file of `--waveforms`."
    touches = [(Cell(name), scores, False) for name, scores in found.waveforms.items()]
    return [*tables, matrix(caption, _ROWS, touches)]


def largest_of(found: Continuum) -> dict[str, _Largest]:
    """Return the number of touches and their largest scores, for each group of objects.

    Blocks and solid fruit are grouped by fingertip, other objects by shape.
    """
    groups: dict[str, list[TouchScores]] = {}
    for name, scores in found.waveforms.items():
        shape, _, tip, *_ = name.split("-")
        is_usual = shape not in ("wide", "tennis")
        title = f"blocks and solid fruit, {tip}" if is_usual else shape
        groups.setdefault(title, []).append(scores)
    return {
        title: (
            len(group),
            max(abs(s.peak) for s in group),
            max(s.rms for s in group),
            max(s.rms_of_peak or 0.0 for s in group),
        )
        for title, group in groups.items()
    }


def _text(subjects: Subjects) -> str:
    return (
        "One finger of the twin touches a free object, without noise. The same finger touches the "
        "same object as a continuum: axisymmetric finite elements, explicit in time. Hertz's law, "
        "the two masses of an object and the loss law are thereby checked; drive, mount and sensor "
        "are the same on both sides. The rigid tip leaves out what the pad adds."
    )


PART = Part(
    "continuum",
    "Twin and finite elements",
    [Step("touches with finite elements", continuum, late=True, cost=40)],
    _text,
    _tables,
    needs=(),
    by_default=False,
)
