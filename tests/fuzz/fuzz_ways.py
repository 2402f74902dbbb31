"""Routes of input: make damaged files and a command from a seed and a number."""

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random

import fuzz_imports
import fuzz_label
import fuzz_models
import fuzz_mutate as mutate
import fuzz_recordings
import fuzz_wire
from fuzz_seeds import Seeds

#: A port that is not there: what is given besides it is read first.
NO_PORT = "/dev/no-such-port"


@dataclass
class Case:
    """One damaged input.

    Parameters
    ----------
    route
        Name of the route of input.
    commands
        Command lines of ``firstcontact``.
    calls
        Further functions to call. They may raise only InputError.
    """

    route: str
    commands: list[list[str]] = field(default_factory=list)
    calls: list[Callable[[], None]] = field(default_factory=list)


def make_case(seed: int, number: int, seeds: Seeds, folder: Path) -> Case:
    """Make input ``number`` of a seed, with its files in an empty folder."""
    rng = Random(f"{seed} {number}")
    route = rng.choices(list(WAYS), [weight for weight, _ in WAYS.values()])[0]
    case = Case(route)
    WAYS[route][1](rng, seeds, folder, case)
    return case


@cache
def _read_messages(path: Path) -> tuple[bytes, list[fuzz_recordings.RawMessage]]:
    raw = path.read_bytes()
    return raw, fuzz_recordings.messages(raw)


def _recording(rng: Random, seeds: Seeds, folder: Path, case: Case) -> None:
    original = rng.choice((*seeds.recordings, seeds.recordings[0]))
    raw, predictions = _read_messages(original)
    path = folder / "damaged.mcap"
    if rng.random() < 0.45:
        path.write_bytes(mutate.raw(rng, raw))
        if original == seeds.recordings[0]:
            case.calls.append(lambda: _none_is_wrong(path, seeds))
    else:
        path.write_bytes(fuzz_recordings.rewritten(rng, predictions))
    _use(rng, seeds, folder, path, case)


def _none_is_wrong(path: Path, seeds: Seeds) -> None:
    """Assert that samples read from a damaged file equal the written ones."""
    from firstcontact.recording import read_recording

    for stretch in read_recording(path).stretches:
        for i, row in enumerate(stretch.data):
            place = stretch.epoch, stretch.first_sample + i
            assert row.tobytes() == seeds.samples.get(place), f"sample {place} is another one"


def _use(rng: Random, seeds: Seeds, folder: Path, path: Path, case: Case) -> None:
    """Make a command that uses a recording."""
    out, file = folder / "out", str(path)
    model = str(rng.choice(seeds.models))
    kind = rng.random()
    if kind < 0.50:
        case.commands.append(["inspect", file])
    elif kind < 0.56:
        good = folder / "some"
        good.mkdir()
        shutil.copy(seeds.recordings[0], good / "a.mcap")
        path.rename(good / "b.mcap")
        case.commands.append(["export", str(good), "--to", "csv", "--out", str(out)])
        case.calls.clear()
    elif kind < 0.72:
        to = rng.choice(("csv", "hdf5", "hdf5", "parquet"))
        case.commands.append(["export", file, "--to", to, "--out", str(out)])
    elif kind < 0.82:
        case.commands.append(["evaluate", model, file])
    elif kind < 0.92:
        words = ["live", "--device", file, "--speed", "inf", "--model", model]
        case.commands.append([*words, "--json"] if rng.random() < 0.5 else words)
    elif kind < 0.95:
        contacts = folder / "contacts.csv"
        contacts.write_bytes(mutate.table(rng, seeds.tables["contacts"]))
        case.commands.append(["camera", file, "--times", str(contacts)])
    elif kind < 0.97:
        words = ["inspect", file, "--plot", str(folder / rng.choice(("a.png", "a.svg", "a.pdf")))]
        case.commands.append([*words, "--pinch", str(rng.randrange(4))])
    elif kind < 0.975:
        case.commands.append(["train", file, "--out", str(out), "--estimator", "peak"])
    else:
        case.commands.append(["inspect", file])


def _model(rng: Random, seeds: Seeds, folder: Path, case: Case) -> None:
    """Make a damaged model and a command that uses it."""
    model = folder / "model"
    fuzz_models.damaged(rng, rng.choice((*seeds.models, *seeds.models[-1:] * 3)), model)
    recording = str(rng.choice(seeds.recordings))
    if rng.random() < 0.6:
        words = ["evaluate", str(model), recording]
        how = rng.choice(("known", "detected", "detected"))
        case.commands.append([*words, "--contacts", how])
    else:
        words = ["live", "--device", recording, "--speed", "inf", "--model", str(model)]
        case.commands.append([*words, "--json"] if rng.random() < 0.5 else words)


