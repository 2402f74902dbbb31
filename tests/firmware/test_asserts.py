"""The checks of the C library stop a program that calls it wrongly."""

import signal
import subprocess
from pathlib import Path

import pytest

SHARED = Path(__file__).parents[2] / "src/firstcontact/c"
PROGRAM = """\
#include "fc_chain.h"
static const fc_image image;
static const fc_stream stream = {.channels = %d};
static fc_chain chain;
int main(void)
{
    const double volts[FC_CHANNELS_MOST] = {0};
    chain.image = &image;
    %s;
    return 0;
}
"""


@pytest.mark.parametrize(
    ("channels", "call"),
    [
        (0, "(void)fc_chain_bytes(&image, &stream)"),
        (1, "fc_chain_take(&chain, volts, NULL)"),  # before fc_chain_restart
        (1, "fc_chain_restart(&chain, -1, false), fc_chain_take(&chain, volts, NULL)"),
        (1, "fc_chain_hint(&chain, NULL), fc_chain_take(&chain, volts, NULL)"),
    ],
)
def test_a_wrong_call_ends_at_its_check(tmp_path: Path, channels: int, call: str) -> None:
    source, program = tmp_path / "main.c", tmp_path / "program"
    source.write_text(PROGRAM % (channels, call), encoding="utf-8")
    sources = [source, *(SHARED / "chain").glob("*.c"), SHARED / "wire/fc_crc32.c"]
    folders = ["-I", SHARED / "chain", "-I", SHARED / "wire"]
    subprocess.run(["cc", "-O1", *folders, *sources, "-lm", "-o", program], check=True)
    ended = subprocess.run([program], capture_output=True, text=True)
    assert ended.returncode == -signal.SIGABRT
    assert "fc_chain.c" in ended.stderr
