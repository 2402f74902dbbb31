"""Small valid files of every kind, always the same ones, which the fuzzer damages."""

import csv
import io
import os
from contextlib import redirect_stdout
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Calibration,
    Channel,
    ChannelKind,
    Contact,
    Finger,
    ForceCurve,
    Label,
    Layout,
    Pinch,
    Role,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.core.calibration import write_calibration
from firstcontact.recording import Header, Marker, RecordingWriter

RATE = 4936.0
CONTACT = 330  # of a pinch; the detector needs its steady state before
LENGTH = 620
OBJECTS = (("sponge", 12.0), ("rubber", 45.0), ("wood", 80.0))


@dataclass(frozen=True)
class Seeds:
    """Valid files and their content.

    ``samples`` has all rows of the first recording, by epoch and number. ``models`` are folders
    with a model and its detector, the last of them conditioned on a rig.
    """

    recordings: list[Path] = field(default_factory=list)
    samples: dict[tuple[int, int], bytes] = field(default_factory=dict)
    models: list[Path] = field(default_factory=list)
    wav: Path = Path()
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    csv: list[list[str]] = field(default_factory=list)
    tables: dict[str, list[list[str]]] = field(default_factory=dict)
    calibration: Path = Path()


def make_seeds(folder: Path) -> Seeds:
    """Write the files into a new folder, in a process that never starts threads."""
    seeds = Seeds(wav=folder / "wav", calibration=folder / "calibration.json")
    folder.mkdir(parents=True)
    write_calibration(_calibration(), seeds.calibration)
    _recordings(folder, seeds)
    _models(folder, seeds)
    _anytime(folder, seeds)
    _wav(seeds.wav)
    _arrays(seeds)
    seeds.tables["plan"] = [
        ["object", "pinches", "shore", "specimen", "role"],
        ["sponge", "3", "12.5", "sponge 1", "train"],
        ["wood", "2", "", "", "test"],
    ]
    seeds.tables["weights"] = [["finger", "newtons", "volts"]] + [
        [finger, str(f), str(0.3 + 0.2 * f)]
        for finger in ("index", "thumb")
        for f in (0, 0.5, 1, 2, 4)
    ]
    seeds.tables["contacts"] = [["pinch", "finger", "time_s"]] + [
        [str(i), finger, f"{0.1 * i + 0.07:.4f}"] for i in range(4) for finger in ("index", "thumb")
    ]
    return seeds


def signal(shore: float, rng: np.random.Generator, length: int = LENGTH) -> NDArray[np.float64]:
    """Return an artificial piezo signal, V."""
    out = 0.002 * rng.standard_normal(length)
    offsets = np.arange(length - CONTACT) / RATE
    out[CONTACT:] += 0.01 * shore * np.sin(2e3 * offsets) * np.exp(-offsets / 0.008)
    return out


def _calibration() -> Calibration:
    return Calibration(
        piezo=(
            VibrationCalibration(Finger.INDEX, 0.002, 0.001, 1.2),
            VibrationCalibration(Finger.THUMB, 0.002),
        ),
        force=(ForceCurve(Finger.INDEX, 1e-6, 1e-4, 0.9, 0.05),),
        created="2026-05-04T12:00:00+00:00",
    )


def piezo_layout() -> Layout:
    """Return a layout with two piezo and two strip channels."""
    channels = (
        Channel("piezo_index", ChannelKind.VIBRATION, Finger.INDEX, "V", 1e-4),
        Channel("piezo_thumb", ChannelKind.VIBRATION, Finger.THUMB, "V", 1e-4),
        Channel("strip_index", ChannelKind.STRIP, Finger.INDEX, ""),
        Channel("strip_thumb", ChannelKind.STRIP, Finger.THUMB, ""),
    )
    return Layout(channels, RATE)


def _recordings(folder: Path, seeds: Seeds) -> None:
    rng = np.random.default_rng(1)
    for name, layout, pinches in (
        ("plain", piezo_layout(), 6),
        ("hand", fingertip_layout(), 2),
        ("bare", piezo_layout(), 3),
    ):
        path = folder / f"{name}.mcap"
        calibration = _calibration() if name == "hand" else None
        header = Header(
            layout, "synthetic", "float32" if name == "bare" else "int16", "piezo", "hand",
            session="1", notes="first line\nsecond line", calibration=calibration,
        )  # fmt: skip
        with RecordingWriter(path, header) as writer:
            first = 0
            for i in range(pinches):
                pinch = _pinch(layout, i, first, header.dtype, rng)
                writer.pinch(pinch)
                writer.marker(Marker(first + 5, f"pinch {i}", 0))
                first += LENGTH if i % 2 else LENGTH + 7
                if name == "plain":
                    # A pinch that does not go on where the last one ended is of a new epoch.
                    epoch = (i + 1) // 2
                    for row, line in enumerate(pinch.data):
                        seeds.samples[epoch, pinch.first_sample + row] = line.tobytes()
        seeds.recordings.append(path)


