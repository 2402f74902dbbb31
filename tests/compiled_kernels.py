"""The compiled kernels, built from their sources, and NumPy in place of them."""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

from firstcontact.core import InputError, installation
from firstcontact.core.installation import kernels

SOURCES = Path(installation.__file__).parent / "c"
FIRMWARE = Path(__file__).parents[1] / "firmware" / "core"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
#: Optimised less than where it is installed: the same bits in less than half the time.
OPTIONS = (
    *("-O1", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),
    *("-fPIC", "-shared"),
)


@cache
def built_kernels() -> ModuleType:
    """Return the kernels of this checkout, whether or not it was installed with them."""
    try:
        module: ModuleType = kernels()
    except InputError:
        module = compiled_kernels()
    return module


def compiled_kernels() -> ModuleType:
    """Return the kernels, compiled now, without warnings of the compiler."""
    compiler = shutil.which("cc")
    header = Path(sysconfig.get_path("include"))
    if compiler is None or not (header / "Python.h").is_file():
        pytest.skip("no C compiler, or no headers of Python")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "_compiled.abi3.so"
        command: list[str | Path] = [
            compiler,
            *STRICT,
            *OPTIONS,
            "-isystem",
            header,
            "-I",
            FIRMWARE,
            *sorted(SOURCES.glob("*.c")),
            *(FIRMWARE / name for name in ("fc_cobs.c", "fc_crc32.c")),
        ]
        subprocess.run([*command, "-lm", "-o", library], check=True)
        loader = ExtensionFileLoader("_compiled", str(library))
        spec = spec_from_file_location("_compiled", library, loader=loader)
        assert spec is not None
        module = module_from_spec(spec)
        loader.exec_module(module)
    return module


@contextmanager
def using(module: ModuleType | str | None) -> Iterator[None]:
    """Use these kernels within the block, NumPy if None, or fail with a message."""

    def load() -> ModuleType | None:
        if isinstance(module, str):
            raise InputError(module)
        return module

    usual, installation._load_kernels = installation._load_kernels, load  # type: ignore[assignment]
    try:
        yield
    finally:
        installation._load_kernels = usual
