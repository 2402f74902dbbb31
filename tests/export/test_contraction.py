"""Products and sums of the C code are never fused, whatever the compiler's settings are.

The Arduino IDE and PlatformIO build libraries with GCC's defaults, which would fuse them.
"""

import platform
import shutil
from pathlib import Path

import building
import pytest

#: What both build C with, but for what tells one processor from another.
ARDUINO = ("-std=gnu11", "-O2", "-ffunction-sections", "-fdata-sections")


def code(folder: Path, *options: str) -> str:
    """Return the Cortex-M7 instructions of all files."""
    folder.mkdir()
    text = []
    for source in building.CHAIN:
        to = folder / f"{source.stem}.o"
        building.run(
            [f"{building.ARM}gcc", *ARDUINO, *building.M7, *options, *building.INCLUDE, "-c",
             str(source), "-o", str(to)]
        )  # fmt: skip
        listing = building.run([f"{building.ARM}objdump", "-d", str(to)])
        text.append(listing.split("\n", 3)[-1])  # without the file's name
    return "\n".join(text)


@pytest.mark.slow
def test_compiled_without_the_flag_nothing_is_fused(
    request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    """Only explicit fmaf calls may remain."""
    if not shutil.which(f"{building.ARM}gcc"):
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi is not installed")
    plain = code(tmp_path / "plain")
    assert plain == code(tmp_path / "flag", "-ffp-contract=off")


@pytest.mark.parametrize(
    "option", ["-ffast-math", "-fsingle-precision-constant", "-mfpmath=387", "-mfpmath=both"]
)
def test_options_that_change_bits_do_not_compile(option: str) -> None:
    if "fpmath" in option and platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("only x86 has two units for floating point")
    command = ["cc", *building.INCLUDE, "-fsyntax-only", str(building.SHARED / "chain/fc_svm.c")]
    building.run(command)
    with pytest.raises(RuntimeError, match=r"fc_math\.h"):
        building.run([*command, option])
