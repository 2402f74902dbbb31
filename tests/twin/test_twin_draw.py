import numpy as np
import pytest
from pinches import EVERYDAY, PAPER_RIG, SEED, drawn
from scipy import stats

from firstcontact.core import InputError
from firstcontact.twin import BLOCKS, CONDITIONS
from firstcontact.twin.disc import CORNERS, VOLTS_PER_NEWTON, volts_per_newton
from firstcontact.twin.draw import (
    OFFSET_MAX,
    OFFSET_MEAN,
    OFFSET_SD,
    Condition,
    condition,
    draw_offset,
    draw_specimen,
    generator,
)
from firstcontact.twin.objects import EVERYDAY_OBJECTS


def test_offsets_are_positive_with_the_published_mean_and_spread() -> None:
    rng = np.random.default_rng(1)
    offsets = np.array([draw_offset(rng) for _ in range(20_000)])
    assert offsets.min() > 0
    assert offsets.max() < OFFSET_MAX
    assert offsets.mean() == pytest.approx(16.65e-3, abs=0.25e-3)
    assert offsets.std() == pytest.approx(10.35e-3, abs=0.25e-3)
    # A positive distribution with that mean and spread leans: about half are below 15 ms.
    assert 0.45 < (offsets < 15e-3).mean() < 0.6
    shape = (OFFSET_MEAN / OFFSET_SD) ** 2
    assert stats.kstest(offsets, stats.gamma(shape, scale=OFFSET_MEAN / shape).cdf).pvalue > 0.01


def test_pinch_depends_only_on_its_key() -> None:
    assert drawn(BLOCKS[1], 3).fingers == drawn(BLOCKS[1], 3).fingers
    assert drawn(BLOCKS[1], 3).fingers != drawn(BLOCKS[1], 4).fingers
    assert generator(1, "a", "b").random() != generator(1, "ab").random()
    assert generator(1, "a").random() != generator(2, "a").random()


def test_fingers_differ_and_are_constant_in_a_session() -> None:
    draws = [drawn(BLOCKS[1], 4 * i) for i in range(30)]
    for name in ("mount_stiffness", "gain", "phalanx_mass", "link_stiffness"):
        ratios = [getattr(d.fingers[0], name) / getattr(d.fingers[1], name) for d in draws]
        assert abs(np.log(ratios).mean()) > 0.005, name
        assert np.std(np.log(ratios)) < 1e-9, name


@pytest.mark.parametrize("name", ["speed", "tip_radius", "pad_stiffness", "link_stiffness"])
def test_everyday_pinches_vary_more_than_those_of_the_rig(name: str) -> None:
    def spread(c: Condition) -> float:
        values = [getattr(drawn(BLOCKS[0], i, c).fingers[0], name) for i in range(200)]
        return float(np.std(np.log(values)))

    assert spread(EVERYDAY) > 2 * spread(PAPER_RIG)


def test_specimens_have_the_scatter_of_their_object() -> None:
    apple = EVERYDAY_OBJECTS[0]
    logs = [
        np.log(draw_specimen(SEED, PAPER_RIG, apple, i).nominal.modulus / apple.nominal.modulus)
        for i in range(2000)
    ]
    # Cut off at 2.5 standard deviations.
    assert np.std(logs) == pytest.approx(apple.modulus_scatter, rel=0.06)
    assert np.abs(logs).max() <= 2.5 * apple.modulus_scatter * 1.0001


def test_unknown_condition_is_refused_with_the_choices() -> None:
    with pytest.raises(InputError, match=r"'lab'.*paper-rig, everyday"):
        condition("lab")
    assert list(CONDITIONS) == ["paper-rig", "everyday"]


def test_volts_per_newton_are_those_of_the_loaded_taxels() -> None:
    for taxel, volts in enumerate(VOLTS_PER_NEWTON):
        alone = np.eye(6)[taxel]
        assert volts_per_newton(alone) == volts
        factor = 1.0 if taxel in (2, 3) else 0.5
        assert volts_per_newton(alone, 0.5) == pytest.approx(factor * volts)
    draws = [drawn(BLOCKS[0], number) for number in range(20)]
    for hand in range(2):
        volts = [d.fingers[hand].piezo_volts_per_newton for d in draws]
        edges = [[volts_per_newton(d.shares[hand], c) for c in CORNERS] for d in draws]
        assert all(low <= v <= high for v, (low, high) in zip(volts, edges, strict=True))
        assert len(set(volts)) == len(draws)
