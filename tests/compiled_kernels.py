"""The compiled kernels, built from their sources."""

import shutil
import subprocess
import sysconfig
import tempfile
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

from firstcontact.core import installation

ROOMS = Path(installation.__file__).parents[1]
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
#: Optimised less than where it is installed: the same bits in less than half the time.
OPTIONS = (
    *("-O1", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),
    *("-fPIC", "-shared"),
)


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
            ROOMS / "c" / "python",
            *sorted((ROOMS / "twin" / "c").glob("*.c")),
            ROOMS / "c" / "python" / "arrays.c",
        ]
        subprocess.run([*command, "-lm", "-o", library], check=True)
        frames = ROOMS / "device" / "c" / "frames.c"
        folders = ["-isystem", header, "-I", ROOMS / "c/wire", "-I", ROOMS / "c/python"]
        checked = [compiler, *STRICT, "-fsyntax-only", *folders, frames]
        subprocess.run(checked, check=True)
        loader = ExtensionFileLoader("_compiled", str(library))
        spec = spec_from_file_location("_compiled", library, loader=loader)
        assert spec is not None
        module = module_from_spec(spec)
        loader.exec_module(module)
    return module
