"""Documented commands run: here, or in the place that ``ELSEWHERE`` names.

The fences of a page run one after the other, in one folder that holds only ``examples/``. A page
stops at the first failure. A comment on the line before a ``sh`` fence states when it runs:

- none: with the normal tests, or with ``make test-slow`` (``LONG_PAGES``); the tutorials run one
  page after the other in one folder;
- ``<!-- slow -->``: with ``make test-slow``;
- ``<!-- data -->``: with the normal tests, if the real impacts exist (``FIRSTCONTACT_DATA``);
- ``<!-- disc -->``: by ``test_two_euro_disc.py``, if there is a sound input;
- ``<!-- elsewhere -->``: not here; each of its commands has a line in ``ELSEWHERE``.

Python in ``python`` fences runs too, each fence separately.

Sets and studies are smaller here, and the simulated hand is faster than real time (``SMALL``,
``STUDY``, ``FASTER``).
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages import PAGES, ROOT, Fence, fences, name

import forked
from firstcontact.cli.options import parse_options
from firstcontact.cli.verbs import configuration

#: Commands that build an environment or take long, and what runs them.
ELSEWHERE = {
    "firstcontact live --device twin --hand twin --page": "tests/cli/test_live.py",
    "git clone ADDRESS firstcontact": "by hand: the reader knows the address",
    "cd firstcontact": "as above",
    "firstcontact label long --out labelled": "tests/collect/test_label_page.py",
    "firstcontact simulate --out recordings --pinches-per-block 12 --pinches-per-object 0": (
        "tests/docs/test_docstrings.py, which also runs the examples"
    ),
    "python examples/biotac_tables.py biotac_hold/data labels.csv channels.csv": (
        "tests/recording/test_recording_mat.py, where the recordings are"
    ),
    "firstcontact import biotac_hold/data --labels labels.csv --channels channels.csv "
    "--source real --out held": "tests/recording/test_recording_mat.py, where the recordings are",
    "my-trigger | firstcontact live --device /dev/ttyACM0 --model model --hand ability "
    "--hand-port /dev/ttyUSB0": "tests/cli/test_live.py",
    "sudo adduser $USER dialout": "by hand, once on a machine with a device",
    "firstcontact replay pinches/blocks-01.mcap --link fingertip": "tests/cli/test_replay.py",
    "firstcontact pretrain --out network --work pretraining": (
        "by hand: it makes the weights of the package; small: tests/lab/verbs/test_pretrain.py"
    ),
    "firstcontact simulate --out twin --condition everyday --pinches-per-block 60 "
    "--pinches-per-object 30 --seed 7": "by hand: the pinches of the package's detector",
    "firstcontact train twin --out detector --detector-only": (
        "by hand: it makes the detector of the package"
    ),
    'python docs/write_out_of_range.py --measure --data "$FIRSTCONTACT_DATA"': (
        "by hand before a release: it makes the table of out-of-range signals"
    ),
    "firstcontact flash-model model --device /dev/ttyACM0": "tests/firmware/test_flash_model.py",
    "firstcontact live --device /dev/ttyACM0 --model model": "tests/firmware/test_hand_answers.py",
    "make study": "by hand before a release: it makes docs/results/study.json",
    "firstcontact grasp-study": "by hand before a release: it makes docs/results/grasp.json",
    "make real": "by hand before a release: it makes docs/results/real.json",
    "make embedded": "by hand before a release: it makes docs/results/embedded.json",
    "make quick-embedded": ".ci/run",
    "make readme-numbers": "by hand before a release; its script: tests/docs/test_tables.py",
    "make test": ".ci/run",
    "make lint": ".ci/run",
    "make types": ".ci/run",
    "make layers": ".ci/run",
    "make docs": ".ci/run",
    "make quick": ".ci/run",
    "make test-slow": "by hand before a release",
    "make fuzz": "by hand: tests/fuzz runs some hundred inputs",
    "make mutation": "by hand: it takes an hour",
    "make soak": "by hand: tests/soak runs two minutes with the slow tests",
    "make bench": "by hand: its numbers are in docs/reference/lab-notes.md",
    "make wheel": "by hand before a release; wheels: tests/cli/test_install.py",
    "make install": "each other target runs its recipe",
    "make format": "by hand",
    "make constraints": "by hand, when versions are raised",
    ".ci/run": "itself",
    "make -C firmware sketch-folder": "tests/firmware/test_sketch.py",
    "make -C firmware sketch": "tests/firmware/test_sketch.py",
    "make -C firmware native": "tests/firmware/conftest.py",
    "make -C firmware size": "by hand: it makes the table of docs/reference/firmware.md",
    "make -C firmware test": "make test runs these, too",
    "firmware/build/firstcontact-device --scans twin.scans": "tests/firmware/test_native_device.py",
    "firmware/build/firstcontact-device --scans twin.scans --models models.flash": (
        "tests/firmware/test_flash_model.py"
    ),
    "make -C firmware sketch-native": "tests/firmware/test_teensy.py",
    (
        "firmware/build/firstcontact-teensy --scans twin.scans --flash teensy.flash --unread yes "
        "--serial1 lines.txt"
    ): "tests/firmware/test_teensy.py",
    "apt install gcc g++ libc6-dev make": ".ci/run, where they are missing",
    "apt install --no-install-recommends gcc-arm-none-eabi libnewlib-arm-none-eabi": (
        ".ci/run, where they are missing"
    ),
    "apt install --no-install-recommends qemu-system-arm": ".ci/run, where it is missing",
    "pip install .": "tests/cli/test_install.py",
    "pip install '.[foxglove]'": "make test, in editable form",
    "firstcontact live --device twin --foxglove": "tests/streaming/test_foxglove.py",
    "pip install '.[audio,live]'": "make test, in editable form",
    "sudo apt install libportaudio2": ".ci/run, where it is missing",
    "pip install '.[live]'": "tests/cli/test_install.py",
    "pip install '.[study,live]'": "make test, in editable form",
    "pip install torch --index-url https://download.pytorch.org/whl/cpu": "make, where it can",
    "make test-install": ".ci/run",
    "make test-oldest": "by hand, when a lower bound changes",
    "pip install '.[study,cluster]'": "make test, in editable form",
    "dask scheduler --host 10.0.0.1 --port 8786": "tests/dask_cluster.py",
    "dask worker tcp://10.0.0.1:8786 --nworkers auto --nthreads 1": "tests/dask_cluster.py",
    "firstcontact study --cluster tcp://10.0.0.1:8786": "tests/cli/test_cluster.py",
    "make live": "tests/cli/test_live.py runs its command",
}
MARKS = {"", "slow", "data", "disc", "elsewhere"}
LANGUAGES = {"sh", "python", "pycon", "text", "json", "toml", ""}
ALL = [fence for page in PAGES for fence in fences(page)]


def pages_with(*marks: str) -> list[Path]:
    """Return the pages with commands that have one of these marks."""
    return [
        page for page in PAGES if any(f.language == "sh" and f.mark in marks for f in fences(page))
    ]


#: Set of pinches in a page, and the smaller one that is made instead.
LARGE = "--pinches-per-block 40 --pinches-per-object 4"
SMALL = "--pinches-per-block 12 --pinches-per-object 2"
#: Study of recordings, which runs with short trainings.
STUDY = "firstcontact study --recordings"
#: Commands with the simulated hand that are run faster, where they do not say how fast.
FASTER = ("firstcontact live --device twin", "firstcontact record --device twin")


def run(page: Path, folder: Path, marks: set[str], cache: Path) -> str:
    """Run the commands of a page that have one of these marks, and return the output."""
    shutil.copytree(ROOT / "examples", folder / "examples", dirs_exist_ok=True)
    script = "".join(f.body for f in fences(page) if f.language == "sh" and f.mark in marks)
    text, place = "", folder
    for command in in_parts(script.replace("\\\n", " ")):
        if command.startswith("cd "):
            place = (place / command.removeprefix("cd ")).resolve()
            continue
        # A new interpreter finds modules in a folder that the page changed to: with the shell.
        process = run_part(command if place == folder else f"{command}\n", place, cache)
        text += process.stdout + process.stderr
        assert process.returncode == 0, f"{name(page)}\n{command}\n{text}"
    return text


def in_parts(script: str) -> list[str]:
    """Split a script into commands of the package, changes of folder, and parts for the shell."""
    parts = [""]
    for line in script.splitlines():
        if of_package(line) or line.startswith("cd "):
            parts += [" ".join(line.split()), ""]
        else:
            parts[-1] += line + "\n"
    return [part for part in parts if part.strip()]


def of_package(command: str) -> bool:
    """Return True for a command of the package that needs no shell."""
    return command.startswith("firstcontact ") and not set("|<>$;&`\n") & set(command)


def run_part(command: str, folder: Path, cache: Path) -> subprocess.CompletedProcess[str]:
    """Run a command of the package, or a script of the shell."""
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    if of_package(command):
        command = command.replace(LARGE, SMALL)
        if command.startswith(FASTER) and "--speed" not in command:
            command += " --speed 8"
        if command.startswith(STUDY):
            command += " --quick"
        if "live --device twin" in command:
            environment["XDG_CACHE_HOME"] = str(cache)
        return forked.firstcontact(*shlex.split(command)[1:], cwd=folder, env=environment)
    environment["PATH"] = str(Path(sys.executable).parent) + os.pathsep + os.environ["PATH"]
    return subprocess.run(
        ["bash", "-c", "set -euo pipefail\n" + command],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )


TUTORIALS = [page for page in pages_with("") if page.parent.name == "tutorial"]


@pytest.mark.timeout(900)  # a hand in real time among them
def test_tutorials_run_in_a_row_in_one_folder(tmp_path: Path, user_cache: Path) -> None:
    assert len(TUTORIALS) == 3
    for page in TUTORIALS:
        text = run(page, tmp_path, {""}, user_cache)
        # None ends in advice to record more, or finds the files of another.
        assert not re.search("too few|did not make|replaced", text), f"{name(page)}\n{text}"


@pytest.mark.parametrize("page", pages_with(*MARKS), ids=name)
def test_commands_have_the_options_that_they_are_given(page: Path) -> None:
    for command in (c for f in fences(page) if f.language == "sh" for c in f.commands):
        if of_package(command) and not re.match("firstcontact --", command):
            _, verb, *options = shlex.split(command)
            parse_options(configuration(verb), command, options)


def test_no_two_tutorials_write_to_the_same_place() -> None:
    written: dict[str, Path] = {}
    for page in sorted({f.page for f in ALL if f.page.parent.name == "tutorial"}):
        text = "".join(f.body for f in fences(page) if f.language == "sh")
        for place in re.findall(r"(?:--out|>) +(\S+)", text):
            assert written.setdefault(place, page) == page, place


#: Pages with commands that take long, and the fast tests of the same verbs with the same device.
LONG_PAGES = {
    "docs/how-to/calibrate.md": "tests/cli/test_calibrate.py",
    "docs/how-to/drive-a-hand.md": "tests/cli/test_live.py",
    "docs/how-to/record-a-dataset.md": "tests/cli/test_record.py, and a tutorial",
}


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(p, id=name(p), marks=[pytest.mark.slow] if name(p) in LONG_PAGES else [])
        for p in pages_with("")
        if p not in TUTORIALS
    ],
)
def test_commands_run(page: Path, tmp_path: Path, user_cache: Path) -> None:
    run(page, tmp_path, {""}, user_cache)


@pytest.mark.parametrize("page", pages_with("data"), ids=name)
def test_commands_run_on_the_real_impacts(
    page: Path,
    tmp_path: Path,
    user_cache: Path,
    impacts: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("FIRSTCONTACT_DATA", str(impacts.parent))
    run(page, tmp_path, {"", "data"}, user_cache)


@pytest.mark.slow
@pytest.mark.parametrize("page", pages_with("slow"), ids=name)
def test_long_commands_run(page: Path, tmp_path: Path, user_cache: Path) -> None:
    run(page, tmp_path, {"", "slow"}, user_cache)


@pytest.mark.parametrize(
    "fence",
    [f for f in ALL if f.language == "python"],
    ids=lambda f: f"{name(f.page)}:{f.line}",
)
def test_python_runs(fence: Fence, tmp_path: Path) -> None:
    process = forked.run("code", fence.body, cwd=tmp_path, strict=True)
    assert process.returncode == 0, process.stderr


def test_every_fence_says_what_it_is() -> None:
    for fence in ALL:
        location = f"{name(fence.page)}:{fence.line}"
        assert fence.mark in MARKS, location
        assert fence.language in LANGUAGES, f"{location}: commands stand in sh fences"


def test_no_command_hides_in_another_fence() -> None:
    for fence in ALL:
        if fence.language in {"sh", "python"}:
            continue
        first_words = {line.split()[0] for line in fence.body.splitlines() if line.split()}
        hidden = first_words & {"make", "firstcontact", "pip", "python", "git", "$"}
        assert not hidden, f"{name(fence.page)}:{fence.line}: {hidden}"


def test_what_runs_elsewhere_is_listed_and_the_list_has_no_more() -> None:
    displayed = {c for f in ALL if f.mark == "elsewhere" for c in f.commands}
    assert displayed - set(ELSEWHERE) == set()
    assert {c for c, place in ELSEWHERE.items() if c not in displayed} == set()
    assert set(LONG_PAGES) <= {name(page) for page in pages_with("")}


@pytest.mark.parametrize("command", [c for c in ELSEWHERE if c.startswith("make ")])
def test_make_targets_exist(command: str) -> None:
    process = subprocess.run(
        [*command.split(), "--dry-run"], cwd=ROOT, capture_output=True, text=True
    )
    assert process.returncode == 0, process.stderr


@pytest.mark.parametrize("command", [c for c, place in ELSEWHERE.items() if place == ".ci/run"])
def test_ci_runs_what_it_is_said_to_run(command: str) -> None:
    lines = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert any(line.split()[: len(command.split())] == command.split() for line in lines)
