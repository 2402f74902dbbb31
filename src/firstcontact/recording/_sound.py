"""Reader of sound files: WAV by SciPy, FLAC by libsndfile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, open_regular, require_modules
from firstcontact.recording._quoting import reason
from firstcontact.recording._sizes import check_unpacked
from firstcontact.recording._wav import read_wav

FLAC = ".flac"
SUFFIXES = (".wav", FLAC)
_DAMAGE = (OSError, RuntimeError, ValueError, TypeError, OverflowError, MemoryError)


def read_sound(file: Path) -> tuple[int, NDArray[Any]]:
    """Return the rate in Hz and the samples as stored in the file, shape (samples, channels)."""
    return _read_flac(file) if file.suffix.lower() == FLAC else read_wav(file)


def _read_flac(file: Path) -> tuple[int, NDArray[Any]]:
    require_modules("files", "soundfile")
    try:
        open_regular(file).close()
        rate, values, declared = _decode(file)
    except InputError:
        raise
    except _DAMAGE as error:
        raise InputError(
            f"{file} cannot be read as FLAC ({reason(error).rstrip('.')}): copy it again, or "
            "convert it to WAV"
        ) from error
    if not len(values):
        raise InputError(f"{file} holds no samples: leave it out")
    if len(values) != declared:
        raise InputError(
            f"{file} declares {declared} samples but holds {len(values)}: copy it again"
        )
    return rate, values


def _decode(file: Path) -> tuple[int, NDArray[Any], int]:
    """Return the rate, the samples and the declared number of samples of a FLAC file."""
    import soundfile

    with soundfile.SoundFile(file) as sound:
        wide = sound.subtype != "PCM_16"
        size = np.dtype(np.int32 if wide else np.int16).itemsize
        check_unpacked(file, sound.frames * sound.channels * size)
        values = sound.read(dtype="int32" if wide else "int16", always_2d=True)
        return int(sound.samplerate), values, int(sound.frames)
