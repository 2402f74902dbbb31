"""Predictions of NumPy for one growing contact equal the model's for many contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from compiled_kernels import using
from firstcontact.core import fingertip_layout
from firstcontact.models import BEFORE, LONGEST, InContextModel, Touches, moments, shipped_model
from firstcontact.models._compact import THIN, CompactNetwork, Rounded, Thin, moving
from firstcontact.models._network_inputs import INPUTS
from firstcontact.signal import samples_in

RATE = fingertip_layout().rate
LEAD, SAMPLES = samples_in(BEFORE, RATE), samples_in(LONGEST, RATE)


def shipped() -> InContextModel:
    network = shipped_model().network
    assert network is not None
    return network.model


def contact(seed: int, finger: int) -> Touches:
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES)
    signal = 10 ** rng.uniform(-4, -1) * rng.standard_normal(LEAD + SAMPLES)
    ring = np.exp(-t / rng.uniform(2, 40)) * np.sin(t / rng.uniform(2, 20))
    signal[LEAD:] += 10 ** rng.uniform(-3, 1) * ring
    signals = signal.round(3)[None].astype(np.float32)
    return Touches.from_signals(signals, np.full(1, moments(RATE)[0]), np.full(1, finger), RATE)


@settings(max_examples=30)
@given(
    seed=st.integers(0, 2**32 - 1),
    finger=st.sampled_from([-1, 0, 1]),
    due=st.sets(st.sampled_from(moments(RATE)), min_size=1),
)
def test_each_moment_is_that_of_the_model(seed: int, finger: int, due: set[int]) -> None:
    model, touches = shipped(), contact(seed, finger)
    with using(None):
        followed = model.follow(touches)
    for samples in sorted(due):
        so_far = touches.signals.copy()
        so_far[:, LEAD + samples :] = 0.0
        rows = replace(touches, signals=so_far, valid=np.full(1, samples))
        expected = model.predict(rows)
        answer = followed.predict(so_far[0, LEAD:], samples)
        assert answer is not None
        assert (answer.value, answer.low, answer.high, answer.out_of_range) == (
            expected.value[0],
            expected.low[0],
            expected.high[0],
            expected.out_of_range[0],
        )
        assert answer.half_width == model.half_widths(expected.spread, samples, RATE)[0]


@given(seed=st.integers(0, 2**32 - 1), stage=st.integers(0, 4))
@settings(max_examples=20)
def test_one_contact_of_a_compact_network_is_a_row_of_many(seed: int, stage: int) -> None:
    rng = np.random.default_rng(seed)
    base = shipped()._network
    layers = {}
    for name in THIN:
        weight, bias = base._layers[name]
        hidden, remainder = len(base._layers["query1"][1]), base._layers["mean"][0].shape[0]
        changes = moving(name, weight.shape[1], hidden, remainder)
        into = Rounded.nearest(rng.normal(0, 0.1, (8, int(changes.sum()))), rng.normal(0, 0.1, 8))
        out = Rounded.nearest(rng.normal(0, 0.1, (len(bias), 8)), bias)
        fixed = rng.normal(0, 0.1, (8, int((~changes).sum()))).astype(np.float32)
        layers[name] = Thin(into, out, fixed)
    network = CompactNetwork(base, layers)
    rig = shipped().rigs[-1]
    context = network.context(rig.tokens, rig.general)
    x = rng.normal(0, 1, (1, INPUTS))
    many = network.outputs(x, context, np.full(1, stage))
    np.testing.assert_allclose(network.outputs_of_one(x[0], context, stage), many[:, 0], rtol=1e-5)
