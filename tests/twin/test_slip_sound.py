"""Tests of the modelled sound of a slip: it is silent without a slip and has no other effect."""

import numpy as np
import pytest

from firstcontact.core import Command
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.twin import BLOCKS, draw_pinch
from firstcontact.twin.draw import condition, draw_specimen
from firstcontact.twin.drive import Drive
from firstcontact.twin.mechanics import FingerParameters
from firstcontact.twin.outcome import Lift
from firstcontact.twin.plant import GraspPlant
from firstcontact.twin.slip_sound import SlipParameters, SlipSound

FINGERS = (FingerParameters(), FingerParameters())
MASS, FRICTION, N = 0.3, 0.5, 1000


def sound(parameters: SlipParameters = SlipParameters()) -> SlipSound:  # noqa: B008
    return SlipSound(FINGERS, MASS, FRICTION, parameters, np.random.default_rng(1))


def slip_signal(speed: float, force: float = 2.0, **changed: float) -> np.ndarray:
    forces, speeds = np.full((N, 2), force), np.full(N, speed)
    p = SlipParameters()._replace(**changed)  # type: ignore[arg-type]
    return sound(p).hear(forces, speeds, np.zeros(N))


def test_signal_is_proportional_to_the_coupling() -> None:
    signal, doubled = slip_signal(0.02, coupling=0.1), slip_signal(0.02, coupling=0.2)
    np.testing.assert_allclose(doubled, 2 * signal, rtol=1e-9, atol=1e-15)


def test_load_below_friction_only_shears_the_pad() -> None:
    """Under a slowly rising load the spring determines the pull on a patch. No patch slips."""
    slow = np.minimum(np.arange(10 * N) / (9 * N), 1.0)
    voice = sound()
    voice.hear(np.full((10 * N, 2), 20.0), np.zeros(10 * N), slow)
    assert (voice._patches[..., 2] == 1.0).all()
    shear = 0.5 * MASS * 9.81 / SlipParameters().stiffness
    np.testing.assert_allclose(voice._patches[..., 0], shear, rtol=1e-2)


def test_pieces_and_forks_give_the_same_signal() -> None:
    rng = np.random.default_rng(2)
    forces, speeds = rng.uniform(0.5, 3.0, (N, 2)), rng.uniform(0.0, 0.1, N)
    hanging = np.linspace(0, 1, N)
    expected = sound().hear(forces, speeds, hanging)
    voice = sound()
    parts = [voice.hear(forces[:300], speeds[:300], hanging[:300])]
    aside = voice.fork()
    aside.hear(forces[:100], speeds[:100], hanging[:100])
    parts.append(voice.hear(forces[300:], speeds[300:], hanging[300:]))
    np.testing.assert_array_equal(np.concatenate(parts), expected)


def lifted(slip: SlipParameters | None, force: float, cut: int) -> tuple[GraspPlant, np.ndarray]:
    rig = condition("paper-rig")
    block = draw_specimen(3, rig, BLOCKS[2], 0)
    draw = draw_pinch(3, rig, "one", block, "one")
    plant = GraspPlant(draw, Drive(), block, lift=Lift(0.2), slip=slip)
    data = [plant.advance(1000)]
    plant.command(Command(0.02, force))
    while not plant.ended:
        data.append(plant.advance(cut))
    return plant, np.concatenate(data)


@pytest.mark.parametrize(("force", "slips"), [(8.0, False), (0.7, True)])
def test_slip_sound_changes_only_the_piezos_during_a_slip(force: float, slips: bool) -> None:
    loud = SlipParameters(coupling=1.0)
    silent, silent_data = lifted(None, force, 50)
    plant, loud_data = lifted(loud, force, 50)
    assert plant.outcome == silent.outcome
    assert (plant.slipped > 0) is slips
    begin = round(0.19 * FINGERTIP_RATE) + plant.contacts[0].sample
    np.testing.assert_array_equal(loud_data[:begin], silent_data[:begin])
    assert (loud_data != silent_data).any(axis=0).tolist()[2:] == [False] * 14, (
        "the piezos alone hear it"
    )
    np.testing.assert_array_equal(loud_data, lifted(loud, force, 170)[1])
