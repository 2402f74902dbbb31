"""Damaged files for ``import``: sound, arrays, tables, MATLAB, XDF, and tables of contacts."""

import io
import shutil
import struct
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import fuzz_mutate as mutate
import h5py
import numpy as np
from fuzz_seeds import CONTACT, Seeds, signal
from numpy.typing import NDArray

RATE = 4000.0
#: Samples of a long file, and its contacts, s.
SAMPLES, TOUCHES = 4000, (0.4, 0.8)
CHANNELS = [
    ["variable", "sensor", "finger", "rate_hz", "unit", "scale", "offset"],
    ["pac", "hydrophone", "index", "2200", "", "0.5", "2000"],
    ["pressure", "", "index", "100", "", "1", "0"],
]
STREAMS = [
    ["variable", "sensor", "finger", "rate_hz", "column", "unit", "scale", "offset"],
    ["disc", "piezo", "index", "4000", "0", "V", "1", "0"],
]


def wav(rng: Random, seeds: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of a folder of WAV files with its table."""
    path = folder / "wav"
    shutil.copytree(seeds.wav, path)
    sound, table = path / f"{rng.randrange(3)}.wav", path / "labels.csv"
    kind = rng.randrange(4)
    if kind == 0:
        sound.write_bytes(mutate.raw(rng, sound.read_bytes()))
    elif kind == 1:
        sound.write_bytes(_riff(rng, sound.read_bytes()))
    elif kind == 2:
        rows = [line.split(",") for line in table.read_text().splitlines()]
        table.write_bytes(mutate.table(rng, rows))
    else:
        _move(rng, rng.choice((sound, table)))
    return [str(path)]


def events(rng: Random, seeds: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of WAV files with a table of their contacts."""
    path = folder / "wav"
    shutil.copytree(seeds.wav, path)
    (path / "labels.csv").unlink()
    sound, table = path / f"{rng.randrange(3)}.wav", path / "events.csv"
    unit, at = rng.choice((("onset_s", ("0.05", "0.0668")), ("onset_sample", ("250", "330"))))
    rows = [["file", unit, "channel", "shore_a", "first_finger"]]
    rows += [[f"{i}.wav", onset, "0", "20", "index"] for i in range(3) for onset in at]
    table.write_bytes(mutate.table(rng, rows))
    if rng.random() < 0.3:
        sound.write_bytes(_riff(rng, sound.read_bytes()))
    elif rng.random() < 0.2:
        _move(rng, rng.choice((sound, table)))
    return [str(sound if rng.random() < 0.3 else path), "--events", str(table)]


def _move(rng: Random, file: Path) -> None:
    """Remove a file, or put a folder or a file with a hostile name there."""
    kind = rng.randrange(3)
    if kind == 2:
        file.rename(file.with_name("\x1b[31mred.wav"))
        return
    file.unlink()
    if kind == 1:
        file.mkdir()


def _riff(rng: Random, old: bytes) -> bytes:
    """Return a WAV file with contradictory header fields around the samples of another file."""
    tag = rng.choice((1, 1, 1, 3, 0xFFFE, 6, 85, 0))
    channels = rng.choice((1, 1, 2, 0, 3, 255, 65535))
    bits = rng.choice((8, 16, 16, 24, 32, 64, 0, 1, 12, 7, 65535))
    rate = rng.choice((4936, 4936, 0, 1, 2**32 - 1, 1999, 44100))
    align = rng.choice((channels * bits // 8, 0, 1, 2, 65535)) % 65536
    body = struct.pack("<HHIIHH", tag, channels, rate, rate * align % 2**32, align, bits)
    out = b""
    for name, content in ((b"fmt ", body), (b"junk", rng.randbytes(9)), (b"data", old[44:])):
        size = len(content)
        if rng.random() < 0.1:
            size = rng.choice((0, size - 1, size + 1, 2**31, 2**32 - 1)) % 2**32
        out += name + struct.pack("<I", size) + content
    head = rng.choice((b"RIFF", b"RIFF", b"RIFX", b"RF64"))
    return head + struct.pack("<I", len(out) + 4) + b"WAVE" + out


def _arrays(rng: Random, seeds: Seeds) -> dict[str, NDArray[Any]]:
    """Return named arrays, a few of them damaged."""
    out = dict(seeds.arrays)
    for name in ("force", "strip", "smoothing_alpha", "second_contact", "first_finger", "source"):
        if rng.random() < 0.6:
            del out[name]
    for _ in range(rng.choice((0, 1, 1, 1, 2))):
        name = rng.choice(sorted(out))
        kind = rng.randrange(7)
        if kind <= 4:
            out[name] = mutate.array(rng, out[name])
        elif kind == 5:
            del out[name]
        else:
            out[rng.choice(("hardness_rank", "extra", "\x1b[2Jx", *sorted(out)))] = out[name]
    return out


def npz(rng: Random, seeds: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of a damaged NumPy archive."""
    path, out = folder / "arrays.npz", io.BytesIO()
    save = rng.choice((np.savez, np.savez, np.savez_compressed))
    arrays: dict[str, Any] = _arrays(rng, seeds)
    if rng.random() < 0.05:
        save = np.savez_compressed
        arrays["shore_a"] = np.zeros(1 << 26, np.int8)  # many times the size of the file
    if rng.random() < 0.05:
        arrays["object"] = np.array([{}] * 4, dtype=object)
    save(out, **arrays)
    path.write_bytes(mutate.raw(rng, out.getvalue()) if rng.random() < 0.5 else out.getvalue())
    return [str(path)]


def hdf5(rng: Random, seeds: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of an HDF5 file with unusual features of the format."""
    path = folder / "arrays.h5"
    settings = ("sample_rate_hz", "piezo_unit", "smoothing_alpha", "source")
    with h5py.File(path, "w", libver=rng.choice(("earliest", "latest"))) as file:
        for name, array in _arrays(rng, seeds).items():
            stored = array.astype(h5py.string_dtype()) if array.dtype.kind == "U" else array
            try:
                if name in settings:
                    file.attrs[name] = stored
                else:
                    file.create_dataset(name.replace("/", "_"), data=stored)
            except (TypeError, ValueError, KeyError, OSError, RuntimeError):
                continue
        if rng.random() < 0.5:
            _add_strange(rng, file, path)
    if rng.random() < 0.4:
        path.write_bytes(mutate.raw(rng, path.read_bytes()))
    return [str(path)]


def _add_strange(rng: Random, file: h5py.File, path: Path) -> None:
    name = rng.choice((*sorted(file), "extra", "object", "session"))
    if name in file:
        del file[name]
    rng.choice(
        (
            lambda: file.update({name: h5py.SoftLink("/nothing")}),
            lambda: file.update({name: h5py.SoftLink(f"/{name}")}),
            lambda: file.update({name: h5py.ExternalLink("/etc/passwd", "/")}),
            lambda: file.update({name: h5py.ExternalLink(str(path), "/")}),
            lambda: file.create_dataset(name, (4,), "S8", external=[("/etc/passwd", 0, 32)]),
            lambda: file.create_dataset(name, (10**6, 10**6), "f4", chunks=(1000, 1000)),
            lambda: file.create_dataset(name, (2**40,), "i1", chunks=(2**20,), compression="gzip"),
            lambda: file.create_dataset(name, data=h5py.Empty("f4")),
            lambda: file.create_dataset(name, (4,), h5py.vlen_dtype(np.int32)),
            lambda: file.create_dataset(name, (4,), np.dtype([("a", "f4"), ("b", "S3")])),
            lambda: file.create_dataset(name, (4,), h5py.ref_dtype),
            lambda: file.create_group(name).update({"up": h5py.SoftLink("/")}),
            lambda: file.attrs.update({"sample_rate_hz": h5py.Empty("f8")}),
        )
    )()


def table(rng: Random, seeds: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of a damaged long CSV."""
    path = folder / "table.csv"
    path.write_bytes(mutate.table(rng, seeds.csv))
    rate = rng.choice((4936, 0, -1, 1e9, "nan", 2000))
    return [str(path), *(["--rate", str(rate)] if rng.random() < 0.3 else [])]


@cache
def _heard() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    rng = np.random.default_rng(7)
    out = 0.01 * rng.standard_normal(SAMPLES)
    for at in TOUCHES:
        begin = round(at * RATE)
        out[begin : begin + 290] += signal(45.0, rng)[CONTACT:][:290]
    return out


@cache
def _mat() -> bytes:
    from scipy.io import savemat

    n, out = 50, io.BytesIO()
    rng = np.random.default_rng(8)
    pac = rng.integers(1900, 2100, (22, n)).astype(np.uint16)
    savemat(out, {"pac": pac, "pressure": rng.integers(0, 4000, (1, n)).astype(np.uint16)})
    return out.getvalue()


def mat(rng: Random, seeds: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of MATLAB variables, or sometimes of arrays of pinches."""
    path, channels = folder / "a.mat", folder / "channels.csv"
    if rng.random() < 0.3:
        from scipy.io import savemat

        savemat(path, {k: v for k, v in seeds.arrays.items() if rng.random() < 0.95})
        path.write_bytes(mutate.raw(rng, path.read_bytes()))
        return [str(path)]
    path.write_bytes(mutate.raw(rng, _mat()) if rng.random() < 0.6 else _mat())
    channels.write_bytes(mutate.table(rng, CHANNELS))
    return [str(path), "--channels", str(channels)]


def _chunk(tag: int, content: bytes) -> bytes:
    return b"\x04" + struct.pack("<IH", len(content) + 2, tag) + content


def _stream(rng: Random, number: int, name: str, rate: float, kind: str, texts: bool) -> bytes:
    """Return an XDF stream with header, samples, clock offset and footer, often inconsistent."""
    stated = str(rate) if rng.random() < 0.85 else str(rng.choice((0, -1, "nan", 1e12, "x", "")))
    width = "1" if rng.random() < 0.9 else str(rng.choice((0, -1, 2, 10**9, "x")))
    xml = (
        f"<?xml version='1.0'?><info><name>{name}</name><type>x</type><channel_count>{width}"
        f"</channel_count><nominal_srate>{stated}</nominal_srate><channel_format>{kind}"
        "</channel_format><created_at>1</created_at><desc/></info>"
    )
    of = struct.pack("<I", number)
    parts = [_chunk(2, of + xml.encode())]
    values = _heard().astype("<f4")
    times = TOUCHES if texts else tuple(np.arange(SAMPLES) / RATE)
    for start in range(0, len(times), 500):
        chunk = times[start : start + 500]
        body = of + b"\x04" + struct.pack("<I", len(chunk))
        for i, at in enumerate(chunk, start):
            odd = rng.choice((float("nan"), -1e9, 1e300)) if rng.random() < 2e-5 else at
            body += b"\x08" + struct.pack("<d", 50.0 + odd)
            text = b"eraser; shore_a=40"
            body += b"\x04" + struct.pack("<I", len(text)) + text if texts else values[i].tobytes()
        parts.append(_chunk(3, body))
    parts.append(_chunk(4, of + struct.pack("<dd", 50.0, 0.0)))
    parts.append(_chunk(6, of + b"<?xml version='1.0'?><info></info>"))
    if rng.random() < 0.2:
        del parts[rng.randrange(len(parts))]
    return b"".join(parts)


def xdf(rng: Random, _: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of a vibration stream and a stream of markers."""
    path, channels = folder / "a.xdf", folder / "channels.csv"
    kind = rng.choice(("float32", "float32", "float32", "double64", "int8", "string", "x"))
    body = b"XDF:" + _chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>")
    body += _stream(rng, 1, "disc", RATE, kind, texts=False)
    body += _stream(rng, rng.choice((2, 2, 2, 1)), "marks", 0.0, "string", texts=True)
    path.write_bytes(mutate.raw(rng, body) if rng.random() < 0.4 else body)
    if rng.random() < 0.7:
        return [str(path)]
    channels.write_bytes(mutate.table(rng, STREAMS))
    return [str(path), "--channels", str(channels)]


@cache
def _flac() -> bytes:
    import soundfile

    out = io.BytesIO()
    soundfile.write(out, 0.3 * _heard() / np.abs(_heard()).max(), round(RATE), format="FLAC")
    return out.getvalue()


def sound(rng: Random, _: Seeds, folder: Path) -> list[str]:
    """Return the arguments of an import of FLAC with a label track, or a table of contacts."""
    path, track, contacts = folder / "a.flac", folder / "labels.txt", folder / "events.csv"
    path.write_bytes(mutate.raw(rng, _flac()) if rng.random() < 0.4 else _flac())
    if rng.random() < 0.5:
        rows = [["onset_s", "shore_a", "object"], *([str(at), "40", "x"] for at in TOUCHES)]
        contacts.write_bytes(mutate.table(rng, rows))
        return [str(path), "--events", str(contacts)]
    lines = [f"{at:.6f}\t{at + 0.01:.6f}\teraser; shore_a=40\n" for at in TOUCHES]
    text = "\\\t100.0\t2000.0\n".join(lines).replace("\t", rng.choice(("\t", "\t", " ")))
    if rng.random() < 0.5:
        text = text.replace("40", str(rng.choice(mutate.NUMBERS)))
    track.write_bytes(mutate.raw(rng, text.encode()) if rng.random() < 0.7 else text.encode())
    return [str(path), "--events", str(track)]


MAKERS = (wav, events, npz, npz, hdf5, hdf5, table, mat, xdf, sound)
