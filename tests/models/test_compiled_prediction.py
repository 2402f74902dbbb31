"""Predictions of the compiled kernels equal NumPy's up to rounding."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compiled_kernels import built_kernels, using
from firstcontact.core import fingertip_layout
from firstcontact.models import (
    BEFORE,
    LONGEST,
    InContextModel,
    Rig,
    Touches,
    load_model,
    moments,
    shipped_model,
)
from firstcontact.models._combined import CombinedModel
from firstcontact.models._motor_pitch import MotorPitch, spectra
from firstcontact.signal import samples_in
from firstcontact.streaming import SHIPPED_HAND, twin_model

RATE = fingertip_layout().rate
LEAD, SAMPLES = samples_in(BEFORE, RATE), samples_in(LONGEST, RATE)


@pytest.fixture(scope="module")
def models() -> dict[str, InContextModel]:
    """Return the network with an unknown rig, with a known one, and with a regression."""
    unknown, combined = shipped_model().network, load_model(twin_model(*SHIPPED_HAND)).network
    assert unknown is not None
    assert combined is not None
    return {
        "unknown": unknown.model.conditioned_on({-1: Rig.unknown()}),
        "alone": combined.model.network_alone(),
        "combined": combined.model,
    }


class Spy(ModuleType):
    """The kernels, with the names of the functions that were used."""

    def __init__(self) -> None:
        super().__init__("spy")
        self.calls: list[str] = []

    def __getattr__(self, name: str) -> Any:
        self.calls.append(name)
        return getattr(built_kernels(), name)


class SoftModel(CombinedModel):
    """Model from another package, which predicts a constant."""

    def refine(self, *arguments: Any) -> Any:
        value, spread = super().refine(*arguments)
        return 0.0 * value + 7.0, spread


def contact(seed: int, finger: int, sign: float) -> Touches:
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES)
    signal = 10 ** rng.uniform(-4, -1) * rng.standard_normal(LEAD + SAMPLES)
    ring = np.exp(-t / rng.uniform(2, 40)) * np.sin(t / rng.uniform(2, 20))
    signal[LEAD:] += sign * 10 ** rng.uniform(-3, 1) * ring
    signals = signal.round(3)[None].astype(np.float32)
    return Touches.from_signals(signals, np.full(1, moments(RATE)[0]), np.full(1, finger), RATE)


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    finger=st.sampled_from([-1, 0, 1]),
    sign=st.sampled_from([-1.0, 0.0, 1.0]),
    name=st.sampled_from(["unknown", "alone", "combined"]),
)
def test_each_moment_is_that_of_numpy(
    models: dict[str, InContextModel], seed: int, finger: int, sign: float, name: str
) -> None:
    model, touches = models[name], contact(seed, finger, sign)
    with using(built_kernels()):
        compiled = copy.copy(model).follow(touches)
    with using(None):
        plain = model.follow(touches)
    assert compiled.is_compiled
    assert not plain.is_compiled
    np.testing.assert_allclose(compiled.features, plain.features, rtol=0, atol=1e-6)
    for samples in moments(RATE):
        a, b = (followed.predict(touches.waves[0], samples) for followed in (compiled, plain))
        assert a is not None
        assert b is not None
        np.testing.assert_allclose(a[:4], b[:4], rtol=1e-5, atol=2e-4)
        assert a.out_of_range == b.out_of_range


def test_a_dead_sensor_is_out_of_range(models: dict[str, InContextModel]) -> None:
    touches = contact(0, -1, 0.0)
    touches = replace(touches, signals=touches.signals * (np.arange(LEAD + SAMPLES) < LEAD))
    with using(built_kernels()):
        answer = copy.copy(models["unknown"]).follow(touches).predict(touches.waves[0], 40)
    assert answer is not None
    assert answer.out_of_range


@pytest.mark.parametrize("kind", [">f4", "<f8", "f4"])
def test_each_kind_of_number_gives_the_same_prediction(
    models: dict[str, InContextModel], kind: str
) -> None:
    touches = contact(2, 0, 1.0)
    wave = touches.waves[0]
    with using(built_kernels()):
        followed = copy.copy(models["combined"]).follow(touches)
        expected = followed.predict(wave, 20)
        assert followed.predict(wave[:30].astype(kind), 20) == expected
        assert followed.predict(np.repeat(wave, 2).astype(kind)[::2], 20) == expected


def test_a_subclass_refines_by_its_own_rule(models: dict[str, InContextModel]) -> None:
    touches = contact(2, 0, 1.0)
    model = copy.copy(models["combined"])
    model.__class__ = SoftModel
    with using(built_kernels()):
        followed = model.follow(touches)
        assert not followed.is_compiled
        answer = followed.predict(touches.waves[0], 20)
    assert answer is not None
    assert answer.value == 7.0


def test_a_signal_beyond_all_numbers_has_no_prediction(models: dict[str, InContextModel]) -> None:
    touches = contact(0, -1, 1.0)
    endless = np.where(np.arange(SAMPLES) == 5, np.inf, touches.waves[0]).astype(np.float32)
    with using(built_kernels()):
        followed = copy.copy(models["combined"]).follow(touches)
        assert followed.predict(endless, 20) is None


def test_a_model_that_was_used_can_be_pickled(models: dict[str, InContextModel]) -> None:
    touches = contact(1, 0, 1.0)
    with using(built_kernels()):
        model = copy.copy(models["combined"])
        expected = model.follow(touches).predict(touches.waves[0], 20)
        again = pickle.loads(pickle.dumps(model))
        assert again.follow(touches).predict(touches.waves[0], 20) == expected


@given(seed=st.integers(0, 2**32 - 1), tone=st.floats(80.0, 1000.0))
def test_the_pitch_is_that_of_numpy(seed: int, tone: float) -> None:
    rng = np.random.default_rng(seed)
    t = np.arange(LEAD + SAMPLES) / RATE
    harmonics = sum(np.sin(2 * np.pi * k * tone * t) / k for k in (1, 2, 3))
    signals = (0.01 * rng.standard_normal((4, len(t))) + 0.02 * harmonics).astype(np.float32)
    pitch = MotorPitch.fit(spectra(signals, LEAD, RATE))
    spy = Spy()
    with using(spy):
        pairs = [pitch.listen_to_one(signals[k : k + 1], LEAD, RATE) for k in range(4)]
    assert spy.calls.count("listen") == 4
    speed, alike = pitch.listen(spectra(signals, LEAD, RATE))
    np.testing.assert_allclose([float(p[0][0]) for p in pairs], speed, rtol=0, atol=1e-12)
    np.testing.assert_allclose([float(p[1][0]) for p in pairs], alike, rtol=0, atol=1e-12)
