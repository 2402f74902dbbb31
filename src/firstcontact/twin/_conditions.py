"""Conditions: two named variations of the simulated hand between sessions and pinches."""

from __future__ import annotations

from dataclasses import dataclass

from firstcontact.core import InputError


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations of ln(parameter): between sessions, and between pinches."""

    session: float = 0.0
    pinch: float = 0.0


@dataclass(frozen=True, slots=True)
class Condition:
    """Named variation of the simulated hand around its nominal parameters."""

    name: str
    speed: Spread
    tip_radius: Spread
    pad_stiffness: Spread
    phalanx_mass: Spread
    link_stiffness: Spread
    gain: Spread
    clamp: Spread
    noise: Spread
    click_rate: float
    """Number of clicks of the gear train per second."""
    mains_rates: tuple[float, ...]
    """Possible mains frequencies, Hz. Each session has one of them."""
    temperature: Spread
    """Variation of the object's modulus due to temperature and wear."""
    specimen_widen: float
    """Factor on the object's ``modulus_scatter``, the scatter between specimens."""
    specimens_per_block: int
    jitter: float
    """Standard deviation of the sampling instants (jitter), s."""
    asymmetry: float
    """Standard deviation of ln(parameter) between the two fingers of the hand."""


PAPER_RIG = Condition(
    name="paper-rig",
    speed=Spread(0.01, 0.03),
    tip_radius=Spread(0.02, 0.06),
    pad_stiffness=Spread(0.02, 0.02),
    phalanx_mass=Spread(0.0, 0.02),
    link_stiffness=Spread(0.01, 0.03),
    gain=Spread(0.02, 0.0),
    clamp=Spread(0.10, 0.10),
    noise=Spread(0.10, 0.10),
    click_rate=0.3,
    mains_rates=(50.0,),
    temperature=Spread(0.02, 0.01),
    specimen_widen=1.0,
    specimens_per_block=1,
    jitter=2e-6,
    asymmetry=0.08,
)
EVERYDAY = Condition(
    name="everyday",
    speed=Spread(0.10, 0.20),
    tip_radius=Spread(0.05, 0.20),
    pad_stiffness=Spread(0.10, 0.05),
    phalanx_mass=Spread(0.05, 0.08),
    link_stiffness=Spread(0.05, 0.10),
    gain=Spread(0.15, 0.02),
    clamp=Spread(0.30, 0.40),
    noise=Spread(0.30, 0.30),
    click_rate=1.5,
    mains_rates=(50.0, 60.0),
    temperature=Spread(0.08, 0.03),
    specimen_widen=1.5,
    specimens_per_block=3,
    jitter=8e-6,
    asymmetry=0.15,
)
CONDITIONS = {c.name: c for c in (PAPER_RIG, EVERYDAY)}


def condition(name: str) -> Condition:
    """Return the condition with this name.

    Raises
    ------
    InputError
        There is no such condition.
    """
    if name not in CONDITIONS:
        raise InputError(f"condition {name!r} is not known: use one of {', '.join(CONDITIONS)}")
    return CONDITIONS[name]
