"""Arrays for ``import`` from the drops of an impactor whose spring has a known stiffness.

    python examples/spring_drops.py spring_drops drops.npz
    firstcontact import drops.npz --out drops

Each drop has an acceleration in g, a stiffness in N/mm, and a speed. Drops at one speed are one
session, so that a study holds out each speed in turn.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

#: Column of the acceleration in the signals.
ACCELERATION = 2


def main(folder: Path, out: Path) -> None:
    """Write the arrays that `import` reads."""
    with np.load(folder / "drops.npz") as drops:
        speeds = [f"{speed:g} m/s" for speed in drops["speed_m_per_s"]]
        np.savez(
            out,
            accelerometer=drops["signals"][:, :, [ACCELERATION]],
            accelerometer_unit="g",
            sample_rate_hz=drops["rate_hz"],
            first_contact=np.full(len(speeds), drops["onset_sample"]),
            stiffness_n_per_mm=drops["stiffness_n_per_mm"],
            object=[f"spring of {level:g} N/mm" for level in drops["stiffness_n_per_mm"]],
            session=speeds,
            source="real",
        )


if len(sys.argv) == 3:
    main(*map(Path, sys.argv[1:]))
else:
    print("give the folder of drops, and the name of the arrays to write")
