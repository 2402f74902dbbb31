"""Predictions of the chain equal those of the reference up to rounding."""

import math
import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import touch_reference as reference
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.chain import EventKind, Flag, Image, build_image
from firstcontact.chain.constants import DetectorKind, Layer, Matrix, ModelConstants
from firstcontact.chain.touch import (
    HINTS,
    INPUTS,
    predict_inputs,
    predict_touches,
    shifts,
    spectra,
    touch_inputs,
)
from firstcontact.core import InputError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.quantity import SHORE_A, STIFFNESS, Quantity
from firstcontact.models import Spec, Task, load_model
from firstcontact.models.anytime import Hints
from firstcontact.models.interval import Interval
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig, RigSpeeds
from firstcontact.models.windows.svm import SvmModel
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.signal import SavitzkyGolay
from firstcontact.signal.windowing import cut_window
from firstcontact.streaming.twin import SHIPPED
from firstcontact.testing.synthetic import RATE
from random_chains import FLOOR, Stream, python_events, random_image, random_stream
from ringing import ringing

LEAD, SAMPLES = 197, 74


@cache
def models() -> dict[str, RigModel]:
    """Return the network with an unknown rig, with a known one, and with a regression."""
    network = load_model(SHIPPED).network
    assert network is not None
    known, shore_a, _ = ringing(60)
    rig = Rig.fit(known, shore_a)
    quick = replace(rig, speeds=RigSpeeds(0.13, 0.3, 0.1))
    return {
        "unknown": pretrained(),
        "deaf": pretrained().conditioned_on({Rig.ANY: replace(rig, pitch=None)}),
        "alone": pretrained().conditioned_on({Rig.ANY: rig}),
        "speeds": pretrained().conditioned_on({Rig.ANY: quick, 1: replace(quick, sign=-1.0)}),
        "combined": network,
    }


def contact(seed: int, sign: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES)
    signal = 10 ** rng.uniform(-4, -1) * rng.standard_normal(LEAD + SAMPLES)
    ring = np.exp(-t / rng.uniform(2, 40)) * np.sin(t / rng.uniform(2, 20))
    signal[LEAD:] += sign * 10 ** rng.uniform(-3, 1) * ring
    return signal.round(3).astype(np.float32)


def ask(
    image: Image, signal: np.ndarray, valid: int, finger: int = -1, *hints: float
) -> np.ndarray:
    speed, error, radius = (np.full(1, x) for x in (*hints, *[math.nan] * (3 - len(hints))))
    one = np.full(1, valid), np.full(1, finger)
    return predict_touches(image, signal[None], *one, speed, error, radius)[0]


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    sign=st.sampled_from([-1.0, 0.0, 1.0]),
    name=st.sampled_from(["unknown", "deaf", "alone", "speeds", "combined"]),
    finger=st.sampled_from([-1, 0, 1]),
    valid=st.integers(2, SAMPLES),
    speed=st.sampled_from([math.nan, 0.05, 0.2, 3.0]),
    error=st.sampled_from([math.nan, 0.001, 0.2, math.inf]),
    radius=st.sampled_from([math.nan, 0.01, math.inf]),
)
def test_predictions_are_those_of_the_reference(
    seed: int,
    sign: float,
    name: str,
    finger: int,
    valid: int,
    speed: float,
    error: float,
    radius: float,
) -> None:
    model, signal = models()[name], contact(seed, sign)
    constants = model.chain_constants()
    rigs = {rig.finger: rig for rig in constants.rigs}
    rig = rigs.get(finger, rigs[-1])
    out = ask(model.image, signal, valid, finger, speed, error, radius)
    expected = reference.predict(constants, rig, signal, valid, speed, error, radius)
    np.testing.assert_allclose(out[:5], expected[:5], rtol=2e-3, atol=0.02)
    assert out[5] == expected[5]


