"""Build exported C for this machine and for the emulated Cortex-M7, and run it there."""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import struct
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent
BOARD = HERE.parent / "mps2-an500"
WARN = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
#: Without contraction of multiplications and additions all machines compute the same bits.
PLAIN = ("-O2", "-ffp-contract=off")
M7 = ("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard")
ARM = "arm-none-eabi-"
#: Variable that names a folder for object files, which several processes may share.
OBJECTS = "FIRSTCONTACT_OBJECTS"
#: Options that stop the program at the first undefined behaviour. PIE is off, as in the firmware's
#: Makefile, and so is optimisation.
STRICT = (
    "-O0", "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all",
    "-no-pie", "-fno-pie",
)  # fmt: skip
#: Record of windows.c for each contact.
ANSWER = np.dtype(
    [("value", "f8"), ("low", "f8"), ("high", "f8"), ("status", "i4"), ("instructions", "u4")]
)
#: C code that computer, firmware and exported library share.
SHARED = Path(str(files("firstcontact") / "c"))
#: Files of the chain, and their folders as options of the compiler.
CHAIN = [*sorted((SHARED / "chain").glob("*.c")), SHARED / "wire/fc_crc32.c"]
INCLUDE = [f"-I{SHARED / folder}" for folder in ("chain", "wire")]

#: Record of streams.c for each event, and for each stream.
EVENT = np.dtype(
    [("kind", "i4"), ("reason", "i4"), ("flags", "i4"), ("channel", "i4"), ("sample", "i8"),
     ("known", "i8"), ("samples", "i4"), ("value", "f4"), ("low", "f4"), ("high", "f4"),
     ("half_width", "f4"), ("spread", "f4"), ("instructions", "u4"), ("waited", "u4")]
)  # fmt: skip
_STREAM = struct.Struct("<iiiiddd ddd")
_PIECE = struct.Struct("<qii")


@dataclass(frozen=True)
class Stream:
    """Stream of samples for the chain.

    Parameters
    ----------
    pieces
        First sample, epoch and samples of each piece. Samples are in volts and have shape
        (n, 2 + taxels), float32.
    floors
        Noise of both fingers at rest, V; None if it is unknown.
    alpha
        Coefficient of the exponential smoothing; 1 for none.
    hints
        Speed (m/s), its relative error and the radius (m), known with each first contact.
    """

    pieces: Sequence[tuple[int, int, NDArray[np.float32]]]
    floors: tuple[float, float] | None
    alpha: float = 1.0
    hints: tuple[float, float, float] = (0.0, 0.0, float("nan"))


@dataclass(frozen=True)
class Program:
    """Exported library with one of the measuring programs.

    Parameters
    ----------
    main
        Name of the program's C file in this folder.
    sources
        Folder of the library's sources.
    defines
        Preprocessor definitions.
    more
        Further C files and options.
    """

    main: str
    sources: Path
    defines: Mapping[str, str]
    more: Sequence[str] = ()

    def _objects(self, compiler: Sequence[str], *machine: Path) -> list[str]:
        definitions = [f"-D{name}={value}" for name, value in self.defines.items()]
        options = [word for word in self.more if word.startswith("-")]
        command = [*compiler, *definitions, f"-I{HERE}", f"-I{self.sources}", *options]
        more = [Path(word) for word in self.more if word not in options]
        sources = [HERE / self.main, *sorted(self.sources.glob("*.c")), *machine, *more]
        return [compiled(command, source) for source in sources]

    def native(self, to: Path, strict: bool = False) -> Path:
        """Build for this machine. ``strict`` stops the program at undefined behaviour."""
        compiler = ["gcc", *WARN, *PLAIN, *(STRICT if strict else ())]
        objects = self._objects(compiler, HERE / "machine_native.c")
        run([*compiler, *objects, "-lm", "-o", str(to)])
        return to

    def m7(self, to: Path) -> Path:
        """Build for the emulated Cortex-M7."""
        compiler = [f"{ARM}gcc", *WARN, *PLAIN, *M7, "--specs=nano.specs", f"-I{BOARD}",
                    "-ffunction-sections", "-fdata-sections"]  # fmt: skip
        board = [BOARD / "start.c", BOARD / "semihosting.c", HERE / "machine_m7.c"]
        run([*compiler, *self._objects(compiler, *board), "-nostartfiles", "-T",
             str(BOARD / "memory.ld"), "-Wl,--gc-sections", "-lm", "-o", str(to)])  # fmt: skip
        return to


