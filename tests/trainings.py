"""Small recordings for training, and the command line that trains on them."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.cli.main import main
from firstcontact.core import Contact, Dataset, Finger, Label, Pinch, Role, fingertip_layout
from firstcontact.recording import Header, load_dataset, write_dataset
from firstcontact.recording.dataset import pause_between
from firstcontact.signal import resample_dataset

LAYOUT = fingertip_layout()
CONTACT, LENGTH = 500, 700


def touch(shore: float, label: Label, rng: np.random.Generator, has_contacts: bool = True) -> Pinch:
    """Return a quiet signal, then a damped oscillation, strong in the index finger's piezo only."""
    data = np.zeros((LENGTH, len(LAYOUT.channels)))
    data[:, :2] = 16384 + rng.normal(0, 60, (LENGTH, 2))
    t = np.arange(LENGTH - CONTACT) / LAYOUT.rate
    hard = shore + rng.normal(0, 1)
    # As quick and as loud as the any-time model takes for touches of such hardness.
    wave = np.sin(2 * np.pi * (40 + 2 * hard) * t) * np.exp(-t / 0.006)
    data[CONTACT:, 0] += 2500 * np.exp(hard / 40) * rng.lognormal(0, 0.1) * wave
    truth = (Contact(Finger.INDEX, CONTACT, CONTACT),) if has_contacts else ()
    return Pinch(np.clip(data, 0, 32767).astype(np.int16), LAYOUT, label, truth=truth)


def recordings(
    folder: Path,
    sessions: tuple[str, ...] = ("a", "b", "c", "d"),
    has_contacts: bool = True,
    seed: int = 0,
) -> Path:
    """Write five pinches of each of three blocks per session.

    Pinches of an unseen object are in a session of their own.
    """
    rng = np.random.default_rng(seed)
    pinches = []
    for session in sessions:
        for shore in (10.0, 29.0, 60.0):
            label = Label(f"block {shore:g}", shore, None, f"block {shore:g}", session)
            pinches += [touch(shore, label, rng, has_contacts) for _ in range(5)]
    unseen = Label("apple", 28.0, None, "apple 1", "objects", Role.TEST)
    pinches += [touch(28.0, unseen, rng, has_contacts) for _ in range(4)]
    folder.mkdir()
    write_dataset(Dataset(tuple(pinches), "synthetic"), folder, Header(LAYOUT, "synthetic"))
    return folder


def run(*words: Any) -> int:
    return main([str(w) for w in words])


def load_card(folder: Path) -> Any:
    return json.loads((folder / "model.json").read_text(encoding="utf-8"))


def resampled(data: Path, rate: float, out: Path) -> Path:
    """Write the recordings of a folder at another sampling rate."""
    dataset = resample_dataset(load_dataset(data), rate)
    pinches = pause_between(dataset.pinches)
    out.mkdir()
    header = Header(dataset.layout, "synthetic", "float32")
    write_dataset(Dataset(pinches, "synthetic"), out, header)
    return out