@pytest.mark.parametrize("name", ["alone", "speeds"])
def test_predictions_with_the_pitch_of_a_motor_are_those_of_the_reference(name: str) -> None:
    model = models()[name]
    m = model.chain_constants()
    touches, _, _ = ringing(20, seed=3)
    for row, signal in enumerate(touches.signals):
        hints = (math.nan, math.nan, math.nan) if row % 2 else (0.15, 0.2, 0.02)
        out = ask(model.image, signal, 12 + 3 * row, -1, *hints)
        before = signal[:LEAD].astype(np.float64)
        assert reference.hints(m, m.rigs[0], before, *hints)[1] == 1.0  # the motor is heard
        expected = reference.predict(m, m.rigs[0], signal, 12 + 3 * row, *hints)
        np.testing.assert_allclose(out[:5], expected[:5], rtol=2e-3, atol=0.02)


def test_traits_of_a_triangle_in_closed_form() -> None:
    top = 10
    rise = np.arange(top + 1) / top
    wave = np.concatenate([np.zeros(LEAD), rise, rise[-2::-1], np.zeros(SAMPLES - 2 * top - 1)])
    one = np.ones(1)
    _, traits = touch_inputs(wave[None], 74 * one, LEAD, one, one, np.zeros((1, HINTS)))
    found = dict(zip(reference.NAMES, traits[0], strict=True))
    assert found["peak"] == pytest.approx(0.0, abs=1e-7)
    assert found["steepest rise"] == pytest.approx(np.log(1 / top))
    assert found["time to peak"] == pytest.approx(top / 20 - 1)
    assert found["width at half"] == pytest.approx((top - 1) / 20 - 0.5)
    assert found["centre of energy"] == pytest.approx(top / 20 - 1, abs=1e-6)
    assert found["undershoot"] == 0.0
    assert found["length"] == 1.0


@given(
    seed=st.integers(0, 2**32 - 1),
    valid=st.integers(2, SAMPLES),
    level=st.floats(1e-3, 10.0),
    sign=st.sampled_from([-1.0, 1.0]),
)
def test_inputs_are_those_of_the_reference(
    seed: int, valid: int, level: float, sign: float
) -> None:
    signal, hints = contact(seed, sign), np.arange(HINTS) / 4
    scales = np.full(1, level), np.full(1, sign)
    x, traits = touch_inputs(signal[None], np.full(1, valid), LEAD, *scales, hints[None])
    after = sign * signal[LEAD : LEAD + valid].astype(np.float64)
    expected = reference.traits(signal[:LEAD].astype(np.float64), after, level)
    np.testing.assert_allclose(traits[0], expected, rtol=1e-6, atol=1e-6)
    expected_inputs = reference.inputs(after, level, expected, hints)
    np.testing.assert_allclose(x[0], expected_inputs, rtol=1e-5, atol=1e-5)


@given(seed=st.integers(0, 2**32 - 1), tone=st.floats(80.0, 1000.0))
def test_pitches_are_those_of_the_reference(seed: int, tone: float) -> None:
    rng = np.random.default_rng(seed)
    m = models()["alone"].chain_constants()
    t = np.arange(LEAD) / FINGERTIP_RATE
    turns = 2 * np.pi * tone * np.exp([[0.0], [0.1]])
    volts = 0.003 * rng.standard_normal((2, LEAD)) + sum(
        0.02 * np.sin(k * turns * t) for k in (1, 2, 3)
    )
    signals = volts.astype(np.float32)
    heard = spectra(signals[:, : len(m.fade)], m.sine, m.fade, m.part, m.cell)
    expected = [reference.spectrum(m, s.astype(np.float64)) for s in signals]
    np.testing.assert_allclose(heard, expected, atol=2e-3)
    shift, alike = shifts(heard, heard[0])
    assert (shift[0], alike[0]) == (0, pytest.approx(1.0, abs=1e-5))
    best, fit = reference.pitch(heard[1].astype(np.float64), heard[0].astype(np.float64))
    assert (shift[1], alike[1]) == (best, pytest.approx(fit, abs=1e-4))


def test_the_network_alone_is_that_of_the_reference() -> None:
    model, rng = pretrained(), np.random.default_rng(0)
    m = model.chain_constants()
    x = (m.mean + m.sd * 3 * rng.standard_normal((50, INPUTS))).astype(np.float32)
    terms = rng.standard_normal((50, model.network.directions)).astype(np.float32)
    expected = [reference.network(m, term, one) for term, one in zip(terms, x, strict=True)]
    np.testing.assert_allclose(predict_inputs(model.image, x, terms), expected, rtol=1e-3)


