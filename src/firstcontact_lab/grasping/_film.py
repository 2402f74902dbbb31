"""Film of a hand that picks up objects, such as a raspberry and a hammer, with two policies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.display import GREY, INK, RED
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import holding_force
from firstcontact.grasp import POLICIES
from firstcontact.twin.outcome import Lift
from firstcontact_lab.grasping._hands import OwnHands
from firstcontact_lab.grasping._judgement import SettingsOf
from firstcontact_lab.grasping._picks import FullJob, Pick, pick_specimen, play
from firstcontact_lab.grasping.results import Filmed
from firstcontact_lab.report.style import STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Filmed objects, and the time before and after the first contact, s.
KINDS, BEFORE, AFTER = ("raspberry", "hammer, at its handle"), 0.05, 0.65
#: Number of pictures, and pictures per second.
PICTURES, PACE = 72, 12


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """One filmed closing: grip force (N) over the time from the first contact (s), and outcome."""

    policy: str
    kind: str
    time: NDArray[np.float64]
    grip: NDArray[np.float64]
    second: float | None
    needed: float
    limit: float
    became: str


def take(pick: Pick, policy: str, settings: SettingsOf, hands: OwnHands) -> Take:
    """Simulate a full closing, with settings that were not tuned on the object's family."""
    course = play(FullJob(pick, policy, settings(pick.kind)), hands)
    outcome, row = course.plant.outcome, course.row
    specimen = pick_specimen(pick)
    first = outcome.first_contact or 0.0
    second = outcome.second_contact
    return Take(
        policy,
        pick.kind,
        np.arange(len(course.forces)) / FINGERTIP_RATE - first,
        course.forces.min(axis=1),
        None if second is None else second - first,
        holding_force(specimen.mass, specimen.friction),
        np.inf if specimen.fragility is None else specimen.fragility.scale,
        "crushed" if row.damaged else "dropped" if row.dropped else "held",
    )


def film(
    path: Path,
    kinds: Sequence[str],
    hand: int,
    specimen: int,
    settings: Mapping[str, SettingsOf],
    hands: OwnHands,
    pictures: int = PICTURES,
) -> Filmed:
    """Write an animated GIF with one row per object and one column per policy."""
    from matplotlib import rc_context
    from matplotlib.animation import FuncAnimation, PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    takes = [
        [
            take(Pick(kind, hand, specimen), policy, policy_settings, hands)
            for policy, policy_settings in settings.items()
        ]
        for kind in kinds
    ]
    with rc_context(STYLE):
        figure = Figure(figsize=(7.4, 5.2), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(len(kinds), len(settings), sharex=True, sharey=True, squeeze=False)
        most = 1.25 * max(float(t.grip.max()) for row in takes for t in row)
        times = np.linspace(-BEFORE, AFTER, pictures)

        def draw(picture: int) -> list[Any]:
            for row, policy_settings in zip(axes, takes, strict=True):
                for axis, shot in zip(row, policy_settings, strict=True):
                    axis.clear()
                    _panel(axis, shot, times[picture], most)
            for axis in axes[:, 0]:
                axis.set_ylabel("Grip force (N)")
            for axis in axes[-1]:
                axis.set_xlabel("Time after first contact (ms)")
            return []

        draw(pictures - 1)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once, so that all pictures have one layout
        FuncAnimation(figure, draw, frames=pictures, blit=False).save(
            path, writer=PillowWriter(fps=PACE), dpi=90
        )
    return Filmed(objects=list(kinds), hand=hand, specimen=specimen)


def _panel(axis: Axes, shot: Take, now: float, most: float) -> None:
    policy = POLICIES[shot.policy]
    past = (shot.time <= now) & (shot.time >= -BEFORE)
    axis.plot(1e3 * shot.time[past], shot.grip[past], color=policy.colour, linewidth=2)
    axis.axhspan(0, shot.needed, color=GREY, alpha=0.22, linewidth=0)
    axis.text(
        640, shot.needed, "slips below", ha="right", va="bottom", fontsize=7.5, color="#52606D"
    )
    if shot.limit < most:
        axis.axhspan(shot.limit, most, color=RED, alpha=0.14, linewidth=0)
        axis.text(640, most * 0.97, "crushed above", ha="right", va="top", fontsize=7.5, color=RED)
    if shot.second is not None and now >= shot.second:
        axis.axvline(1e3 * shot.second, color=GREY, linewidth=0.9, linestyle=":")
    if now >= Lift().delay:
        axis.axvline(1e3 * Lift().delay, color=GREY, linewidth=0.9, linestyle="--")
        axis.text(
            1e3 * Lift().delay - 8, 0.97 * most, "lifted", ha="right", va="top", fontsize=7.5,
            color="#52606D",
        )  # fmt: skip
    axis.set_xlim(-1e3 * BEFORE, 1e3 * AFTER)
    axis.set_ylim(0, most)
    name = shot.kind.split(",")[0].capitalize()
    over = now >= 0.98 * AFTER
    title = f"{name}: {policy.title}" + (f" – {shot.became}" if over else "")
    colour = RED if over and shot.became != "held" else INK
    axis.set_title(title, color=colour, fontweight="bold" if over else "normal")
