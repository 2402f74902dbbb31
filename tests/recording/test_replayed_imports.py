"""One recording, one number: replay, predict, evaluate and the exported chain agree on imports."""

import math
import re
from itertools import product

import numpy as np
import pytest
from import_files import MAKERS, RATE, SETTINGS, imported, table
from scipy.io import savemat, wavfile
from test_recording_xdf import stream, times, xdf

import firstcontact as fc
from firstcontact.chain import Chain, EventKind, Image
from firstcontact.contact.closing_start import closing_starts, count_starts
from firstcontact.core import Block
from firstcontact.signal import resample_dataset

PINCHES, TOUCH, MOTOR = 8, round(0.25 * RATE), round(0.12 * RATE)
SHORES = [15.0, 80.0] * (PINCHES // 2)


def signals(begin):
    """Return pinches of one finger that rest, move from ``begin`` on, and touch."""
    rng = np.random.default_rng(4)
    x = rng.normal(0.0, 0.001, (PINCHES, TOUCH + 700, 1))
    x[:, begin:] *= 12.0
    t = np.arange(700) / RATE
    for k, shore in enumerate(SHORES):
        ring = 0.5 * np.exp(-t / 0.01) * np.sin(2 * np.pi * (60 + 4 * shore) * t)
        x[k, TOUCH:, 0] += ring * rng.uniform(0.8, 1.2)
    return x.astype(np.float32)


def as_long_wav(folder, values, labels=()):
    """Write one file whose pinches, 80 ms before to 60 ms after a contact, have no gap between."""
    before, after = round(0.08 * RATE), round(0.06 * RATE)
    wavfile.write(folder / "x.wav", RATE, values[:, TOUCH - before : TOUCH + after].reshape(-1))
    onsets = [before + k * (before + after) for k in range(len(values))]
    events = table(folder / "events.csv", {"onset_sample": onsets, **dict(labels)})
    return folder / "x.wav", "--events", str(events), "--sensor", "piezo"


def as_mat(folder, values, labels=()):
    savemat(folder / "x.mat", {"piezo": values, **SETTINGS, **dict(labels)})
    return folder / "x.mat"


def as_xdf(folder, values, labels=()):
    table_ = dict(labels)
    texts = [
        "; ".join(["x", *(f"{name}={column[k]}" for name, column in table_.items())])
        for k in range(len(values))
    ]
    onsets = [50.0 + (TOUCH + k * values.shape[1]) / RATE for k in range(len(values))]
    piezo = stream(1, "finger", RATE, "float32", times(values.size, RATE), values.reshape(-1))
    return xdf(folder, piezo, stream(3, "marks", 0.0, "string", onsets, texts))


def replayed(folder, model, speed=math.inf):
    """Return the finished pinches of all recordings in a folder, in order."""
    events = []
    for path in sorted(folder.glob("*.mcap")):
        with fc.open(path, speed=speed) as source:
            events += fc.live(source, model)
    return [e for e in events if isinstance(e, fc.PinchDone)]


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return the image in the C code of the package's model."""
    folder = tmp_path_factory.mktemp("c") / "library"
    fc.export_model(fc.adapt(), folder)
    words = re.findall(r"0x[0-9a-f]+(?=u)", (folder / "src/fc_model_image.c").read_text("utf-8"))
    return Image(np.array([int(word, 16) for word in words], "<u8").tobytes())


@pytest.mark.parametrize(
    ("make", "start"),
    [
        *product([*MAKERS, as_mat], ["label", "rest", "first_sample"]),
        # A table of contacts has no motor starts, and cuts the rest off.
        *product([as_long_wav, as_xdf], ["first_sample"]),
    ],
)
def test_every_way_gives_the_same_numbers(make, start, exported, tmp_path):
    labels = {"shore_a": SHORES, "specimen": [f"s{k}" for k in range(PINCHES)]}
    if start == "label":
        labels["motor_start"] = [MOTOR] * PINCHES
    more = make(tmp_path, signals(0 if start == "first_sample" else MOTOR), labels.items())
    path, *options = more if isinstance(more, tuple) else (more,)
    if path.suffix == "" and "--sensor" not in options:
        options += ["--sensor", "piezo"]
    data = imported(path, tmp_path / "out", *options)
    model = fc.adapt()
    resampled = resample_dataset(data, model.rate)
    starts = closing_starts(resampled)
    assert count_starts(starts) == {start: PINCHES}
    predicted = model.predict(data)
    done = replayed(tmp_path / "out", model)
    assert [e.final.value for e in done] == pytest.approx(predicted.value, abs=1e-3)
    assert [e.final.low for e in done] == pytest.approx(predicted.low, abs=1e-3)
    (evaluation,) = fc.evaluate(model, data)
    errors = np.array([e.final.value for e in done]) - data.shore_a
    assert evaluation.rmse[0.015] == pytest.approx(math.sqrt((errors**2).mean()), abs=1e-3)
    for finished, pinch, begin in zip(done, resampled, starts, strict=True):
        chain = Chain(exported, pinch.layout)
        events = chain.take(Block(pinch.data[begin.sample - pinch.first_sample :], begin.sample))
        values = [e.value for e in events if e.kind == EventKind.ESTIMATED]
        assert finished.final.value == pytest.approx(values[-1], abs=1e-3)