def _import(rng: Random, seeds: Seeds, folder: Path, case: Case) -> None:
    make = rng.choice(fuzz_imports.MAKERS)
    case.route = f"import: {make.__name__}"
    out = str(folder / "out")
    case.commands.append(["import", *make(rng, seeds, folder), "--out", out])
    if rng.random() < 0.15:  # what was taken must be of use
        case.commands.append(["export", out, "--to", "csv", "--out", f"{folder}/c"])


def _text(rng: Random, seeds: Seeds, folder: Path, case: Case) -> None:
    kind = rng.choice(("calibration", "calibration", "plan", "weights"))
    path = folder / kind
    out = str(folder / "out")
    if kind == "calibration":
        path.write_bytes(mutate.tree(rng, json.loads(seeds.calibration.read_text())))
        if rng.random() < 0.6:
            words = ["live", "--device", str(seeds.recordings[0]), "--speed", "inf"]
            case.commands.append(
                [*words, "--model", str(seeds.models[-1]), "--calibration", str(path)]
            )
        else:
            case.commands.append(
                ["record", "--device", NO_PORT, "--out", out, "--object", "x", "--calibration",
                 str(path)]
            )  # fmt: skip
        return
    path.write_bytes(mutate.table(rng, seeds.tables[kind]))
    if kind == "plan":
        case.commands.append(["record", "--device", NO_PORT, "--out", out, "--plan", str(path)])
    else:
        case.commands.append(
            ["calibrate", "--device", NO_PORT, "--out", out, "--weights", str(path)]
        )


def _path(rng: Random, seeds: Seeds, folder: Path, case: Case) -> None:
    """Make a path without a file, or a file name with control characters."""
    names = ("x.mcap", "x.csv", "x.npz", "x.h5", "a\x1b[2J.mcap", "b\nc.mcap", "\udcff.mcap",
             "é.mcap", "x" * 240 + ".mcap", "-x.mcap", " .mcap")  # fmt: skip
    path = folder / rng.choice(names)
    kind = rng.randrange(8)
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.mkdir()
    elif kind == 2:
        path.symlink_to(path)
    elif kind == 3:
        path.symlink_to(rng.choice(("/dev/zero", "/dev/null", "/dev/full", "/proc/self/mem", "/")))
    elif kind == 4:
        path.write_bytes(b"")
    elif kind == 5:
        shutil.copy(rng.choice(seeds.recordings), path)
    elif kind == 6:
        path.write_bytes(rng.randbytes(rng.choice((1, 8, 4096, 8192))))
    file, out = str(path), str(folder / "out")
    good, model = str(seeds.recordings[0]), str(seeds.models[0])
    live = ["live", "--speed", "inf", "--device"]
    case.commands.append(
        rng.choice(
            (
                ["inspect", file],
                ["export", file, "--to", "csv", "--out", out],
                ["export", str(folder), "--to", "csv", "--out", f"{folder}/../{folder.name}.csv"],
                ["export", good, "--to", "hdf5", "--out", file],
                ["import", file, "--out", out],
                ["import", str(folder), "--out", f"{folder}/../{folder.name}.out"],
                ["evaluate", model, file],
                ["evaluate", file, good],
                [*live, file, "--model", model],
                [*live, good, "--model", file],
                [*live, good, "--model", model, "--calibration", file],
                ["record", "--device", NO_PORT, "--out", out, "--plan", file],
                ["camera", good, "--times", file],
                ["inspect", good, "--plot", file],
                ["train", file, "--out", out],
            )
        )
    )


def _wire(rng: Random, seeds: Seeds, folder: Path, case: Case) -> None:
    kind = rng.choice(WIRE)
    case.route = f"wire: {kind.__name__}"
    case.calls.append(lambda: kind(rng, folder))


#: What comes over wires and from pages.
WIRE = (
    fuzz_wire.descriptor, fuzz_wire.frames, fuzz_wire.frames, fuzz_wire.requests,
    fuzz_wire.answers, fuzz_wire.page, fuzz_wire.lines, fuzz_wire.stamps,
    fuzz_label.labels, fuzz_label.journal,
)  # fmt: skip
Maker = Callable[[Random, Seeds, Path, Case], None]
#: Name of a way in to how often it is tried, and what makes an input for it.
WAYS: dict[str, tuple[int, Maker]] = {
    "recording": (42, _recording),
    "model": (30, _model),
    "import": (36, _import),
    "text": (6, _text),
    "path": (4, _path),
    "wire": (12, _wire),
}
