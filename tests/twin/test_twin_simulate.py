"""Tests of simulated sets: their plan, files, errors, and the same bytes for the same seed."""

import hashlib
import math
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pinches import EVERYDAY, PAPER_RIG
from pinches import simulated as simulated_pinch

from firstcontact.core import InputError, Role
from firstcontact.recording import load_dataset, read_recording
from firstcontact.twin import BLOCKS
from firstcontact.twin.draw import Condition
from firstcontact.twin.simulation import plan_sessions, simulate_recordings
from processes import full_disk


def digests(folder: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(folder.iterdir())}


def simulate_set(
    folder: Path, seed: int = 3, workers: int = 1, condition: str = "everyday"
) -> Path:
    simulate_recordings(folder, condition, 4, 2, seed, workers)
    return folder


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate_set(tmp_path_factory.mktemp("set") / "new")


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_same_seed_gives_the_same_bytes_for_any_workers(
    simulated: Path, tmp_path: Path, workers: int
) -> None:
    assert digests(simulate_set(tmp_path / "again", workers=workers)) == digests(simulated)


def test_another_seed_or_condition_gives_another_set(simulated: Path, tmp_path: Path) -> None:
    others = (
        simulate_set(tmp_path / "seed", seed=4),
        simulate_set(tmp_path / "rig", condition="paper-rig"),
    )
    for other in others:
        assert set(digests(simulated).values()).isdisjoint(digests(other).values())


@pytest.mark.parametrize(
    ("condition", "samples"), [(PAPER_RIG, [704, 915]), (EVERYDAY, [643, 755])]
)
def test_a_seed_draws_the_contacts_of_earlier_versions(
    condition: Condition, samples: list[int]
) -> None:
    assert [c.sample for c in simulated_pinch(BLOCKS[0], 7, condition).truth] == samples


def test_set_has_labels_and_contacts(simulated: Path) -> None:
    dataset = load_dataset(simulated)
    assert len(dataset) == 5 * 4 + 8 * 2
    assert dataset.source == "twin"
    assert set(dataset.shore_a[~dataset.test]) == {10, 20, 29, 43, 60}
    assert set(dataset.shore_a[dataset.test]) == {28, 26, 35, 37, 45, 46, 59, 67}
    for pinch in dataset.pinches:
        assert len(pinch.truth) == 2
        assert pinch.offset >= 0
        strips = np.array([pinch.strip(c.finger)[:, 0] for c in pinch.truth])
        for strip, contact in zip(strips, pinch.truth, strict=True):
            assert np.argmax(strip > 0) == contact.sample - pinch.first_sample
    for path in simulated.iterdir():
        header = read_recording(path).header
        assert header.source == "twin"
        assert "everyday" in header.notes
        assert "seed 3" in header.notes


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("pinches_per_block", -1), ("pinches_per_block", 1.0), ("pinches_per_object", 10**30),
        ("pinches_per_object", "1"), ("seed", -1), ("seed", math.nan), ("workers", 0),
        ("workers", np.float64(2)),
    ],
)  # fmt: skip
def test_invalid_numbers_are_refused_by_name_and_write_nothing(
    tmp_path: Path, name: str, value: Any
) -> None:
    with pytest.raises(InputError) as caught:
        simulate_recordings(tmp_path / "out", **{name: value})
    assert caught.value.parameter == name
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("arguments", [("lab", 1, 1), ("paper-rig", 0, 0)])
def test_an_unknown_condition_and_no_pinches_are_refused(
    tmp_path: Path, arguments: tuple[str, int, int]
) -> None:
    with pytest.raises(InputError):
        simulate_recordings(tmp_path / "out", *arguments)
    assert not list(tmp_path.iterdir())


def test_folder_with_files_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match=tmp_path.name):
        simulate_recordings(tmp_path, "paper-rig", 1, 0)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]
    with pytest.raises(InputError, match=r"mine\.txt/out"):
        simulate_recordings(tmp_path / "mine.txt" / "out", "paper-rig", 1, 0)


def test_error_leaves_no_partial_file(tmp_path: Path) -> None:
    def stop(count: int) -> None:
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        simulate_recordings(tmp_path / "out", "paper-rig", 4, 0, 0, 2, stop)
    assert not list(tmp_path.iterdir())


KILLED = """
import os, signal, sys
from pathlib import Path
from typing import Any
from firstcontact.twin.simulation import simulate_recordings

made = 0
def progress(done):
    global made
    made += done
    if made > 4:  # the first recording is whole
        os.kill(os.getpid(), signal.SIGKILL)

simulate_recordings(Path(sys.argv[1]), "everyday", 4, 2, 3, 1, progress)
"""


def test_killed_simulation_leaves_no_recordings(tmp_path: Path) -> None:
    out = tmp_path / "out"
    (tmp_path / "beside").mkdir()
    result = subprocess.run([sys.executable, "-c", KILLED, str(out)], check=False)
    assert result.returncode == -signal.SIGKILL
    assert not out.exists()
    with pytest.raises(InputError):
        load_dataset(tmp_path)  # nor what was left half made beside it
    simulate_set(out)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["beside", "out"]


def test_full_disk_is_refused_with_the_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with full_disk(20_000), pytest.raises(InputError, match=str(out)):
        simulate_recordings(out, "paper-rig", 4, 0)
    assert not list(tmp_path.iterdir())


def test_the_paper_size_has_its_pinches_in_sessions() -> None:
    sessions = plan_sessions(PAPER_RIG, 500, 50, 0)
    labels = [p.label for s in sessions for p in s.pinches]
    assert Counter(x.role for x in labels) == {Role.TRAIN: 2500, Role.TEST: 400}
    assert set(Counter(x.object for x in labels if x.role is Role.TRAIN).values()) == {500}
    assert set(Counter(x.object for x in labels if x.role is Role.TEST).values()) == {50}
    objects = {x.object: x.shore_a for x in labels}
    assert sorted(objects.values()) == [10, 20, 26, 28, 29, 35, 37, 43, 45, 46, 59, 60, 67]
    for s in sessions:
        assert {p.label.session for p in s.pinches} == {s.name}
        assert len({p.label.object for p in s.pinches}) in (5, 8)
    assert len(sessions) == 12


def test_specimens_are_the_same_in_all_sessions() -> None:
    moduli: dict[str, set[float]] = {}
    for s in plan_sessions(EVERYDAY, 60, 4, 3):
        for p in s.pinches:
            moduli.setdefault(p.label.specimen, set()).add(p.specimen.nominal.modulus)
    assert {len(m) for m in moduli.values()} == {1}
    assert len({m for ms in moduli.values() for m in ms}) == len(moduli)


def test_objects_are_in_shuffled_order() -> None:
    (session, *_) = plan_sessions(PAPER_RIG, 100, 0, 0)
    order = [p.label.object for p in session.pinches]
    assert order != sorted(order)
    for seed, is_same in ((0, True), (1, False)):
        again = plan_sessions(PAPER_RIG, 100, 0, seed)[0]
        assert ([p.label.object for p in again.pinches] == order) is is_same


@pytest.mark.parametrize(("blocks", "objects", "sessions"), [(2, 0, 2), (0, 1, 1), (3, 1, 4)])
def test_small_sets_have_as_many_sessions_as_pinches(
    blocks: int, objects: int, sessions: int
) -> None:
    planned = plan_sessions(PAPER_RIG, blocks, objects, 0)
    assert len(planned) == sessions
    assert sum(len(s.pinches) for s in planned) == 5 * blocks + 8 * objects