def chain_program(main: str, folder: Path) -> Program:
    """Return a measuring program with the chain's own C files."""
    return Program(main, folder, {}, [*map(str, CHAIN), *INCLUDE])


@cache
def _object_folder() -> Path:
    if OBJECTS in os.environ:
        return Path(os.environ[OBJECTS])
    folder = Path(tempfile.mkdtemp(prefix="objects"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def compiled(command: Sequence[str], source: Path) -> str:
    """Return the object file of a C file. Equal code with equal options is compiled once.

    Parameters
    ----------
    command
        Compiler with its options.
    source
        The C file.
    """
    text = run([*command, "-E", "-P", str(source)])
    options = [word for word in command if not word.startswith(("-I", "-D"))]
    name = hashlib.sha256(repr((options, text)).encode()).hexdigest()
    path = _object_folder() / f"{name}.o"
    if not path.exists():
        making = path.with_suffix(f".{os.getpid()}")
        run([*command, "-c", str(source), "-o", str(making)])
        making.rename(path)
    return str(path)


def run(command: Sequence[str]) -> str:
    """Run a compiler or a program and return its output.

    Raises
    ------
    RuntimeError
        It failed. The message contains its output.
    """
    process = subprocess.run(command, capture_output=True, text=True)
    if process.returncode:
        raise RuntimeError(f"{command[0]} failed: {process.stdout}\n{process.stderr}")
    return process.stdout


def ask_native(program: Path, data: bytes, folder: Path) -> bytes:
    """Return the output of a program on this machine for these input bytes."""
    source, result = folder / "asked", folder / "answered"
    source.write_bytes(data)
    run([str(program), str(source), str(result)])
    return result.read_bytes()


def ask_m7(image: Path, data: bytes, folder: Path) -> bytes:
    """Return the output of the emulated Cortex-M7 for these input bytes.

    The emulator counts instructions.
    """
    source, result = folder / "asked", folder / "answered"
    source.write_bytes(data)
    semihosting = f"enable=on,target=native,arg={source},arg={result}"
    run(["qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial",
         "none", "-icount", "shift=10", "-semihosting-config", semihosting, "-kernel",
         str(image)])  # fmt: skip
    return result.read_bytes()


def memory(image: Path) -> tuple[int, int]:
    """Return the bytes of flash and of static memory of an image."""
    line = run([f"{ARM}size", str(image)]).splitlines()[1].split()
    text, data, bss = (int(part) for part in line[:3])
    return text + data, data + bss


def has_emulator() -> bool:
    """Return True if a compiler and an emulator for the Cortex-M7 are installed."""
    return all(shutil.which(name) for name in (f"{ARM}gcc", "qemu-system-arm"))


def answers(raw: bytes) -> NDArray[np.void]:
    """Return the records of windows.c."""
    return np.frombuffer(raw, ANSWER)


def same(native: NDArray[np.void], m7: NDArray[np.void]) -> bool:
    """Return True if two machines gave the same bytes, except for instructions."""
    plain = [np.array(records) for records in (native, m7)]
    for records in plain:
        for name in {"instructions", "waited"} & set(records.dtype.names or ()):
            records[name] = 0
    return plain[0].tobytes() == plain[1].tobytes()


def signals(image: bytes, each: Sequence[NDArray[np.float64]], after: int) -> bytes:
    """Return an image and signals as input for windows.c, with ``after`` samples of the contact."""
    parts = [np.uint32(len(image)).tobytes(), image]
    for signal in each:
        parts += [struct.pack("<ii", len(signal), len(signal) - after), signal.tobytes()]
    return b"".join(parts)


def streams(image: bytes, each: Sequence[Stream]) -> bytes:
    """Return an image and streams as input for streams.c."""
    parts = [np.uint32(len(image)).tobytes(), image]
    for s in each:
        taxels = s.pieces[0][2].shape[1] - 2
        floors = s.floors or (0.0, 0.0)
        has_floors = s.floors is not None
        parts.append(_STREAM.pack(len(s.pieces), 2, taxels, has_floors, *floors, s.alpha, *s.hints))
        last = None
        for first, epoch, data in s.pieces:
            parts += [_PIECE.pack(first, len(data), epoch != last), data.tobytes()]
            last = epoch
    return b"".join(parts)


def events(raw: bytes) -> list[NDArray[np.void]]:
    """Return the records of streams.c for each stream. The last record holds instructions.

    There, ``samples`` is the number of samples, ``sample`` the instructions of all, and ``known``
    those of the costliest.
    """
    records = np.frombuffer(raw, EVENT)
    return np.split(records, np.flatnonzero(records["kind"] == 0)[:-1] + 1)
