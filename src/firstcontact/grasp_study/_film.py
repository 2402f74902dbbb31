"""One pinch, closed twice: without modulation and with it, in slow motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.palette import INK
from firstcontact.grasp.policy import Part
from firstcontact.grasp_study._closing import Order
from firstcontact.grasp_study._learning import Models
from firstcontact.grasp_study._trials import PinchSetup, Tuned, plant_of, played
from firstcontact.grasp_study.settings import HEADLINE
from firstcontact.grasp_study.variants import Variant, playing, unmodulated
from firstcontact.report.figures.style import STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: What is filmed, from so long before the first contact to so long after it, s.
KIND, BEFORE, AFTER = "block 10", 0.020, 0.160
#: Pictures, and how many a second.
PICTURES, PACE = 72, 12
#: An offset that is easily seen, s.
OFFSETS = (0.018, 0.030)


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """One closing: time from its first contact (s), grip force (N), gaps (m), orders."""

    variant: Variant
    time: NDArray[np.float64]
    grip: NDArray[np.float64]
    gaps: NDArray[np.float64]
    orders: tuple[Order, ...]
    touched: float
    offset: float | None


def film(
    path: Path, sessions: int, seed: int, tuned: Tuned, models: Models,
    pictures: int = PICTURES,
) -> PinchSetup:  # fmt: skip
    """Write an animated GIF of no modulation beside the last of the candidates.

    Of the sessions, the first is taken whose fingers touch a good while apart.

    Returns
    -------
    PinchSetup
        What is shown.
    """
    from matplotlib import rc_context
    from matplotlib.animation import FuncAnimation, PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    for number in range(sessions):
        setup = PinchSetup(KIND, number, seed=seed)
        before = take(setup, unmodulated(), tuned, models)
        if before.offset is not None and OFFSETS[0] <= before.offset <= OFFSETS[1]:
            break
    takes = (before, take(setup, filmed(), tuned, models))
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 4.5), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(
            3, 2, sharex="row", sharey="row", gridspec_kw={"height_ratios": (0.9, 1.5, 1.0)}
        )
        figure.suptitle(f"Closing on a 10 Shore A block, {1e3 * HEADLINE:g} ms brake latency")
        times = np.linspace(-BEFORE, AFTER, pictures)

        def draw(picture: int) -> list[Any]:
            for column, shown in enumerate(takes):
                for axis in axes[:, column]:
                    axis.clear()
                _hand(axes[0, column], shown, times[picture])
                _force(axes[1, column], shown, times[picture])
                _commands(axes[2, column], shown, times[picture])
            axes[1, 0].set_ylabel("Grip force (N)")
            axes[2, 0].set_ylabel("Command (mm/s)")
            return []

        # Rows share their scales, and those must not jump.
        most = 1.4 * max(float(t.grip.max()) for t in takes)
        fast = 1.7e3 * max(o.command.speed for t in takes for o in t.orders)

        def fixed(picture: int) -> list[Any]:
            draw(picture)
            axes[1, 0].set_ylim(0, most)
            axes[2, 0].set_ylim(0, fast)
            for row in axes[1:]:
                row[0].set_xlim(-1e3 * BEFORE, 1e3 * AFTER)
            return []

        FuncAnimation(figure, fixed, frames=pictures, blit=False).save(
            path, writer=PillowWriter(fps=PACE), dpi=90
        )
    return setup


def filmed() -> Variant:
    """What is shown beside no modulation."""
    return playing(Part.CANDIDATE)[-1]


def take(setup: PinchSetup, variant: Variant, tuned: Tuned, models: Models) -> Take:
    """Close on a setup at the headline's latency."""
    plant = plant_of(setup, variant, HEADLINE)
    told = played(plant, setup, variant, tuned, models)
    outcome = plant.outcome
    first = outcome.first_contact or 0.0
    second = outcome.second_contact
    forces = plant.forces
    return Take(
        variant,
        np.arange(len(forces)) / FINGERTIP_RATE - first,
        forces.min(axis=1),
        plant.gaps,
        told.orders,
        first,
        None if second is None else second - first,
    )


def _hand(axis: Axes, shown: Take, now: float) -> None:
    """Fingers and block, with the gaps to scale."""
    from matplotlib.patches import Rectangle

    row = min(int(np.searchsorted(shown.time, now)), len(shown.time) - 1)
    gaps = np.nan_to_num(shown.gaps[row], nan=3e-3).clip(0.0, 4e-3) * 1e3
    half = 4.0
    axis.add_patch(Rectangle((-half, -1.2), 2 * half, 2.4, color="#C9D3DC"))
    for side, gap in zip((-1, 1), gaps, strict=True):
        touching = gap <= 0
        face = side * (half + gap)
        axis.add_patch(
            Rectangle(
                (min(face, face + side * 3.0), -0.8), 3.0, 1.6,
                facecolor=shown.variant.colour if touching else "#DDE3E8",
                edgecolor="#8A94A0",
            )
        )  # fmt: skip
    axis.set_xlim(-11.5, 11.5)
    axis.set_ylim(-1.6, 1.6)
    axis.set_axis_off()
    axis.set_title(shown.variant.title, color=shown.variant.colour)
    axis.text(0, 0, f"{1e3 * now:+.0f} ms", ha="center", va="center", color=INK)


def _force(axis: Axes, shown: Take, now: float) -> None:
    past = (shown.time <= now) & (shown.time >= -BEFORE)
    axis.plot(1e3 * shown.time[past], shown.grip[past], color=shown.variant.colour, linewidth=1.8)
    _marks(axis, shown, now)
    if past.any() and shown.grip[past].max() > 0:
        axis.text(
            0.98, 0.92, f"peak {shown.grip[past].max():.1f} N", ha="right", va="top",
            transform=axis.transAxes, fontsize=9.5, fontweight="bold",
        )  # fmt: skip


def _marks(axis: Axes, shown: Take, now: float) -> None:
    for at, label in ((0.0, "first"), (shown.offset, "second")):
        if at is not None and now >= at:
            axis.axvline(1e3 * at, color="#8A94A0", linewidth=0.9, linestyle=":")
            axis.text(
                1e3 * at + 1.5, 0.97, label, transform=axis.get_xaxis_transform(), va="top",
                fontsize=7.5, color="#52606D",
            )  # fmt: skip


def _commands(axis: Axes, shown: Take, now: float) -> None:
    """Commanded speed, with the force limit written where it changes."""
    told = [(o.at - shown.touched, o.command) for o in shown.orders]
    edges = [max(t, -BEFORE) for t, _ in told if t <= now]
    speeds = [1e3 * c.speed for t, c in told if t <= now]
    if edges:
        axis.step(
            [1e3 * e for e in edges] + [1e3 * now], [*speeds, speeds[-1]], where="post",
            color=shown.variant.colour, linewidth=1.8,
        )  # fmt: skip
        last = [c for t, c in told if t <= now][-1]
        axis.text(
            0.98, 0.92, f"at most {last.force:.1f} N", ha="right", va="top",
            transform=axis.transAxes, fontsize=9,
        )  # fmt: skip
    axis.set_xlabel("Time after first contact (ms)")
