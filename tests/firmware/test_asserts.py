"""The checks of the C library stop a program that calls it wrongly."""

import re
import signal
import subprocess
from pathlib import Path

import pytest
from firmware_build import need_arm

SHARED = Path(__file__).parents[2] / "src/firstcontact/c"
#: Wrong calls, and the file that stops each.
CALLS = {
    "(void)fc_chain_bytes(&image, &stream)": "fc_chain",
    "stream.channels = 1, fc_chain_init(&chain, &image, &stream, &program, NULL)": "fc_chain",
    "stream.channels = 1, fc_chain_init(&chain, &image, &stream, &program, odd)": "fc_chain",
    "fc_chain_take(&chain, volts, NULL)": "fc_chain",  # before fc_chain_restart
    "fc_chain_restart(&chain, -1, false)": "fc_chain",
    "chain.has_begun = chain.stream.has_floors = true, chain.stream.taxels = 1, "
    "fc_chain_take(&chain, volts, NULL)": "fc_chain",
    "fc_chain_hint(&chain, NULL)": "fc_chain",
    "fc_chain_hint(&chain, &hints)": "fc_chain",
    "(void)fc_image_read(odd, 8, &image)": "fc_image",
    "(void)fc_touch_traits(&chain.touch, 1, volts)": "fc_touch",
}
PROGRAM = """\
#include <stdlib.h>
#include "fc_chain.h"
static fc_image image;
static fc_stream stream;
static fc_program program;
static fc_chain chain;
static double volts[FC_TRAITS];
int main(int argc, char **argv)
{
    const fc_hints hints = {0.0, 0.0, -0.02};
    uint8_t *const odd = (uint8_t *)volts + 4;
    chain.image = &image;
    switch (atoi(argv[argc - 1])) {
%s
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("asserts")
    source, program = folder / "main.c", folder / "program"
    cases = "\n".join(f"    case {k}: {call}; break;" for k, call in enumerate(CALLS))
    source.write_text(PROGRAM % cases, encoding="utf-8")
    sources = [source, *(SHARED / "chain").glob("*.c"), SHARED / "wire/fc_crc32.c"]
    folders = ["-I", SHARED / "chain", "-I", SHARED / "wire"]
    subprocess.run(["cc", "-O0", *folders, *sources, "-lm", "-o", program], check=True)
    return program


@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_call_ends_at_its_check(program: Path, call: str) -> None:
    ended = subprocess.run([program, str([*CALLS].index(call))], capture_output=True, text=True)
    assert ended.returncode == -signal.SIGABRT
    assert f"{CALLS[call]}.c" in ended.stderr


@pytest.mark.parametrize("name", ["fc_chain.c", "fc_touch.c", "fc_image.c"])
def test_each_check_traps_at_its_own_line_on_the_hand(
    request: pytest.FixtureRequest, tmp_path: Path, name: str
) -> None:
    need_arm(request, "arm-none-eabi-gcc")
    source, made = SHARED / "chain" / name, tmp_path / "made.o"
    folders = ["-I", SHARED / "chain", "-I", SHARED / "wire"]
    options = ["-O2", "-g", "-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard"]
    subprocess.run(["arm-none-eabi-gcc", *options, *folders, "-c", source, "-o", made], check=True)
    command = ["arm-none-eabi-objdump", "-d", "-l", made]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    traps = re.findall(r":(\d+)[^\n]*\n[^\n]*\tudf\t#(\d+)", listing)
    lines = source.read_text(encoding="utf-8").splitlines()
    checks = {n for n, line in enumerate(lines, 1) if "FC_ASSERT(" in line}
    assert {int(line) for line, _ in traps} == checks
    assert all(int(line) % 256 == int(number) for line, number in traps)
