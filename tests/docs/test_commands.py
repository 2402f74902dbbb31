"""Documented commands run, or have the options, targets and scripts that they name.

The fences of a page run one after the other, in one folder that holds only ``examples/``. A page
stops at the first failure. A comment on the line before a ``sh`` fence states when it runs:

- none: with the normal tests, or with ``make test-slow`` (``LONG_PAGES``); the tutorials run one
  page after the other in one folder;
- ``<!-- slow -->``: with ``make test-slow``;
- ``<!-- data -->``: with the normal tests, if the real impacts exist (``FIRSTCONTACT_DATA``);
- ``<!-- disc -->``: by ``test_two_euro_disc.py``, if there is a sound input;
- ``<!-- elsewhere -->``: not here, because it builds an environment, takes long or needs hardware.

Python in ``python`` fences runs too, each fence separately.

Sets and studies are smaller here, and the simulated hand is faster than real time (``SMALL``,
``STUDY``, ``FASTER``).
"""

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
    "docs/how-to/check-a-fingertip.md": "tests/collect/test_check.py, tests/cli/test_calibrate.py",
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
    page: Path, tmp_path: Path, user_cache: Path, impacts: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIRSTCONTACT_DATA", str(impacts.parent))
    run(page, tmp_path, {"", "data"}, user_cache)


@pytest.mark.slow
@pytest.mark.parametrize("page", pages_with("slow"), ids=name)
def test_long_commands_run(page: Path, tmp_path: Path, user_cache: Path) -> None:
    run(page, tmp_path, {"", "slow"}, user_cache)


@pytest.mark.parametrize(
    "fence", [f for f in ALL if f.language == "python"], ids=lambda f: f"{name(f.page)}:{f.line}"
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


def test_make_targets_and_scripts_exist() -> None:
    commands = {c for f in ALL if f.language == "sh" for c in f.commands}
    for words in map(str.split, commands):
        if words[0] == "make":
            process = subprocess.run(
                [*words, "--dry-run"], cwd=ROOT, capture_output=True, text=True
            )
            assert process.returncode == 0, process.stderr
        elif words[0] == "python" and words[1].endswith(".py"):
            assert (ROOT / words[1]).is_file() or (ROOT / "examples" / words[1]).is_file(), words
    assert set(LONG_PAGES) <= {name(page) for page in pages_with("")}
