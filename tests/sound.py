"""Sound input without hardware: PortAudio reads an ALSA device that plays a tape."""

import atexit
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.device.audio_source import portaudio

_SYSTEM = Path("/usr/share/alsa/alsa.conf")


@cache
def _plugin() -> Path:
    """Return the ALSA device, built once per process. Skip the test if it cannot be built."""
    if not _SYSTEM.exists() or shutil.which("cc") is None:
        pytest.skip("no ALSA or no C compiler: apt install libasound2-data gcc")
    folder = mkdtemp(prefix="firstcontact-tape-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    built = Path(folder) / "libtape.so"
    source = Path(__file__).with_name("sound_tape.c")
    flags = ["-O1", "-Wall", "-Wextra", "-Werror", "-DPIC", "-fPIC", "-shared"]
    process = subprocess.run(
        ["cc", *flags, "-o", built, source, "-lasound"], capture_output=True, text=True
    )
    if "asoundlib.h" in process.stderr:
        pytest.skip("no headers of ALSA: apt install libasound2-dev")
    assert process.returncode == 0, process.stderr
    return built


def playing(folder: Path, samples: NDArray[np.int16], **settings: int) -> dict[str, str]:
    """Return environment variables. With them a program gets these samples from an input "disc".

    Parameters
    ----------
    folder
        Folder for the tape and its settings.
    samples
        Samples of the tape, shape (samples,) or (samples, channels).
    settings
        Settings of the device; see ``sound_tape.c``.
    """
    try:
        portaudio()
    except InputError as error:
        pytest.skip(str(error))
    plugin = _plugin()
    (folder / "tape.raw").write_bytes(samples.astype("<i2").tobytes())
    channels = 1 if samples.ndim == 1 else samples.shape[1]
    lines = "".join(f"    {k} {v}\n" for k, v in {"channels": channels, **settings}.items())
    (folder / "asound.conf").write_text(
        f'pcm_type.tape {{ lib "{plugin}" }}\n'
        f'pcm.disc {{\n    type tape\n    file "{folder / "tape.raw"}"\n{lines}'
        '    hint { show on description "a disc" }\n}\n'
    )
    return {"ALSA_CONFIG_PATH": f"{_SYSTEM}:{folder / 'asound.conf'}"}


@contextmanager
def local_sound(folder: Path, samples: NDArray[np.int16], **settings: int) -> Iterator[Any]:
    """Play the samples in this process, and let PortAudio search for inputs again."""
    variables = playing(folder, samples, **settings)
    previous = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    sound = portaudio()

    def search() -> None:
        # sounddevice has no other way to find devices again.
        sound._terminate()
        sound._initialize()

    try:
        search()
        yield sound
    finally:
        for name, value in previous.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        search()


def ramp(samples: int) -> NDArray[np.int16]:
    """Return a ramp: each sample is its index, modulo 65536.

    A low-pass filter only delays a ramp, so the index can be read after it, too.
    """
    return (np.arange(samples) & 0xFFFF).astype(np.uint16).view(np.int16)