def _pinch(layout: Layout, i: int, first: int, dtype: str, rng: np.random.Generator) -> Pinch:
    name, shore = OBJECTS[i % 3]
    data = np.zeros((LENGTH, len(layout.channels)))
    for k, channel in enumerate(layout.channels):
        if channel.kind is ChannelKind.VIBRATION:
            data[:, k] = signal(shore, rng) / channel.scale + channel.offset
        elif channel.kind is ChannelKind.STRIP:
            data[CONTACT + 40 * channel.finger :, k] = 1
        else:
            data[:, k] = 100 + 5 * rng.standard_normal(LENGTH)
    at = first + CONTACT
    truth = (Contact(Finger.INDEX, at, at), Contact(Finger.THUMB, at + 40, at + 40))
    role = Role.TEST if i == 5 else Role.TRAIN
    label = Label(name, shore, None, f"{name} {i % 2}", "1", role)
    return Pinch(data.astype(dtype), layout, label, first, truth)


def _models(folder: Path, seeds: Seeds) -> None:
    """Train small models from a few sessions, as users do."""
    from firstcontact.cli.main import main

    rng = np.random.default_rng(2)
    learned = folder / "sessions"
    learned.mkdir()
    for session in map(str, range(1, 6)):
        header = Header(piezo_layout(), "synthetic", session=session)
        with RecordingWriter(learned / f"{session}.mcap", header) as writer:
            for i in range(7):
                pinch = _pinch(piezo_layout(), i, i * (LENGTH + 1), "int16", rng)
                label = replace(pinch.label, session=session, role=Role.TRAIN)
                writer.pinch(replace(pinch, label=label))
    for name, model, task in (
        ("svm", "svm", "regression"),
        ("svm_classes", "svm", "classification"),
        ("peak", "peak", "regression"),
        ("mean", "train_mean", "regression"),
        ("ridge", "sklearn.linear_model:Ridge", "regression"),
    ):
        out = folder / name
        arguments = ["train", str(learned), "--out", str(out), "--estimator", model, "--task", task]
        process = os.fork()  # training starts threads
        if not process:
            with redirect_stdout(io.StringIO()):
                os._exit(main(arguments))
        assert os.waitpid(process, 0)[1] == 0, arguments
        seeds.models.append(out)


def _anytime(folder: Path, seeds: Seeds) -> None:
    """Write models conditioned on a random rig, with a detector."""
    from firstcontact.contact import load_detector
    from firstcontact.models import Model
    from firstcontact.models.model_file import pretrained
    from firstcontact.models.rig.rigs import Rig

    rng = np.random.default_rng(3)
    tokens = rng.standard_normal((len(Rig.STAGES), 3, Rig.TOKEN))
    general = rng.standard_normal(Rig.GENERAL)
    rig = Rig(0.4, 1.0, None, None, tokens, general)
    model = pretrained().conditioned_on({Rig.ANY: rig, 0: rig})
    detector = load_detector(seeds.models[0])
    out = folder / "in_context"
    seeds.models.append(Model(detector, (model,)).save(out))


def _wav(folder: Path) -> None:
    from scipy.io import wavfile

    rng = np.random.default_rng(4)
    folder.mkdir()
    rows = [["file", "sample_rate_hz", "object", "shore_a", "specimen", "session", "role",
             "first_contact", "comment"]]  # fmt: skip
    for i in range(3):
        name, shore = OBJECTS[i]
        sound = (signal(shore, rng) * 2**14).astype(np.int16)
        wavfile.write(folder / f"{i}.wav", 4936, sound)
        rows.append([f"{i}.wav", "4936", name, str(shore), f"{name} 1", "1", "train",
                     str(CONTACT), ""])  # fmt: skip
    (folder / "labels.csv").write_text(_text(rows))


def _text(rows: list[list[str]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def _arrays(seeds: Seeds) -> None:
    rng = np.random.default_rng(5)
    n = 4
    seeds.arrays.update(
        piezo=np.stack([signal(OBJECTS[i % 3][1], rng) for i in range(n)])[:, :, None].astype("f4"),
        force=rng.standard_normal((n, LENGTH, 2, 6)).astype("f4"),
        strip=np.zeros((n, LENGTH, 2), np.int8),
        first_contact=np.full(n, CONTACT),
        second_contact=np.full(n, -1),
        first_finger=np.zeros(n, int),
        object=np.array([OBJECTS[i % 3][0] for i in range(n)]),
        shore_a=np.array([OBJECTS[i % 3][1] for i in range(n)]),
        session=np.array(["1", "1", "2", "2"]),
        specimen=np.array(["a", "b", "c", "a"]),
        role=np.array(["train", "train", "train", "test"]),
        sample_rate_hz=np.array(RATE),
        piezo_unit=np.array("V"),
        smoothing_alpha=np.array(0.5),
        source=np.array("synthetic"),
    )
    seeds.csv.append(["pinch", "time_s", "piezo_index", "shore_a", "session", "first_contact",
                      "sample_rate_hz", "piezo_unit"])  # fmt: skip
    for i in range(2):
        for k, v in enumerate(signal(OBJECTS[i][1], rng, 400)):
            seeds.csv.append([str(i), f"{k / RATE:.7f}", f"{v:.5f}", str(OBJECTS[i][1]), "1",
                              str(CONTACT), str(RATE), "V"])  # fmt: skip
