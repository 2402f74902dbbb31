"""The network in C gives the same estimates as in Python, natively and on the emulated board."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import building
import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, make_detector
from firstcontact.core import InputError
from firstcontact.export import Trained
from firstcontact.export import _c_library as c_library
from firstcontact.export._model_image import model_image
from firstcontact.models import (
    ANY,
    CompactModel,
    InContextModel,
    Rig,
    Touches,
    compacted,
    moments,
    pretrained,
    spectra,
)
from firstcontact.models._motor_pitch import BELIEVED
from firstcontact.testing import closings
from saved import load_network, save_network

RATE = 4936.0
MOMENTS = moments(RATE)


def touches(n: int, seed: int) -> Touches:
    """Return contacts of three hardnesses in noise. Some end before 15 ms."""
    rng = np.random.default_rng(seed)
    t = np.arange(74) / RATE
    hard = rng.choice([10.0, 35.0, 60.0], n)
    swing = np.sin(2 * np.pi * (60 + 4 * hard)[:, None] * t) * np.exp(-t / 0.010)
    signals = 0.004 * rng.standard_normal((n, 271))
    signals[:, -74:] += (0.1 + 0.01 * hard * rng.uniform(0.8, 1.2, n))[:, None] * swing
    return Touches(
        signals[:, -(197 + 74) :].astype(np.float32),
        rng.integers(12, 75, n),
        rng.integers(0, 2, n),
        np.full(n, np.nan),
        np.full(n, np.nan),
        hard,
        RATE,
    )


def conditioned() -> InContextModel:
    conditioning = touches(60, 1)
    rig = Rig.fit(replace(conditioning, radii=np.full(60, np.nan)), conditioning.radii)
    return pretrained().conditioned_on({ANY: rig})


def plain(sample: Touches) -> Touches:
    return replace(sample, radii=np.full(len(sample), np.nan))


def build(model: InContextModel, folder: Path) -> building.Program:
    folder.mkdir()
    c_library.write(Trained(anytime=model), folder)
    return building.Program("touches.c", folder / "src", {})


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> building.Program:
    """Program in C of a compact network, whose inputs are reduced to 8 directions."""
    model = compacted(conditioned(), plain(touches(60, 1)), 8)
    return build(model, tmp_path_factory.mktemp("small") / "library")


def assert_parity(model: InContextModel, sample: Touches, got: NDArray[np.void]) -> None:
    place = 0
    for k in range(len(sample)):
        for samples in [m for m in MOMENTS if m <= sample.valid[k]]:
            wanted = model.predict(sample.take(np.array([k])).until(samples))
            record = got[place]
            place += 1
            assert (record["samples"], record["status"]) == (samples, 0)
            assert bool(record["strange"]) == wanted.out_of_range[0]
            ends = [record["value"], record["low"], record["high"]]
            expected = [wanted.value[0], wanted.low[0], wanted.high[0]]
            np.testing.assert_allclose(ends, expected, atol=0.01)
    assert place == len(got)


def test_c_answers_as_python_does(tmp_path: Path) -> None:
    model = compacted(conditioned(), plain(touches(60, 1)), 12)
    sample = plain(touches(12, 2))
    data = building.touches(sample.signals, sample.valid, sample.fingers, MOMENTS)
    built = build(model, tmp_path / "library")
    native = building.ask_native(built.native(tmp_path / "native", strict=True), data, tmp_path)
    c_outputs = np.frombuffer(native, building.RUNNING)
    assert_parity(model, sample, c_outputs)
    if building.has_emulator():
        m7 = building.ask_m7(built.m7(tmp_path / "m7.elf"), data, tmp_path)
        assert building.same(c_outputs, np.frombuffer(m7, building.RUNNING))


def test_c_that_knows_no_rig_calls_the_same_contacts_strange(tmp_path: Path) -> None:
    """Without a known rig the gain is unknown, so both must estimate it."""
    model = compacted(pretrained(), plain(touches(60, 1)), 12)
    sample = plain(touches(24, 2))
    noise = np.random.default_rng(3).standard_normal((8, 74)).astype(np.float32)
    sample.signals[:8, -74:] += 0.3 * noise
    sample.signals[16:] *= np.float32(3)
    data = building.touches(sample.signals, sample.valid, sample.fingers, MOMENTS)
    built = build(model, tmp_path / "library")
    native = building.ask_native(built.native(tmp_path / "native", strict=True), data, tmp_path)
    c_outputs = np.frombuffer(native, building.RUNNING)
    assert_parity(model, sample, c_outputs)
    assert 0 < c_outputs["strange"].mean() < 1


def with_motor(sample: Touches, seed: int) -> Touches:
    """Return motor noise with lines at 0.5 to 1.5 times their usual frequency."""
    rng = np.random.default_rng(seed)
    t = np.arange(sample.signals.shape[1]) / RATE
    turns = 2 * np.pi * 220 * rng.uniform(0.6, 1.5, len(sample))[:, None] * t
    sound = 0.03 * np.sin(turns) + 0.02 * np.sin(2 * turns + 1) + 0.02 * np.sin(5 * turns)
    return replace(sample, signals=(sample.signals + sound).astype(np.float32))


def test_c_hears_the_motor_as_python_does(tmp_path: Path) -> None:
    conditioning = with_motor(touches(60, 1), 5)
    nothing = np.full(60, np.nan)
    rig = Rig.fit(replace(conditioning, radii=nothing), conditioning.radii)
    reference_model = pretrained().conditioned_on({ANY: rig})
    model = compacted(reference_model, plain(conditioning), 12, listening=True)
    sample = plain(with_motor(touches(12, 2), 6))
    speed, alike = rig.pitch.listen(spectra(sample.signals, sample.lead, RATE))  # type: ignore[union-attr]
    assert (alike > BELIEVED).sum() > 6
    assert np.ptp(speed[alike > BELIEVED]) > 0.3
    data = building.touches(sample.signals, sample.valid, sample.fingers, MOMENTS)
    built = build(model, tmp_path / "library")
    native = building.ask_native(built.native(tmp_path / "native", strict=True), data, tmp_path)
    c_outputs = np.frombuffer(native, building.RUNNING)
    assert_parity(model, sample, c_outputs)
    if building.has_emulator():
        m7 = building.ask_m7(built.m7(tmp_path / "m7.elf"), data, tmp_path)
        assert building.same(c_outputs, np.frombuffer(m7, building.RUNNING))


def test_a_signal_that_is_no_number_or_stands_still_is_refused(
    small: building.Program, tmp_path: Path
) -> None:
    sample = plain(touches(3, 3))
    sample.signals[0, 210], sample.signals[1], sample.signals[2, 3] = np.nan, 0.25, np.inf
    sample.valid[:] = 74
    data = building.touches(sample.signals, sample.valid, sample.fingers, MOMENTS)
    native = building.ask_native(small.native(tmp_path / "native", strict=True), data, tmp_path)
    status = np.frombuffer(native, building.RUNNING)["status"].reshape(3, -1)
    original = [m < 210 - 197 + 1 for m in MOMENTS]
    np.testing.assert_array_equal(status[0] == 0, original)  # what is not there yet harms nothing
    assert (status[1:] == 1).all()


def test_signals_at_the_end_of_what_floats_hold_are_defined_and_alike(
    small: building.Program, tmp_path: Path
) -> None:
    sample = plain(touches(4, 3))
    sample.signals[0] *= 1e38
    sample.signals[1, 200:] = -3.4e38
    sample.signals[2, :200] = 3.4e38
    sample.signals[3] *= 1e-42
    sample.valid[:] = 74
    data = building.touches(sample.signals, sample.valid, sample.fingers, MOMENTS)
    native = building.ask_native(small.native(tmp_path / "native", strict=True), data, tmp_path)
    c_outputs = np.frombuffer(native, building.RUNNING)
    assert len(c_outputs) == 4 * len(MOMENTS)
    answered = c_outputs["status"] == 0
    assert np.isfinite(c_outputs["value"][answered]).all()
    if building.has_emulator():
        m7 = building.ask_m7(small.m7(tmp_path / "m7.elf"), data, tmp_path)
        assert building.same(c_outputs, np.frombuffer(m7, building.RUNNING))


def test_a_network_that_was_not_made_small_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--data"):
        c_library.write(Trained(anytime=conditioned()), tmp_path)


def test_few_touches_are_refused() -> None:
    with pytest.raises(InputError, match="too few"):
        compacted(conditioned(), plain(touches(10, 1)), 8)


def test_more_directions_are_nearer_to_the_network() -> None:
    model, sample = conditioned(), plain(touches(60, 4)).until(40)
    sample = sample.take(sample.valid >= 10)
    complete = model.predict(sample).value
    away = [
        np.abs(compacted(model, plain(touches(60, 1)), n).predict(sample).value - complete).mean()
        for n in (4, 48)
    ]
    assert away[1] < away[0]


def test_a_compact_model_is_kept_and_its_image_does_not_change_any_more(tmp_path: Path) -> None:
    sample = plain(touches(60, 1))
    model = compacted(conditioned(), sample, 8)
    save_network(model, tmp_path)
    answers, again = (m.predict(sample) for m in (model, load_network(tmp_path)))
    np.testing.assert_allclose(again.value, answers.value, atol=1e-3)
    np.testing.assert_array_equal(again.out_of_range, answers.out_of_range)
    once, twice = load_network(tmp_path), tmp_path / "twice"
    save_network(once, twice)
    detector = make_detector(DETECTORS.default).fit(closings(24))
    images = [model_image(detector, m, None) for m in (once, load_network(twice))]
    assert images[0] == images[1]


def test_weights_that_are_no_integers_are_refused() -> None:
    arrays = compacted(conditioned(), plain(touches(60, 1)), 8).to_arrays()
    arrays["thin.body1.into.weight"] = arrays["thin.body1.into.weight"] + np.float32(0.5)
    with pytest.raises(InputError, match=r"thin\.body1\.into\.weight"):
        CompactModel.from_arrays(arrays, 0.9)
    del arrays["thin.body1.into.weight"]
    with pytest.raises(InputError, match="missing"):
        CompactModel.from_arrays(arrays, 0.9)


def test_weights_of_half_precision_are_checked_without_an_overflow() -> None:
    arrays = compacted(conditioned(), plain(touches(60, 1)), 8).to_arrays()
    name = "thin.body1.into.weight"
    arrays[name] = np.full(arrays[name].shape, 32_000.0, np.float16)
    with pytest.raises(InputError, match=r"thin\.body1\.into\.weight"):
        CompactModel.from_arrays(arrays, 0.9)
