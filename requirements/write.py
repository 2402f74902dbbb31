"""Write the files beside this one: every package to install, its version and its hashes.

The versions are those of ``constraints.txt``; what it does not have yet is chosen and
added there. Each package stands in one file, each file is a layer:

    base    what studies and live both need, and what builds the package
    study   what only studies need
    live    what only live needs
    dev     what only tests, checks and docs need
    cuda    the PyTorch of PyPI, and the CUDA that it brings along
    cpu     the same PyTorch built for CPUs only, for pips that are told where to find it

Run by ``make constraints``.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parents[1]
CONSTRAINTS = ROOT / "constraints.txt"
LAYERS = ("base", "study", "live", "dev", "cuda")
#: PyTorch, and what only its CUDA build asks for.
CUDA = ("torch", "cuda-", "nvidia-", "triton")
_HEAD = "# Made by `make constraints`: do not edit.\n"
_ENTRY = re.compile(r"^[A-Za-z0-9].*?(?=^[A-Za-z0-9]|\Z)", re.MULTILINE | re.DOTALL)
_HASH = re.compile(r"--hash=(sha256:[0-9a-f]{64})")


def resolve(*extras: str) -> dict[str, str]:
    """Name to its lines, "name==version ; marker" and hashes, of extras and all they need."""
    command = [
        *("uv", "pip", "compile", "--quiet", "--universal", "--python-version", "3.11"),
        *("--generate-hashes", "--no-header", "--no-annotate"),
        *(option for extra in extras for option in ("--extra", extra)),
        *("--constraint", CONSTRAINTS, "pyproject.toml", "-"),
    ]
    # Beside the extras: what builds the package, which pip must not fetch by itself.
    process = subprocess.run(
        command, cwd=ROOT, input="setuptools", text=True, stdout=subprocess.PIPE, check=True
    )
    return entries(process.stdout)


def entries(text: str) -> dict[str, str]:
    """Return the entries of a requirements file by the names of their packages."""
    return {name(entry): entry for entry in _ENTRY.findall(text)}


def name(entry: str) -> str:
    """Return the normal form of the name that an entry begins with."""
    return re.sub(r"[-_.]+", "-", entry.partition("==")[0]).lower()


def version(entry: str) -> str:
    """Return the version that an entry pins."""
    return entry.partition("==")[2].split()[0]


def with_hashes(entry: str, hashes: Iterable[str]) -> str:
    """Return the entry with these hashes only."""
    head = entry.partition("\\")[0].strip()
    return " \\\n    --hash=".join((head, *sorted(set(hashes)))) + "\n"


def for_cpus(torch: str, folders: Iterable[Path], pinned: str) -> str:
    """Return the entry of the PyTorch for CPUs, or "" if no wheel of it is known.

    Parameters
    ----------
    torch
        The entry of PyPI.
    folders
        Folders to search for wheels.
    pinned
        The previous entry. Its wheels need not be on this machine again.
    """
    wanted = f"{version(torch)}+cpu"
    hashes = set(_HASH.findall(pinned)) if pinned and version(pinned) == wanted else set()
    for wheel in (w for folder in folders for w in folder.glob(f"torch-{wanted}-*.whl")):
        hashes.add("sha256:" + hashlib.sha256(wheel.read_bytes()).hexdigest())
    return with_hashes(f"torch=={wanted}", hashes) if hashes else ""


def write(layer: str, lines: list[str]) -> None:
    """Write the file of a layer."""
    (ROOT / "requirements" / f"{layer}.txt").write_text("".join((_HEAD, *lines)))


def main() -> int:
    """Resolve, write every layer, and the constraints with what was added."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--wheels",
        type=Path,
        nargs="*",
        default=[],
        help="folders with wheels of the PyTorch for CPUs",
    )
    wheels = parser.parse_args().wheels
    study, live, dev = resolve("study"), resolve("live"), resolve("dev")
    layers: dict[str, dict[str, str]] = {layer: {} for layer in LAYERS}
    for package, entry in dev.items():
        if package.startswith(CUDA):
            layer = "cuda"
        elif package in study and package in live:
            layer = "base"
        else:
            layer = "study" if package in study else "live" if package in live else "dev"
        layers[layer][package] = entry
    for layer, packages in layers.items():
        write(layer, [with_hashes(e, _HASH.findall(e)) for _, e in sorted(packages.items())])
    cpu = ROOT / "requirements" / "cpu.txt"
    pinned = entries(cpu.read_text()).get("torch", "") if cpu.exists() else ""
    entry = for_cpus(dev["torch"], wheels, pinned)
    if entry:
        write("cpu", [entry])
    else:  # with an empty one pip would be content
        cpu.unlink(missing_ok=True)
    head = [line for line in CONSTRAINTS.read_text().splitlines() if line.startswith("#")]
    pins = [f"{package}=={version(entry)}" for package, entry in sorted(dev.items())]
    CONSTRAINTS.write_text("\n".join((*head, *pins)) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
