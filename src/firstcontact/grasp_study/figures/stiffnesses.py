"""Peak force over how stiff the object is."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.grasp_study.results import ObjectSummary
from firstcontact.grasp_study.variants import unmodulated, variants
from firstcontact.report.figures.style import canvas, uri


def over_shore(objects: Mapping[str, ObjectSummary]) -> str:
    """Draw all that modulate, on objects that cannot break; data URI."""
    lasting = sorted((o for o in objects.values() if not o.breaks), key=lambda o: o.shore_a)
    drawn = [v for k, v in variants().items() if k in lasting[0].variants and v != unmodulated()]
    with canvas(size=(6.2, 3.9)) as (figure, axes):
        axis = axes[0, 0]
        for variant in drawn:
            axis.plot(
                [o.shore_a for o in lasting],
                [o.variants[variant.key].peak_n for o in lasting],
                marker="o", markersize=3.5, color=variant.colour, label=variant.title,
            )  # fmt: skip
        axis.set_xlabel("Shore A")
        axis.set_ylabel("Mean peak force (N)")
        axis.set_ylim(bottom=0)
        figure.legend(loc="outside upper center", ncols=3)
        return uri(figure)
