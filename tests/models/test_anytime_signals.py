"""The network: its arrays, what a rig adds, and which changes of a signal matter."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.chain.touch import HINTS
from firstcontact.core import Contact, Dataset, Finger, InputError, Pinch, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.models import Touches
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.context_network import ContextNetwork
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.models.values import Values
from ringing import LONGEST, SHORTEST, ringing

KNOWN, SHORE_A, _ = ringing(60)
ASKED, TRUTH, _ = ringing(40, seed=2, levels=(15.0, 25.0, 50.0))
ENDS = np.random.default_rng(1).integers(SHORTEST, LONGEST + 1, len(ASKED))


def knowing(touches: Touches, shore_a: Values = SHORE_A) -> RigModel:
    return pretrained().conditioned_on({Rig.ANY: Rig.fit(touches, shore_a)})


def scaled(touches: Touches, gain: float) -> Touches:
    return replace(touches, signals=(gain * touches.signals).astype(np.float32))


def spoilt(touches: Touches, with_: float) -> Touches:
    signals = touches.signals.copy()
    for row, end in enumerate(touches.valid):
        signals[row, touches.lead + end :] = with_
    return replace(touches, signals=signals)


@pytest.mark.parametrize("gain", [0.5, 20.0])
def test_answers_do_not_depend_on_the_gain_of_the_rig(gain: float) -> None:
    plain = knowing(KNOWN).predict_touches(ASKED)
    loud = knowing(scaled(KNOWN, gain)).predict_touches(scaled(ASKED, gain))
    # What the converter could not tell from silence is added to spectra: they are near, not equal.
    assert np.allclose(plain.value, loud.value, atol=0.5)
    assert np.allclose(plain.spread, loud.spread, atol=0.5)


def test_a_disc_that_is_wired_backwards_gives_the_same_answers() -> None:
    plain = knowing(KNOWN).predict_touches(ASKED)
    backwards = knowing(scaled(KNOWN, -1.0)).predict_touches(scaled(ASKED, -1.0))
    assert np.allclose(plain.value, backwards.value)
    assert np.array_equal(plain.out_of_range, backwards.out_of_range)


@pytest.mark.parametrize("with_", [np.nan, np.inf, 1e30, -1e30])
def test_samples_after_the_valid_ones_are_never_used(with_: float) -> None:
    conditioning = replace(KNOWN, valid=np.resize(ENDS, len(KNOWN)))
    queries = replace(ASKED, valid=ENDS)
    plain = knowing(conditioning).predict_touches(queries)
    other = knowing(spoilt(conditioning, with_)).predict_touches(spoilt(queries, with_))
    for name in ("value", "spread", "low", "high", "out_of_range"):
        assert np.array_equal(getattr(plain, name), getattr(other, name))
        assert np.isfinite(getattr(plain, name)).all()


def test_another_rate_and_too_few_samples_are_refused() -> None:
    with pytest.raises(InputError, match="resample"):
        knowing(KNOWN).predict_touches(replace(ASKED, rate=2000.0))
    with pytest.raises(InputError, match="wait for more"):
        knowing(KNOWN).predict_touches(ASKED.until(SHORTEST - 1))
    with pytest.raises(InputError, match="Shore A"):
        Rig.fit(KNOWN.take(np.zeros(len(KNOWN), np.bool_)), SHORE_A[:0])


def test_a_told_speed_stands_for_the_one_that_is_heard() -> None:
    slow, usual = (replace(ASKED, speeds=np.full(len(ASKED), v)) for v in (0.05, 0.1))
    speeds = np.resize([0.05, 0.1, 0.2], len(KNOWN))
    rig = Rig.fit(replace(KNOWN, speeds=speeds), SHORE_A)
    assert rig.speeds is not None
    rig = replace(rig, speeds=replace(rig.speeds, heard_error=np.inf))
    model = pretrained().conditioned_on({Rig.ANY: rig})
    assert rig.speeds.usual == pytest.approx(0.1)
    labelled_contacts = [model.inputs(t)[:, -HINTS:][0, 0] for t in (usual, slow)]
    assert labelled_contacts == pytest.approx([0.0, 4 * np.log(0.5)], rel=0.01, abs=1e-6)


def test_a_cut_has_its_baseline_off_and_zeros_where_nothing_is_yet() -> None:
    rate = FINGERTIP_RATE
    lead, tail = KNOWN.lead, Touches.lengths(rate)[1]
    volts = 1.5 + np.concatenate([np.zeros(lead + 50), np.ones(100)])
    complete = Touches.cut_signal(volts, lead + 50, rate)
    assert complete[:lead] == pytest.approx(0.0)
    assert complete[lead:] == pytest.approx(1.0)
    part = Touches.cut_signal(volts[: lead + 70], lead + 50, rate)
    assert part[lead : lead + 20] == pytest.approx(1.0)
    assert (part[lead + 20 :] == 0).all()
    assert len(part) == lead + tail
    for bad in (volts[: lead + 50 + SHORTEST - 1], np.full(len(volts), np.nan), np.ones(500)):
        assert Touches.cut_signal(bad, lead + 50, rate) is None
    assert Touches.cut_signal(volts, lead - 1, rate) is None


def test_moments_are_whole_milliseconds_from_2_to_15() -> None:
    assert Touches.all_lengths(1000.0) == tuple(range(2, 16))
    assert Touches.all_lengths(FINGERTIP_RATE)[::13] == (10, 74)


@pytest.mark.parametrize("apart", [-20, 0, 1, 30, 200])
def test_nothing_is_valid_from_the_second_contact_on(apart: int) -> None:
    layout = fingertip_layout()
    data = np.random.default_rng(0).integers(16_000, 17_000, (700, len(layout.channels)))
    truth = (Contact(Finger.INDEX, 380, 380), Contact(Finger.THUMB, 400, 400))
    pinch = Pinch(data.astype(np.int16), layout, truth=truth)
    contacts = Contact(Finger.INDEX, 400 - apart, 420)
    touches, _ = Touches.cut(Dataset((pinch,)), [contacts])
    assert touches.valid.tolist() == [min(max(apart, 0), Touches.lengths(layout.rate)[1])]


ARRAYS = pretrained().network.to_arrays()


def test_the_order_of_the_levels_does_not_matter() -> None:
    rng = np.random.default_rng(3)
    tokens, general = (
        rng.standard_normal((len(Rig.STAGES), 5, Rig.TOKEN)),
        rng.standard_normal(Rig.GENERAL),
    )
    network = ContextNetwork(ARRAYS)
    one, other = (network.rig_term(t, general) for t in (tokens, tokens[:, ::-1]))
    assert one.shape == (len(Rig.STAGES), network.directions)
    assert one == pytest.approx(other, abs=1e-4)


@pytest.mark.parametrize("levels", [0, 1, 8])
@pytest.mark.parametrize("far", [1e30, -1e30])
def test_rigs_that_are_far_out_stay_finite(levels: int, far: float) -> None:
    term = ContextNetwork(ARRAYS).rig_term(
        np.full((len(Rig.STAGES), levels, Rig.TOKEN), far), np.full(Rig.GENERAL, far)
    )
    assert np.isfinite(term).all()


def test_arrays_are_given_back() -> None:
    again = ContextNetwork(ARRAYS).to_arrays()
    assert again.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        assert again[name].dtype == array.dtype
        np.testing.assert_array_equal(array, again[name])


@pytest.mark.parametrize("name", ARRAYS)
def test_every_array_is_required_and_checked(name: str) -> None:
    array = ARRAYS[name]
    for bad in (array[:-1], array * np.nan, array[None]):
        with pytest.raises(InputError):
            ContextNetwork({**ARRAYS, name: bad})
    with pytest.raises(InputError, match="missing"):
        ContextNetwork({n: a for n, a in ARRAYS.items() if n != name})