@pytest.mark.parametrize("far", [1e30, -1e30, np.inf, np.nan])
def test_inputs_that_are_far_out_give_finite_predictions(far: float) -> None:
    model = pretrained()
    terms = np.zeros((1, model.network.directions))
    assert np.isfinite(predict_inputs(model.image, np.full((1, INPUTS), far), terms)).all()


def test_a_dead_sensor_is_out_of_range() -> None:
    signal = np.where(np.arange(LEAD + SAMPLES) < LEAD, contact(0), 0.0).astype(np.float32)
    assert ask(models()["unknown"].image, signal, 40)[5] == 1


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["unknown", "alone", "combined"])
def test_a_signal_beyond_all_numbers_has_no_prediction(name: str, value: float) -> None:
    signal = contact(1)
    signal[LEAD + 5] = value
    assert np.isnan(ask(models()[name].image, signal, 20)[0])


@pytest.mark.parametrize("valid", [-1, 0, 1, SAMPLES + 1])
def test_numbers_of_samples_out_of_range_are_refused(valid: int) -> None:
    with pytest.raises(ValueError, match="74"):
        ask(models()["alone"].image, contact(1), valid)


@pytest.mark.parametrize("kind", [">f4", "<f8", "f4"])
def test_each_kind_of_number_gives_the_same_prediction(kind: str) -> None:
    image, signal = models()["combined"].image, contact(2)
    expected = ask(image, signal, 20)
    np.testing.assert_array_equal(ask(image, signal.astype(kind), 20), expected)
    twice = np.repeat(signal, 2).astype(kind)[::2]
    np.testing.assert_array_equal(ask(image, twice, 20), expected)


def test_a_model_that_was_used_can_be_pickled() -> None:
    model, signal = models()["combined"], contact(1)
    expected = ask(model.image, signal, 20)
    again: RigModel = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(ask(again.image, signal, 20), expected)


def test_no_contacts_give_no_predictions() -> None:
    empty = np.zeros((0, LEAD + SAMPLES)), *(np.zeros(0) for _ in range(5))
    assert predict_touches(models()["alone"].image, *empty).shape == (0, 6)


def check(image: Image) -> None:
    assert image.handle


def changed(m: ModelConstants, matrix: Matrix) -> ModelConstants:
    layer = replace(m.layers[0], into=matrix)
    return replace(m, layers=[layer, *m.layers[1:]])


def test_numbers_that_could_overflow_are_refused() -> None:
    m = pretrained().chain_constants()
    first: Layer = m.layers[0]
    wide = np.full_like(first.into.weight, 32_000)
    for matrix in (
        replace(first.into, weight=wide),
        replace(first.into, scale=np.full_like(first.into.scale, 1e28)),
    ):
        with pytest.raises(InputError):
            check(build_image(FINGERTIP_RATE, model=changed(m, matrix)))
    rig = replace(m.rigs[0], terms=np.full_like(m.rigs[0].terms, 1e7))
    with pytest.raises(InputError):
        check(build_image(FINGERTIP_RATE, model=replace(m, rigs=[rig])))


@pytest.mark.parametrize("place", [0, 4, 9, 40, 2000, -1])
def test_a_damaged_image_is_refused(place: int) -> None:
    data = bytearray(models()["combined"].image.data)
    data[place] ^= 1
    with pytest.raises(InputError):
        check(Image(bytes(data)))
    with pytest.raises(InputError):
        check(Image(bytes(data[:place])))


def touches(rng: np.random.Generator) -> Stream:
    """Return a closing whose second finger touches near the model's last moment; some have NaN."""
    data = 4 * rng.normal(0.0, FLOOR, (500, 2)).astype(np.float32)
    for at, finger in zip((300, 300 + rng.integers(40, 90)), rng.permutation(2), strict=True):
        data[at:, finger] += 0.3 * np.sin(0.2 * np.arange(500 - at))
    if rng.random() < 0.3:
        data[rng.integers(300, 400), 0] = np.nan
    return Stream([(0, 0, data)], 0, False, 1.0, (0.0, 0.1, np.nan))


