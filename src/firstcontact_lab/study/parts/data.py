"""Study part ``data``: description of the dataset, and times from first to second contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Pinch, Record
from firstcontact.core.display import BLUE, GREY, INK, RED
from firstcontact.core.text import percent
from firstcontact.models.labelled_data import DURATION, distinct_specimens
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import (
    SHARE_TOLERANCE,
    Cell,
    Claim,
    Line,
    Row,
    Table,
    Value,
    optional,
)
from firstcontact_lab.study.part import Part, Step, Subject, Subjects


class DataSummary(Record, frozen=True, kw_only=True):
    source: str
    pinches: int
    specimens: int
    sample_rate_hz: float
    model_rate_hz: float | None = None
    sessions: int
    train_pinches: int
    test_pinches: int
    objects: list[str]
    notes: list[str]


class Offsets(Record, frozen=True, kw_only=True):
    """Distribution of the times from the first to the second contact, ms."""

    mean: float
    sd: float | None = None
    share_below_15: float
    share_below_8: float
    median: float
    n: int


class EarlyForce(Record, frozen=True, kw_only=True):
    """Force of the first finger before the second contact, as a share of its final force."""

    median: float
    p95: float
    n: int


def early_force(pinch: Pinch) -> float | None:
    """Return the first finger's force before the second contact, as a share of its final force.

    Return None for a pinch without force signals that permit this.
    """
    first, second = pinch.first, pinch.second
    if first is None or second is None or first.finger is None:
        return None
    if not pinch.layout.columns(ChannelKind.FORCE, first.finger):
        return None
    start, end = (contact.sample - pinch.first_sample for contact in (first, second))
    force = pinch.force(first.finger).mean(axis=1)
    quiet = force[max(0, start - round(0.02 * pinch.layout.rate)) : start]
    if not len(quiet) or not start < end < len(force):
        return None
    largest = float(force[end:].max() - quiet.mean())
    return float(force[end - 1] - quiet.mean()) / largest if largest > 0 else None


def describe(subject: Subject) -> PartResult:
    dataset = subject.dataset
    recorded, rate = dataset.recorded_rate, float(dataset.layout.rate)
    summary = DataSummary(
        source=dataset.source,
        pinches=len(dataset),
        specimens=len(set(distinct_specimens(dataset)) - {""}),
        sample_rate_hz=rate if recorded is None else float(recorded),
        model_rate_hz=None if recorded is None else rate,
        sessions=len(set(dataset.sessions) - {""}),
        train_pinches=int((~dataset.test).sum()),
        test_pinches=int(dataset.test.sum()),
        objects=sorted(set(dataset.objects.tolist()) - {""}),
        notes=_merge_notes([n for n in dataset.notes if n not in dataset.losses]),
    )
    spread = None
    figures: list[Figure] = []
    # Notes on missing data go to the list of parts left out, not to the list of assumptions.
    left_out = [f"{loss.rstrip('.')}." for loss in _merge_notes(dataset.losses)]
    offsets = np.array([1e3 * p.offset for p in dataset.pinches if p.offset is not None])
    if len(offsets):
        spread = Offsets(
            mean=float(offsets.mean()),
            # A single offset has no standard deviation.
            sd=float(offsets.std(ddof=1)) if len(offsets) > 1 else None,
            share_below_15=float((offsets < 1e3 * DURATION).mean()),
            share_below_8=float((offsets < 8.0).mean()),
            median=float(np.median(offsets)),
            n=len(offsets),
        )
        figures.append(offset_figure(offsets))
    else:
        left_out.append(
            "Offset between the contacts: no pinch has a known first and second contact."
        )
    shares = [share for pinch in dataset.pinches if (share := early_force(pinch)) is not None]
    force = None
    if shares:
        median, p95 = map(float, np.quantile(shares, (0.5, 0.95)))
        force = EarlyForce(median=median, p95=p95, n=len(shares))
    return PartResult([DATA(summary), OFFSET(spread), EARLY_FORCE(force)], figures, left_out)


def _merge_notes(notes: Sequence[str]) -> list[str]:
    """Return the first twelve distinct notes, and a line with the number of further notes."""
    unique = list(dict.fromkeys(notes))
    more = len(unique) - 12
    return unique if more <= 0 else [*unique[:12], f"... and {more} more notes of this kind."]


def offset_figure(offsets: NDArray[np.float64]) -> Figure:
    mean, sd = float(offsets.mean()), float(offsets.std(ddof=min(1, len(offsets) - 1)))
    window = 1e3 * DURATION
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        top = max(60.0, float(np.ceil(offsets.max() / 10) * 10))
        bins = np.arange(0.0, top + 2.5, 2.5)
        counts, _, bars = ax.hist(offsets, bins=bins, color=BLUE, edgecolor="white", linewidth=0.6)
        for left, bar in zip(bins[:-1], bars, strict=False):
            if left + 1.25 < window:
                bar.set_alpha(0.55)
        height = float(counts.max())
        ax.axvline(window, color=INK, lw=1, ls=":")
        ax.text(
            window + 0.6, height * 1.42, "end of the 15 ms window", fontsize=8, va="top", color=INK
        )
        for level, m, s, colour, name in (
            (1.12, mean, sd, BLUE, "here"),
            (1.24, PUBLISHED_MEAN, PUBLISHED_SD, RED, "published"),
        ):
            ax.errorbar(
                m,
                height * level,
                xerr=s,
                fmt="o",
                color=colour,
                capsize=3,
                ms=5,
                label=f"{name}: {m:.2f} ± {s:.2f} ms",
            )
        ax.set(
            xlabel="Offset from first to second contact (ms)",
            ylabel="Pinches",
            xlim=(0, top),
            ylim=(0, height * 1.45),
        )
        ax.grid(axis="x", visible=False)
        ax.legend(loc="upper right", title="mean ± SD", title_fontsize=8.5)
        ax.spines["left"].set_color(GREY)
        image = uri(figure)
    share = (offsets < window).mean()
    return Figure(
        "offsets",
        "Time between the two contacts",
        f"In {percent(share, 0)} of the pinches (pale bars) the second contact falls inside the "
        "15 ms window.",
        image,
    )


DATA = Field.optional("data", DataSummary)
OFFSET = Field.optional("offset_ms", Offsets)
EARLY_FORCE = Field.optional("force_before_second", EarlyForce)
#: Time from the first to the second contact, ms (section IV of the paper).
PUBLISHED_MEAN, PUBLISHED_SD = 16.65, 10.35

_SOURCES = {
    "twin": ("Twin results", "the twin"),
    "real": ("Real recordings", "real recordings"),
    "synthetic": ("Synthetic recordings", "synthetic"),
    "unknown": ("Recordings of unknown origin", "unknown: state it with `import --source`"),
}


def is_twin(results: SubjectResults) -> bool:
    data = results[DATA]
    return data is not None and data.source == "twin"


def kind(subjects: Subjects) -> str:
    data = next((results[DATA] for results in subjects.values()), None)
    if data is None:
        return "Just begun"
    return _SOURCES.get(data.source, (f"Source: {data.source}", ""))[0]


def data_table(results: SubjectResults) -> Table | None:
    data = results[DATA]
    if not data:
        return None
    rate = f"{data.sample_rate_hz:g} Hz"
    if data.model_rate_hz is not None:
        rate += f", resampled to {data.model_rate_hz:g} Hz"
    texts = {
        "Source": _SOURCES.get(data.source, ("", data.source))[1],
        "Pinches for training": f"{data.train_pinches:,}",
        "Pinches of unseen objects": f"{data.test_pinches:,}",
        "Specimens": f"{data.specimens:,}",
        "Sessions": f"{data.sessions:,}",
        "Rate": rate,
    }
    return Table("", ["", ""], [Line([Cell(name), Cell(text)]) for name, text in texts.items()])


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    note = "input of the twin" if any(map(is_twin, subjects.values())) else "another hand"

    def offset(value: Callable[[Offsets], Value]) -> Callable[[SubjectResults], Value]:
        return optional(lambda results: results[OFFSET], value)

    def force_note(results: SubjectResults) -> str:
        force = results[EARLY_FORCE]
        return "" if force is None else f"5 % of pinches above {percent(force.p95)}"

    return [
        Row("Pinches", optional(lambda r: r[DATA], lambda d: d.pinches), "count", "2500 + objects"),
        Row(
            "First to second contact, mean",
            offset(lambda o: o.mean),
            "ms",
            f"{PUBLISHED_MEAN} ms",
            note=lambda results: note,
        ),
        Row(
            "First to second contact, SD",
            offset(lambda o: o.sd),
            "ms",
            f"{PUBLISHED_SD} ms",
            note=lambda results: note,
        ),
        Row("Second contact within 15 ms", offset(lambda o: o.share_below_15), "share"),
        Row(
            "Force before the second contact, median share of the later force",
            optional(lambda results: results[EARLY_FORCE], lambda force: force.median),
            "share",
            "absent",
            claim=Claim(0.0, SHARE_TOLERANCE, lower=True),
            note=force_note,
        ),
    ]


PART = Part(
    "data",
    "The data",
    [Step("data", lambda subject, settings, runner: describe(subject), vital=True, cost=15)],
    tables=[data_table],
    rows=_rows,
    needs=(),
)
