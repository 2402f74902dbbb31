"""Builds exported C for this machine and for the emulated Cortex-M7, and runs it there."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent
BOARD = HERE.parent / "mps2-an500"
WARN = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
#: Contraction is off, so that every machine gives the same bits.
PLAIN = ("-O2", "-ffp-contract=off")
M7 = ("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard")
ARM = "arm-none-eabi-"
#: Stops at the first thing that C leaves undefined; without PIE as in the firmware's Makefile.
STRICT = (
    "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all",
    "-no-pie", "-fno-pie",
)  # fmt: skip
#: What a window is answered with: see windows.c.
ANSWER = np.dtype(
    [("value", "f8"), ("low", "f8"), ("high", "f8"), ("chosen", "i4"), ("status", "i4"),
     ("instructions", "u4"), ("spare", "u4")]
)  # fmt: skip

#: What a closing is answered with: see closings.c.
FOUND = np.dtype(
    [("found", "i4"), ("contact", [("channel", "i4"), ("sample", "u4"), ("known", "u4")], 2),
     ("dearest", "u4"), ("whole", "u4"), ("steady", "u4"), ("around", "u4")]
)  # fmt: skip
#: What a touch is answered with at a moment: see touches.c.
RUNNING = np.dtype(
    [("value", "f8"), ("spread", "f8"), ("low", "f8"), ("high", "f8"), ("samples", "i4"),
     ("status", "i4"), ("strange", "i4"), ("instructions", "u4")]
)  # fmt: skip


@dataclass(frozen=True)
class Program:
    """An exported library with one of the measuring programs around it.

    Parameters
    ----------
    main
        Of the files here.
    sources
        Folder of the library's sources.
    defines
        What the preprocessor is told.
    more
        Further C files and options.
    """

    main: str
    sources: Path
    defines: Mapping[str, str]
    more: Sequence[str] = ()

    def _common(self) -> list[str]:
        told = [f"-D{name}={value}" for name, value in self.defines.items()]
        ours = [str(path) for path in sorted(self.sources.glob("*.c"))]
        return [*told, f"-I{HERE}", f"-I{self.sources}", str(HERE / self.main), *ours, *self.more]

    def native(self, to: Path, strict: bool = False) -> Path:
        """Build for this machine; ``strict`` stops at the first thing that C leaves undefined."""
        options = STRICT if strict else ()
        run(["gcc", *WARN, *PLAIN, *options, *self._common(), str(HERE / "machine_native.c"),
             "-lm", "-o", str(to)])  # fmt: skip
        return to

    def m7(self, to: Path) -> Path:
        """Build for the emulated Cortex-M7."""
        board = [str(BOARD / name) for name in ("start.c", "semihosting.c")]
        board.append(str(HERE / "machine_m7.c"))
        run([f"{ARM}gcc", *WARN, *PLAIN, *M7, "-ffunction-sections", "-fdata-sections",
             f"-I{BOARD}", *self._common(), *board, "-nostartfiles", "--specs=nano.specs", "-T",
             str(BOARD / "memory.ld"), "-Wl,--gc-sections", "-lm", "-o", str(to)])  # fmt: skip
        return to


def run(command: Sequence[str]) -> str:
    """Run a compiler or a program; what it says when it fails."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{command[0]} failed: {done.stdout}\n{done.stderr}")
    return done.stdout


def ask_native(program: Path, data: bytes, folder: Path) -> bytes:
    """What a program of this machine answers."""
    before, after = folder / "asked", folder / "answered"
    before.write_bytes(data)
    run([str(program), str(before), str(after)])
    return after.read_bytes()


def ask_m7(image: Path, data: bytes, folder: Path) -> bytes:
    """What the emulated Cortex-M7 answers, instructions counted."""
    before, after = folder / "asked", folder / "answered"
    before.write_bytes(data)
    semihosting = f"enable=on,target=native,arg={before},arg={after}"
    run(["qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial",
         "none", "-icount", "shift=10", "-semihosting-config", semihosting, "-kernel",
         str(image)])  # fmt: skip
    return after.read_bytes()


def memory(image: Path) -> tuple[int, int]:
    """Bytes of flash and of static memory in an image."""
    line = run([f"{ARM}size", str(image)]).splitlines()[1].split()
    text, data, bss = (int(part) for part in line[:3])
    return text + data, data + bss


def emulator_there() -> bool:
    """Whether the Cortex-M7 can be built for and emulated here."""
    return all(shutil.which(name) for name in (f"{ARM}gcc", "qemu-system-arm"))


def answers(raw: bytes) -> NDArray[np.void]:
    """The records of windows.c."""
    return np.frombuffer(raw, ANSWER)


def same(native: NDArray[np.void], m7: NDArray[np.void]) -> bool:
    """Whether two machines gave the same bytes; what only one of them counts left out."""
    plain = [np.array(records) for records in (native, m7)]
    for records in plain:
        records["instructions"] = 0
    return plain[0].tobytes() == plain[1].tobytes()


def closings(volts: Sequence[NDArray[np.float64]]) -> bytes:
    """Closings (samples, channels) as closings.c reads them."""
    return b"".join(np.uint32(len(v)).tobytes() + v.tobytes() for v in volts)


def contacts(raw: bytes) -> list[list[tuple[int, int, int]]]:
    """Of each closing: channel, sample of the contact, sample after which it was known."""
    records = np.frombuffer(raw, FOUND)
    return [[tuple(map(int, c)) for c in r["contact"][: r["found"]]] for r in records]


def touches(
    signals: NDArray[np.float32],
    valid: NDArray[np.intp],
    fingers: NDArray[np.intp],
    moments: Sequence[int],
) -> bytes:
    """Contacts as touches.c reads them."""
    head = np.array([len(moments), *moments], np.int32).tobytes()
    each = zip(signals, valid, fingers, strict=True)
    return head + b"".join(np.array([f, n], np.int32).tobytes() + s.tobytes() for s, n, f in each)
