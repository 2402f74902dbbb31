"""Study part ``waveforms``: signals and peak voltages after the contact, by Shore A."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.core.display import INK
from firstcontact.models.labelled_data import DURATION, LabelledWindows
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, shades, uri, vibration_unit
from firstcontact_lab.report.tables import ERROR_TOLERANCE, Row
from firstcontact_lab.study.part import Part, Step, Subject


class PeakVoltage(Record, frozen=True, kw_only=True):
    """Mean and standard deviation of the peak voltages of windows with the same Shore A, V."""

    mean: float
    sd: float | None = None
    n: int


def waveforms(subject: Subject) -> PartResult:
    if len(subject.levels) < 2:
        return missing("Responses by stiffness: the training pinches have only one Shore A level.")
    data = subject.windows(DURATION)
    blocks = data.take(~data.test)
    if len(blocks) < 2:
        return missing("Responses by stiffness: no contact was found.")
    unit = vibration_unit(subject.dataset.layout)
    peaks = np.abs(blocks.X[:, :, 0]).max(axis=1).astype(np.float64)
    by_level = {f"{level:g}": _peaks(peaks[blocks.y == level]) for level in np.unique(blocks.y)}
    return PartResult(
        [PEAK(by_level)], [response_figure(blocks, unit), peak_figure(blocks.y, peaks, unit)]
    )


def _peaks(values: NDArray[np.float64]) -> PeakVoltage:
    spread = float(values.std(ddof=1)) if len(values) > 1 else None
    return PeakVoltage(mean=float(values.mean()), sd=spread, n=len(values))


def response_figure(blocks: LabelledWindows, unit: str) -> Figure:
    levels = np.unique(blocks.y)
    time = 1e3 * np.arange(blocks.X.shape[1]) / blocks.rate
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        for level, colour in zip(levels, shades(len(levels)), strict=True):
            waves = blocks.X[blocks.y == level, :, 0]
            low, middle, high = np.percentile(waves, [25, 50, 75], axis=0)
            ax.fill_between(time, low, high, color=colour, alpha=0.18, lw=0)
            ax.plot(time, middle, color=colour, label=f"{level:g}")
        ax.axhline(0, color=INK, lw=0.6)
        ax.set(xlabel="Time after contact (ms)", ylabel=f"Vibration, finger that touched ({unit})")
        ax.set_xlim(0, time[-1])
        ax.legend(title="Shore A", title_fontsize=8.5, ncols=1, loc="upper right")
        image = uri(figure)
    return Figure(
        "responses",
        "Response by stiffness",
        "Median of each level (line) and the middle half of its pinches (band), after filtering.",
        image,
    )


def peak_figure(shore_a: NDArray[np.float64], peaks: NDArray[np.float64], unit: str) -> Figure:
    levels = np.unique(shore_a)
    rng = np.random.default_rng(0)
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        spread = 0.25 * float(np.diff(levels).min())
        for level, colour in zip(levels, shades(len(levels)), strict=True):
            level_peaks = peaks[shore_a == level]
            ax.scatter(
                level + rng.uniform(-spread, spread, len(level_peaks)),
                level_peaks,
                s=6,
                color=colour,
                alpha=0.35,
                lw=0,
                rasterized=True,
            )
        means = [peaks[shore_a == level].mean() for level in levels]
        groups = (peaks[shore_a == level] for level in levels)
        sds = [level_peaks.std(ddof=min(1, len(level_peaks) - 1)) for level_peaks in groups]
        ax.errorbar(
            levels, means, yerr=sds, fmt="o-", color=INK, capsize=3, ms=4.5, lw=1, label="mean ± SD"
        )
        ax.set(xlabel="Shore A", ylabel=f"Peak amplitude ({unit})", ylim=(0, None))
        ax.set_xticks(levels)
        ax.legend(loc="upper left")
        image = uri(figure)
    return Figure("peaks", "Peak amplitude against stiffness", "Each point is a pinch.", image)


PEAK = Field.optional("peak_v", dict[str, PeakVoltage])


def peak_power(results: SubjectResults) -> float | None:
    """Return the exponent of mean peak voltage over Shore A, or None if it was not measured."""
    levels, means = _mean_peaks(results)
    if len(levels) < 2 or levels[0] <= 0 or means.min() <= 0:
        return None
    return float(np.polyfit(np.log(levels), np.log(means), 1)[0])


def peak_line(results: SubjectResults) -> float | None:
    """Return R² of a straight line through the mean peak voltages over Shore A.

    Return None with fewer than three values of Shore A.
    """
    levels, means = _mean_peaks(results)
    return float(np.corrcoef(levels, means)[0, 1] ** 2) if len(levels) > 2 else None


def _mean_peaks(results: SubjectResults) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    peaks = results[PEAK] or {}
    levels = sorted(peaks, key=float)
    return np.array([float(level) for level in levels]), np.array([peaks[k].mean for k in levels])


def _proportional(results: SubjectResults) -> str:
    power = peak_power(results)
    if power is not None and abs(power - 1.0) <= ERROR_TOLERANCE:
        return "reproduced"
    if not (np.diff(_mean_peaks(results)[1]) > 0).all():
        return "does not rise with every level"
    return "rises with every level, but not in proportion"


PROPORTIONAL = Row[SubjectResults](
    "Peak amplitude over Shore A, exponent (1: in proportion)",
    peak_power,
    "rho",
    "1",
    note=_proportional,
)

LINE = Row[SubjectResults](
    "Peak amplitude over Shore A, straight line with an intercept: R²", peak_line, "p"
)

PART = Part(
    "waveforms",
    "Signals after contact",
    [Step("waveforms", lambda subject, settings, runner: waveforms(subject))],
    rows=lambda subjects: [PROPORTIONAL, LINE],
)
