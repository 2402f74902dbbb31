"""Onset finder, which also uses samples after the onset."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.contact.finder import APART, find_onsets, pick_onset
from firstcontact.signal import resample

RATE = 8000.0


def with_taps(places: list[int], level: float = 100.0, seed: int = 0, n: int = 16_000):
    x = np.random.default_rng(seed).normal(0, 1, n)
    t = np.arange(300) / RATE
    for at in places:
        ring = level * np.exp(-t / 0.006) * np.sin(2 * np.pi * 300 * t + 0.6)
        x[at : at + 300] += ring[: len(x) - at]
    return x[:, None]


@given(
    st.lists(st.integers(1, 14), min_size=1, max_size=6, unique=True),
    st.integers(0, 999),
    st.floats(30.0, 3000.0),
)
def test_every_tap_is_found_at_its_sample(slots: list[int], shift: int, level: float) -> None:
    places = sorted(1000 * slot + shift for slot in slots)
    onsets = find_onsets(with_taps(places, level), RATE)
    assert [o.sample for o in onsets] == pytest.approx(places, abs=4)


def test_level_offset_and_drift_change_nothing() -> None:
    x = with_taps([3000, 9000])
    places = [o.sample for o in find_onsets(x, RATE)]
    drift = np.linspace(0, 50, len(x))[:, None]
    for variant in (x * 1e-6, x + 1e4, x + drift, -x):
        assert [o.sample for o in find_onsets(variant, RATE)] == pytest.approx(places, abs=1)


def test_quiet_flat_and_short_signals_have_no_onsets() -> None:
    assert find_onsets(with_taps([]), RATE) == []
    assert find_onsets(np.zeros((5000, 2)), RATE) == []
    for n in (0, 1, 100, 200):
        assert find_onsets(np.random.default_rng(0).normal(size=(n, 1)), RATE) == []


@pytest.mark.parametrize("level", [0.0, 0.1])  # the deviation of many 0.1 is not exactly 0
@pytest.mark.parametrize("share", [0.1, 0.25, 0.9])
def test_digital_silence_hides_no_tap(share: float, level: float) -> None:
    places = [3000, 9000, 14_000]
    x = with_taps(places)
    silence = np.full((round(share * len(x) / (1 - share)), 1), level)
    for cut in (0, 6000, len(x)):  # before, between and after the taps
        onsets = find_onsets(np.vstack([x[:cut], silence, x[cut:]]), RATE)
        expected = [place + (place >= cut) * len(silence) for place in places]
        assert [o.sample for o in onsets] == pytest.approx(expected, abs=4)


def test_ringing_is_one_contact_per_channel() -> None:
    index_taps, thumb_taps = with_taps([4000]), with_taps([4000 + round(APART * RATE / 2)], seed=1)
    onsets = find_onsets(np.hstack([index_taps, thumb_taps]), RATE)
    assert [o.column for o in onsets] == [0, 1]
    assert len(find_onsets(index_taps + thumb_taps, RATE)) == 1


def test_slow_swings_after_a_tap_are_hardly_ever_contacts() -> None:
    rng = np.random.default_rng(0)
    t = np.arange(4000) / RATE
    wrong = 0
    for seed in range(100):
        frequency, phase = rng.uniform(5.0, 16.0), rng.uniform(0.0, 2 * np.pi)
        x = with_taps([1000], 1000.0, seed, 5500)
        # The finger swings back once: about as large as the tap, and smooth at both ends.
        swing = np.sin(2 * np.pi * frequency * t + phase) * np.sin(np.pi * t / t[-1]) ** 2
        x[1000:5000, 0] += 1000.0 * rng.uniform(0.5, 2.0) * swing
        onsets = [o.sample for o in find_onsets(x, RATE)]
        assert onsets[0] == pytest.approx(1000, abs=4)
        wrong += len(onsets) - 1
    assert wrong <= 3  # 1 % of swings above 8 Hz


@pytest.mark.parametrize(("shore", "rebounds"), [(10.0, 0), (60.0, 4)])
def test_finds_the_taps_and_rebounds_of_the_tutorial(shore: float, rebounds: int) -> None:
    tutorial = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "tap_tape.py"))
    signal = resample(tutorial["tape"](shore, 4, 1).astype(float)[:, None], tutorial["RATE"], RATE)
    onsets = np.array([o.sample for o in find_onsets(signal, RATE)]) / RATE
    taps = tutorial["REST"] + tutorial["APART"] * np.arange(4)
    from_tap = onsets - taps[np.searchsorted(taps, onsets + 0.005) - 1]
    assert (np.abs(from_tap) < 0.001).sum() == 4
    rebound_times = from_tap[np.abs(from_tap) >= 0.001]
    assert len(rebound_times) <= rebounds
    # That is when the simulated finger comes back to the block.
    assert ((rebound_times > 0.05) & (rebound_times < 0.07)).all()


def test_real_impacts_are_found_at_their_labels(impacts: Path) -> None:
    import csv

    from scipy.io import wavfile

    with (impacts / "labels.csv").open() as table:
        for row in csv.DictReader(table):
            rate, data = wavfile.read(impacts / "wav" / row["file"])
            onsets = np.array([o.sample for o in find_onsets(data[:, None].astype(float), rate)])
            # The trigger that labelled them is up to 4 ms late.
            late = (int(row["pre_trigger_samples"]) - onsets) / rate
            assert ((late > -0.002) & (late < 0.006)).any(), row["file"]


def test_real_strikes_are_found_at_their_labels(strikes: Path) -> None:
    import csv

    from scipy.io import wavfile

    hits: dict[str, list[int]] = {}
    with (strikes / "hits.csv").open() as table:
        for row in csv.DictReader(table):
            hits.setdefault(row["file"], []).append(int(row["onset_sample"]))
    near = []
    for name, samples in hits.items():
        rate, data = wavfile.read(strikes / "wav" / name)
        onsets = find_onsets(data.reshape(len(data), -1)[:, :1].astype(float), rate)
        onset_samples = np.array([o.sample for o in onsets])
        near += [np.abs(onset_samples - s).min() / rate <= 0.002 for s in samples]
    assert np.mean(near) > 0.99


def test_onset_is_the_change_of_variance():
    rng = np.random.default_rng(0)
    errors = []
    for onset in rng.integers(75, 95, 200):
        x = rng.normal(size=(1, 99))
        x[0, onset:] *= 30
        errors.append(int(pick_onset(x, 30)[0]) - onset)
    assert np.median(np.abs(errors)) <= 1
    assert np.percentile(np.abs(errors), 90) <= 3


def test_onset_of_a_flat_signal_is_within_the_search_range():
    x = np.zeros((2, 99))
    x[1, :50] = np.random.default_rng(2).normal(size=50)
    picked = pick_onset(x, 30)
    assert ((picked >= 69) & (picked <= 96)).all()
