"""Each thing of the household: how far the live estimate was off."""

from __future__ import annotations

from firstcontact.core import BLUE, GREY, ORANGE
from firstcontact_lab.grasping.results import Household
from firstcontact_lab.report.figures.style import canvas, uri

#: Width, height of a row, and of all else, inch.
WIDTH, ROW, REST = 7.4, 0.2, 0.8


def objects_figure(found: Household) -> str:
    """A row a thing: the error of the estimate that was used, and its mean; a data URI."""
    names = list(found.by_object)
    with canvas(size=(WIDTH, REST + ROW * len(names))) as (figure, axes):
        axis = axes[0, 0]
        for place, name in enumerate(names):
            its = found.by_object[name]
            used = its.rmse.get("used")
            if used is None:
                axis.text(1, place, "no estimate in time", va="center", fontsize=7.5, color=GREY)
                continue
            axis.barh(place, used, color=ORANGE if its.fragile else BLUE, height=0.66)
            if its.bias is not None:
                axis.plot([abs(its.bias)] * 2, [place - 0.33, place + 0.33], color="white")
            axis.text(used + 0.5, place, f"{used:.0f}", va="center", fontsize=8)
        axis.set_yticks(
            range(len(names)), [f"{n} ({found.by_object[n].shore_a:g})" for n in names], fontsize=8
        )
        axis.invert_yaxis()
        axis.set_ylim(len(names) - 0.4, -0.6)
        axis.set_xlim(left=0)
        axis.margins(x=0.08)
        axis.grid(axis="y", visible=False)
        axis.set_xlabel("RMSE of the estimate that was used (Shore A)")
        axis.plot([], [], color=ORANGE, linewidth=6, label="can be damaged")
        axis.plot([], [], color=BLUE, linewidth=6, label="cannot")
        axis.legend(loc="lower right")
        return uri(figure)
