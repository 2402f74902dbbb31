"""Comparison with a simulated camera that has its own clock and a few wrong labels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.collect.camera import compare, in_words, read_contacts
from firstcontact.core import Contact, Finger, InputError, Label, fingertip_layout
from firstcontact.recording import Header, PinchMark, Recording

RATE = fingertip_layout().rate
FPS = 960.0


def random_recording(seed: int, pinches: int = 40, epochs: int = 1) -> tuple[Recording, dict]:
    """Return the marks of a recording, and the times of its contacts, s from each epoch's start."""
    rng = np.random.default_rng(seed)
    marks, truth = [], {}
    for number in range(pinches):
        epoch = number * epochs // pinches
        first = 3.0 * number + rng.uniform(0.5, 1.0)
        times = {Finger.INDEX: first, Finger.THUMB: first + rng.normal(0, 0.016)}
        samples = {f: int(np.ceil(t * RATE)) for f, t in times.items()}
        contacts = tuple(Contact(f, s) for f, s in sorted(samples.items(), key=lambda c: c[1]))
        start = min(samples.values())
        marks.append(PinchMark(number, start - 500, start + 1500, epoch, Label(), contacts))
        truth |= {(number, f): (epoch, t) for f, t in times.items()}
    recording = Recording("a.mcap", Header(fingertip_layout()), pinches=tuple(marks))
    return recording, truth


def film(truth: dict, offset: float, drift: float) -> dict:
    """Return the camera time of the first frame after each contact."""
    frame_times = {}
    for key, (epoch, t) in truth.items():
        time = offset + 1000.0 * epoch + (1 + drift) * t
        frame_times[key] = np.ceil(time * FPS) / FPS
    return frame_times


@given(
    st.integers(0, 2**31), st.floats(-5000.0, 5000.0), st.floats(-500e-6, 500e-6), st.integers(1, 3)
)
def test_compare_recovers_offset_and_drift_to_one_frame(seed, offset, drift, epochs):
    recording, truth = random_recording(seed, epochs=epochs)
    agreement = compare(recording, film(truth, offset, drift), FPS)
    assert agreement.within == 1.0
    assert agreement.disagreeing_contacts == ()
    # Half a frame late and half a sample early, on average.
    assert agreement.offset == pytest.approx(offset + 0.5 / FPS - 0.5 / RATE, abs=1e-3)
    assert abs(agreement.drift - drift) < 6 * agreement.drift_error + 1e-9
    assert agreement.drift_error < 30e-6


@given(st.integers(0, 2**31), st.integers(0, 39), st.sampled_from(["swapped", "other", "late"]))
def test_compare_names_one_wrong_label_and_keeps_the_fit(seed, wrong, how):
    recording, truth = random_recording(seed)
    frame_times = film(truth, 12.5, 80e-6)
    pair = [(wrong, f) for f in Finger]
    if how == "swapped":
        frame_times[pair[0]], frame_times[pair[1]] = frame_times[pair[1]], frame_times[pair[0]]
    else:
        for key in pair:
            frame_times[key] += 3.0 if how == "other" else 0.02
    agreement = compare(recording, frame_times, FPS)
    lead = abs(truth[pair[0]][1] - truth[pair[1]][1])
    if how != "swapped" or lead > 2 / FPS:
        assert agreement.disagreeing_contacts == tuple(pair)
        assert agreement.within == pytest.approx(1 - 2 / 80)
    assert abs(agreement.drift - 80e-6) < 6 * agreement.drift_error
    assert any(f"pinch {wrong}, index" in s for s in in_words(agreement)) == (
        pair[0] in agreement.disagreeing_contacts
    )


def test_compare_lists_contacts_without_a_strip():
    recording, truth = random_recording(1, pinches=5)
    frame_times = {**film(truth, 0.0, 0.0), (99, Finger.THUMB): 4.0}
    agreement = compare(recording, frame_times, FPS)
    assert agreement.left_out == ((99, Finger.THUMB),)
    assert len(agreement.residuals) == 10
    assert "left out    pinch 99, thumb: no strip closed there" in in_words(agreement)


def test_compare_refuses_too_few_contacts_and_invalid_fps():
    recording, truth = random_recording(1, pinches=2)
    with pytest.raises(InputError, match=r"a\.mcap: only 2 pinches"):
        compare(recording, film(truth, 0.0, 0.0))
    for fps in (0.0, 1e200, float("nan")):
        with pytest.raises(InputError, match="fps"):
            compare(recording, {}, fps)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("pinch,finger\n0,index\n", "'time_s'"),
        ("pinch,finger,time_s\n0,toe,1\n", "line 2"),
        ("pinch,finger,time_s\n0,index,nan\n", "line 2"),
        ("pinch,finger,time_s\n0,index,1e300\n", "line 2"),
        ("pinch,finger,time_s\n0,index,1\n0,index,2\n", "line 3"),
    ],
)
def test_invalid_contact_lists_are_refused(tmp_path, text, problem):
    path = tmp_path / "contacts.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=problem):
        read_contacts(path)
    with pytest.raises(InputError, match=r"none\.csv"):
        read_contacts(tmp_path / "none.csv")
