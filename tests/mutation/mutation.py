"""Mutation check: introduce the faults of ``faults.toml`` one at a time and run the fast tests.

Each fault goes into a scratch copy of the tree. The tests of the same room then run until the first
failure: ``tests/ROOM`` tests ``src/firstcontact/ROOM``. They must pass once without a fault first.
A fault in a compiled kernel names the room that uses the kernel. The command ends with 1 if the
tests missed a fault, or if a fault's old text does not occur exactly once.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FAULTS = Path(__file__).with_name("faults.toml")
#: Longest run of a room's tests, s. A fault that makes them hang is found.
LONG = 1800


@dataclass(frozen=True)
class Fault:
    """Fault to introduce: a file, a text in it, its replacement, and a description."""

    meaning: str
    file: str
    old: str
    new: str
    room: str = ""

    @property
    def tests(self) -> str:
        """Folder of the tests that must detect the fault."""
        return f"tests/{self.room or Path(self.file).parts[2]}"


def faults() -> list[Fault]:
    """Return the faults of the data file."""
    with FAULTS.open("rb") as file:
        return [Fault(**fault) for fault in tomllib.load(file)["fault"]]


def outcome(fault: Fault, copy: Path, words: list[str]) -> tuple[str, str]:
    """Return "found", "survived" or "stale", and the test that detected the fault.

    Parameters
    ----------
    fault
        The fault.
    copy
        Scratch copy of the tree, unchanged afterwards.
    words
        Further arguments of pytest.
    """
    path = copy / fault.file
    text = path.read_text(encoding="utf-8")
    if text.count(fault.old) != 1:
        return "stale", ""
    try:
        path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
        if path.suffix == ".c":
            build(copy)
        test = failed_test(fault.tests, copy, words)
    finally:
        path.write_text(text, encoding="utf-8")
    if path.suffix == ".c":
        build(copy)
    return ("found" if test else "survived"), test


def failed_test(tests: str, copy: Path, words: list[str]) -> str:
    """Run the tests of a folder. Return the name of the first that failed, or an empty text."""
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", tests, *words]
    environment = {**os.environ, "PYTHONPATH": str(copy / "src")}
    try:
        process = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, text=True, timeout=LONG
        )
    except subprocess.TimeoutExpired:
        return "the tests hang"
    if process.returncode == 0:
        return ""
    failed = [line for line in process.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    if not failed:
        raise RuntimeError(process.stdout + process.stderr)
    return failed[0].split()[1]


def scratch(folder: Path) -> Path:
    """Copy the tracked files into a folder, and compile the kernels there."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    for name in filter(None, listed.stdout.decode().split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    build(folder)
    return folder


def build(copy: Path) -> None:
    """Compile the kernels of a copy, where there is a C compiler. Git does not track them."""
    for library in copy.glob("src/firstcontact/*/_compiled.abi3.so"):
        library.unlink()
    command = [sys.executable, "-c", "import setuptools; setuptools.setup()"]
    subprocess.run([*command, "build_ext", "--inplace"], cwd=copy, capture_output=True, check=True)


def main() -> int:
    """Check all faults, or those whose description contains a text."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="faults with this text in file or meaning")
    parser.add_argument("--out", type=Path, help="results as JSON")
    options, words = parser.parse_known_args()
    results = []
    sound: set[str] = set()
    with tempfile.TemporaryDirectory() as folder:
        copy = scratch(Path(folder))
        for fault in faults():
            if options.only not in fault.file + fault.meaning:
                continue
            if fault.tests not in sound:
                if test := failed_test(fault.tests, copy, words):
                    sys.exit(f"{fault.tests} fails without a fault: {test}")
                sound.add(fault.tests)
            began = time.monotonic()
            word, test = outcome(fault, copy, words)
            seconds = time.monotonic() - began
            print(f"{word:9} {fault.file}: {fault.meaning} ({seconds:.0f} s) {test}", flush=True)
            results.append(
                {"meaning": fault.meaning, "file": fault.file, "outcome": word, "test": test}
            )
    if options.out:
        options.out.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    missed = [r for r in results if r["outcome"] != "found"]
    print(f"{len(results) - len(missed)} of {len(results)} faults found")
    return bool(missed)


if __name__ == "__main__":
    sys.exit(main())
