"""Resampling of datasets: signal, contacts and notes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.core import (
    Channel,
    ChannelKind,
    Contact,
    Dataset,
    Finger,
    InputError,
    Layout,
    Pinch,
    fingertip_layout,
)
from firstcontact.signal import CausalResampler, resample, resample_dataset
from firstcontact.signal.resampling import lookahead, resample_contacts, restore_contacts


@pytest.mark.parametrize(("old", "new"), [(16_000.0, 4936.0), (2000.0, 4936.0), (4936.0, 5000.0)])
def test_a_slow_sine_survives(old, new):
    t = np.arange(round(0.3 * old)) / old
    out = resample(np.sin(2 * np.pi * 200 * t)[:, None], old, new)[:, 0]
    late = max(0.0, 1.778 / min(old, new) - 0.0005)  # what the filter lags beyond its look-ahead
    u = np.arange(len(out)) / new - late
    inner = (u > 0.02) & (u < 0.28)
    np.testing.assert_allclose(out[inner], np.sin(2 * np.pi * 200 * u[inner]), atol=0.02)


def test_frequencies_above_the_new_nyquist_are_removed():
    t = np.arange(4800) / 16_000
    out = resample(np.sin(2 * np.pi * 4000 * t)[:, None], 16_000.0, 4936.0)
    assert np.abs(out[50:-50]).max() < 0.01


def test_truth_is_resampled_and_a_note_added():
    layout = Layout((Channel("piezo", ChannelKind.VIBRATION, Finger.INDEX, "V"),), 16_000.0)
    data = np.zeros((3200, 1), dtype=np.float32)
    data[1600:] = 1.0
    truth = (Contact(Finger.INDEX, 9600, 9600),)
    out = resample_dataset(Dataset((Pinch(data, layout, first_sample=8000, truth=truth),)), 4936.0)
    p = out.pinches[0]
    step = int(np.argmax(p.data[:, 0] > 0.5)) + p.first_sample
    assert abs(p.truth[0].sample - step) <= 1
    assert p.first_sample == round(8000 * 4936 / 16_000)
    assert p.layout.rate == 4936.0
    assert "16000 Hz to 4936 Hz" in out.notes[-1]
    assert out.recorded_rate == out.take([0]).recorded_rate == 16_000.0


def test_strip_channels_stay_binary():
    data = np.full((900, 16), 16384, dtype=np.int16)
    data[:, 14:] = 0
    data[450:, 14] = 1
    out = resample_dataset(Dataset((Pinch(data, fingertip_layout()),)), 2000.0)
    strip = out.pinches[0].strip(Finger.INDEX)
    assert set(np.unique(strip)) == {0.0, 1.0}
    assert abs(int(np.argmax(strip > 0)) / 2000 - 450 / 4936) <= 1 / 2000


def test_data_at_the_target_rate_are_unchanged():
    dataset = Dataset((Pinch(np.zeros((9, 16), dtype=np.int16), fingertip_layout()),))
    assert resample_dataset(dataset, 4936.0) is dataset


RATES = [(44100.0, 4936.0), (16_000.0, 4936.0), (8000.0, 4936.0), (2500.0, 5000.0)]


@pytest.mark.parametrize(("old", "new"), RATES)
def test_output_starts_no_earlier_than_the_lookahead(old, new):
    """The lookahead is at most half a millisecond, and the stated value is tight."""
    assert lookahead(new, new) == 0.0
    assert 0.0 < lookahead(old, new) <= 0.0005
    earliest = 0.0
    for shift in range(12):  # where a sample lies between those of the other rate
        impulse = np.zeros((2000, 1))
        impulse[1000 + shift] = 1.0
        out = np.abs(resample(impulse, old, new)[:, 0])
        began = np.flatnonzero(out > 1e-9)[0] / new
        earliest = max(earliest, (1000 + shift) / old - began)
    assert 0.7 * lookahead(old, new) < earliest <= lookahead(old, new) + 1e-9


@pytest.mark.parametrize(("old", "new"), RATES)
def test_aliases_are_rejected_as_stated(old, new):
    lower = min(old, new)
    for share, limit in ((0.55, 0.08), (0.6, 0.003), (0.8, 0.003)):
        if share * lower >= old / 2:
            continue  # not there to be rejected
        t = np.arange(round(0.5 * old)) / old
        out = resample(np.sin(2 * np.pi * share * lower * t)[:, None], old, new)
        assert np.abs(out[400:-400]).max() < limit


def test_resampling_has_a_rate_limit() -> None:
    """Without a limit, a rate stated in a file could use up all memory."""
    layout = fingertip_layout()
    pinch = Pinch(np.zeros((100, len(layout.channels))), layout)
    dataset = Dataset((pinch,))
    assert len(resample_dataset(dataset, 10 * layout.rate).pinches[0].data) == 1000
    with pytest.raises(InputError, match="Hz"):
        resample_dataset(dataset, 1e12)


def one_contact(rate: float, start: int, contact: Contact) -> Dataset:
    layout = Layout((Channel("piezo", ChannelKind.VIBRATION, Finger.INDEX, "V"),), rate)
    pinch = Pinch(np.zeros((3000, 1)), layout, first_sample=start, truth=(contact,))
    return Dataset((pinch, pinch))


@given(
    st.floats(1000, 50_000),
    st.floats(1000, 10_000),
    st.integers(0, 10**9),
    st.integers(0, 2999),
    st.integers(0, 100),
)
def test_contacts_return_to_their_samples(
    old: float, new: float, start: int, sample: int, delay: int
) -> None:
    contact = Contact(Finger.INDEX, start + sample, start + min(sample + delay, 2999))
    dataset = one_contact(old, start, contact)
    resampled = resample_contacts([contact, None], dataset, new)
    back, nothing = restore_contacts(resampled, dataset, new)
    assert nothing is resampled[1] is None
    step = 0 if new >= old else 0.5 * old / new + 0.6  # half a sample of each rate
    assert abs(back.sample - contact.sample) <= step
    assert abs(back.decided - contact.decided) <= step


@pytest.mark.parametrize(("old", "new"), [(2000.0, 4936.0), (5000.0, 4936.0), (10_000.0, 4936.0)])
def test_a_contact_in_the_last_sample_stays_in_its_pinch(old: float, new: float) -> None:
    dataset = one_contact(old, 0, Contact(Finger.INDEX, 70, 70))
    resampled = resample_dataset(dataset, new).pinches[0]
    last = resampled.first_sample + len(resampled.data) - 1
    back = restore_contacts([Contact(Finger.INDEX, last, last), None], dataset, new)[0]
    assert 2997 <= back.sample == back.decided <= 2999


@pytest.mark.parametrize("new", [2500.0, 4890.0, 4936.0, 10_000.0])
def test_contacts_move_as_the_labels_of_the_pinches(new: float) -> None:
    dataset = one_contact(4936.0, 123_457, Contact(Finger.INDEX, 124_000, 124_011))
    truth = [p.first for p in dataset]
    assert resample_contacts(truth, dataset, new) == [
        p.first for p in resample_dataset(dataset, new)
    ]


STREAMED = [(48_000.0, 4936.0), (44_100.0, 4936.0), (16_000.0, 4936.0), (2200.0, 4936.0)]


@pytest.mark.parametrize(("old", "new"), STREAMED)
@settings(max_examples=15)
@given(sizes=st.lists(st.integers(1, 900), min_size=1, max_size=30), seed=st.integers(0, 99))
def test_blocks_of_any_size_give_the_same_output(
    old: float, new: float, sizes: list[int], seed: int
) -> None:
    x = np.random.default_rng(seed).standard_normal((sum(sizes), 2))
    stream = CausalResampler(old, new)
    out, place = [], 0
    for size in sizes:
        part, first = stream.update(x[place : place + size], place)
        assert first == sum(len(o) for o in out)
        out.append(part)
        place += size
    together = np.concatenate(out)
    np.testing.assert_allclose(together, resample(x, old, new)[: len(together)], atol=1e-12)
    assert len(together) >= len(x) * new / old - 0.0005 * new - 2


@pytest.mark.parametrize(("old", "new"), STREAMED)
def test_delay_is_at_most_half_a_millisecond(old: float, new: float) -> None:
    stream = CausalResampler(old, new)
    assert 0 < stream.delay <= 0.0005
    count = 0
    for k in range(round(0.05 * old)):
        out, _ = stream.update(np.zeros((1, 1)), k)
        count += len(out)
        # Of every instant up to a delay before now there is a sample.
        assert count / new + 1 / new > k / old - stream.delay - 1 / old - 1e-9


def test_sample_numbers_after_a_gap_include_the_gap() -> None:
    stream = CausalResampler(48_000.0, 4936.0)
    before_gap, first_index = stream.update(np.ones((4800, 1)), 0)
    after_gap, index_after_gap = stream.update(np.full((4800, 1), 3.0), 9600)
    assert first_index == 0
    assert index_after_gap / 4936.0 == pytest.approx(9600 / 48_000.0, abs=1 / 4936.0)
    assert index_after_gap >= len(before_gap)
    # What is missing is not made up, and what was before does not ring on behind it.
    np.testing.assert_allclose(after_gap, 3.0, rtol=1e-5)  # the filter's own ripple


def test_equal_rates_pass_samples_through() -> None:
    stream = CausalResampler(4936.0, 4936.01)
    x = np.arange(10.0)[:, None]
    out, first = stream.update(x, 5)
    assert (first, stream.delay) == (5, 0.0)
    np.testing.assert_array_equal(out, x)


@pytest.mark.parametrize(("old", "new"), [(48_000.0, 4936.0), (3000.0, 4936.0)])
def test_an_input_sample_has_the_number_of_the_nearest_output_sample(
    old: float, new: float
) -> None:
    numbers = np.array([CausalResampler(old, new).number(sample) for sample in range(5000)])
    assert np.abs(numbers / new - np.arange(5000) / old).max() <= 0.51 / new