def test_each_contact_has_one_final_event() -> None:
    rng, estimated = np.random.default_rng(8), 0
    for seed in range(4):
        image = random_image(seed)
        for _ in range(150):
            finals, used, first = 0, 0, -1
            for e in python_events(image, touches(rng)):
                if e.flags & Flag.FINAL:
                    finals, used = finals + 1, e.samples
                elif e.kind == EventKind.CONTACT_FOUND and e.flags & Flag.FIRST:
                    finals, used, first = 0, 0, e.sample
                elif e.kind == EventKind.CONTACT_FOUND and finals:
                    assert e.sample >= first + used  # so that the final estimate stands
                elif e.kind == EventKind.ESTIMATED:
                    assert not finals
                elif e.kind == EventKind.CONTACT_WITHDRAWN:
                    first = -1
                elif e.kind == EventKind.CLOSING_ENDED and first >= 0:
                    assert finals == 1
                    estimated += used > 0
                    first = -1
    assert estimated > 20


WINDOW = 74


def predictor(classes: tuple[float, ...] = (), quantity: Quantity = SHORE_A) -> WindowPredictor:
    rng = np.random.default_rng(0)
    task = Task.CLASSIFICATION if classes else Task.REGRESSION
    rows, one = len(classes) * (len(classes) - 1) // 2 or 1, np.array([0.0, 1.0])
    vectors = rng.standard_normal((40, WINDOW + 1))
    weights, bias = rng.standard_normal((rows, 40)), rng.standard_normal(rows)
    parameters = np.array([1.0, 0.3 / WINDOW, 0.1])
    target = np.array([45.0, 20.0])
    model = SvmModel(
        Spec(task, RATE, WINDOW, 1, classes), one, vectors, weights, bias, target, parameters
    )
    interval = Interval(0.9, (40.0, 50.0), (1.0, 2.5, 60.0))
    if quantity.is_logarithmic:
        model.target, interval = (2.0, 0.8), Interval(0.9, (1.5,), (0.1, 0.4), quantity.limits)
    return WindowPredictor(model, interval, quantity=quantity)


@pytest.mark.parametrize(
    ("classes", "quantity"),
    [((), SHORE_A), ((10.0, 29.0, 43.0), SHORE_A), ((), STIFFNESS), ((5.0, 45.0), STIFFNESS)],
    ids=["svr", "svc", "svr of a logarithm", "svc of N/mm"],
)
@given(
    seed=st.integers(0, 1000),
    lead=st.integers(0, 150),
    fault=st.sampled_from([None, np.nan, np.inf, 1e300]),
)
def test_a_signal_gives_the_prediction_of_its_window(
    classes: tuple[float, ...], quantity: Quantity, seed: int, lead: int, fault: float | None
) -> None:
    asked = predictor(classes, quantity)
    rng = np.random.default_rng(seed)
    signal = 10 ** rng.uniform(-6, 2) * rng.normal(rng.normal(), 1.0, lead + WINDOW + 2)
    if fault is not None:
        signal[rng.integers(len(signal))] = fault
    made = asked.predict(signal, WINDOW, 0, Hints())
    with np.errstate(invalid="ignore", over="ignore"):
        window = cut_window(SavitzkyGolay().update(signal[:, None])[:, 0], lead, WINDOW, RATE)
    if window is None or not np.isfinite(window).all():
        assert made is None
        return
    value, _, low, high = (float(a[0]) for a in asked.predict_windows(window[None]))
    np.testing.assert_allclose(made[:3], (value, low, high), rtol=1e-4)


@pytest.mark.parametrize("kind", ["svr", "svc"])
def test_signals_without_quiet_or_swing_have_no_prediction(kind: str) -> None:
    asked = predictor(() if kind == "svr" else (10.0, 29.0))
    assert asked.predict(np.ones(200), WINDOW, 0, Hints()) is None
    assert asked.predict(np.arange(WINDOW + 2.0), WINDOW, 0, Hints()) is None


def test_a_chain_emits_what_each_window_gives() -> None:
    """Estimates come with the samples of their moments: window and look-ahead of the filter."""
    image = random_image(0, DetectorKind.THRESHOLD, "svr")
    rng = np.random.default_rng(0)
    events = [e for _ in range(60) for e in python_events(image, random_stream(rng))]
    made = [e for e in events if e.samples > 0]
    assert {e.samples for e in made} == {25, 74}
    for e in made:
        assert e.known >= e.sample + e.samples + 1
        assert (e.samples == 74) == (e.low == e.value == e.high)
