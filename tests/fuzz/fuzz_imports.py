"""Damaged files for ``import``: WAV folders, NPZ, HDF5 and CSV."""

from __future__ import annotations

import io
import shutil
import struct
import zipfile
from pathlib import Path
from random import Random
from typing import Any

import fuzz_mutate as mutate
import h5py
import numpy as np
from fuzz_seeds import Seeds
from numpy.typing import NDArray


def wav(rng: Random, seeds: Seeds, path: Path) -> Path:
    """Import a folder of WAV files with its table."""
    shutil.copytree(seeds.wav, path)
    for _ in range(rng.choice((1, 1, 2))):
        sound = path / f"{rng.randrange(3)}.wav"
        table = path / "labels.csv"
        kind = rng.randrange(6)
        if not (sound if kind <= 2 else table).is_file():  # it was changed before
            continue
        if kind == 0:
            sound.write_bytes(mutate.raw(rng, sound.read_bytes()))
        elif kind <= 2:
            sound.write_bytes(_riff(rng, sound.read_bytes()))
        elif kind in (3, 4):
            rows = [line.split(",") for line in (seeds.wav / "labels.csv").read_text().splitlines()]
            table.write_bytes(mutate.table(rng, rows))
        else:
            _moved(rng, rng.choice((sound, table)), path)
    return path


def events(rng: Random, seeds: Seeds, path: Path) -> tuple[Path, Path]:
    """Import WAV files with a table of their contacts."""
    shutil.copytree(seeds.wav, path)
    (path / "labels.csv").unlink()
    sound, table = path / f"{rng.randrange(3)}.wav", path / "events.csv"
    unit = rng.choice(("onset_s", "onset_sample"))
    times = ("0.05", "0.0668") if unit == "onset_s" else ("250", "330")
    rows = [["file", unit, "channel", "shore_a", "first_finger"]]
    rows += [[f"{i}.wav", at, "0", "20", "index"] for i in range(3) for at in times]
    table.write_bytes(mutate.table(rng, rows))
    if rng.random() < 0.3:
        sound.write_bytes(_riff(rng, sound.read_bytes()))
    elif rng.random() < 0.2:
        _moved(rng, rng.choice((sound, table)), path)
    return (sound if rng.random() < 0.3 else path), table


def _moved(rng: Random, file: Path, folder: Path) -> None:
    if not file.is_file():
        return
    kind = rng.randrange(4)
    if kind == 0:
        file.unlink()
    elif kind == 1:
        (folder / "deeper").mkdir(exist_ok=True)
        shutil.copy(file, folder / "deeper")
    elif kind == 2:
        file.unlink()
        file.mkdir()
    else:
        file.rename(folder / "\x1b[31mred.wav")


def _riff(rng: Random, old: bytes) -> bytes:
    """Return a WAV file with contradictory header fields around the samples of another file."""
    data = old[44:]
    tag = rng.choice((1, 1, 1, 3, 0xFFFE, 6, 85, 0))
    channels = rng.choice((1, 1, 2, 0, 3, 255, 65535))
    bits = rng.choice((8, 16, 16, 24, 32, 64, 0, 1, 12, 7, 65535))
    rate = rng.choice((4936, 4936, 0, 1, 2**32 - 1, 1999, 44100))
    align = rng.choice((max(0, channels * bits // 8), 0, 1, 2, 65535)) % 65536
    body = struct.pack("<HHIIHH", tag, channels, rate, rate * align % 2**32, align, bits)
    if tag == 0xFFFE:
        body += struct.pack("<HHI", 22, bits, 0) + rng.randbytes(16)
    chunks = [(b"fmt ", body), (b"data", data)]
    if rng.random() < 0.3:
        chunks.insert(rng.randrange(3), (rng.choice((b"LIST", b"junk", b"fact")), rng.randbytes(9)))
    if rng.random() < 0.2:
        del chunks[rng.randrange(len(chunks))]
    if rng.random() < 0.1:
        rng.shuffle(chunks)
    out = b""
    for name, content in chunks:
        size = len(content)
        if rng.random() < 0.1:
            size = rng.choice((0, size - 1, size + 1, 2**31, 2**32 - 1)) % 2**32
        out += name + struct.pack("<I", size) + content
    head = rng.choice((b"RIFF", b"RIFF", b"RIFF", b"RIFX", b"RF64"))
    size = len(out) + 4 if rng.random() < 0.9 else 2**32 - 1
    return head + struct.pack("<I", size) + b"WAVE" + out


def arrays(rng: Random, seeds: Seeds) -> dict[str, NDArray[Any]]:
    """Return named arrays, a few of them damaged."""
    out = dict(seeds.arrays)
    for name in ("force", "strip", "smoothing_alpha", "second_contact", "first_finger", "source"):
        if rng.random() < 0.6:
            del out[name]
    for _ in range(rng.choice((0, 1, 1, 1, 2))):
        name = rng.choice(sorted(out))
        kind = rng.randrange(8)
        if kind <= 4:
            out[name] = mutate.array(rng, out[name])
        elif kind == 5:
            out[name] = _texts(rng, out[name])
        elif kind == 6:
            del out[name]
        else:
            out[rng.choice(("hardness_rank", "extra", "\x1b[2Jx", *sorted(out)))] = out[name]
    return out


def _texts(rng: Random, old: NDArray[Any]) -> NDArray[Any]:
    made = [rng.choice((mutate.text(rng)[:2000], str(rng.choice(mutate.NUMBERS))))] * max(
        1, old.size
    )
    clean = [t.encode(errors="replace").decode() for t in made]
    return np.array(clean).reshape(old.shape if old.size else (1,))


def npz(rng: Random, seeds: Seeds, path: Path) -> Path:
    """Import a damaged NumPy archive."""
    out = io.BytesIO()
    members = {}
    for name, array in arrays(rng, seeds).items():
        member = io.BytesIO()
        np.save(member, array)
        members[f"{name}.npy"] = member.getvalue()
    for _ in range(rng.choice((0, 0, 0, 1, 2))):
        name = rng.choice(sorted(members))
        members[name] = _npy(rng, members[name])
    how = rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))
    how = rng.choice((12, 14)) if rng.random() < 0.02 else how  # bzip2 and LZMA take their time
    with zipfile.ZipFile(out, "w", how) as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(_name(rng, name)), data, compress_type=how)
        if rng.random() < 0.02:  # a gigabyte in a megabyte
            bomb = zipfile.ZipInfo("bomb.npy")
            with archive.open(bomb, "w", force_zip64=True) as member:
                bomb.compress_type = zipfile.ZIP_DEFLATED
                for _ in range(64):
                    member.write(bytes(1 << 20))
    raw = out.getvalue()
    kind = rng.random()
    if kind < 0.25:
        raw = mutate.raw(rng, raw)
    elif kind < 0.45:
        raw = _zip_fields(rng, raw)
    path.write_bytes(raw)
    return path


def _name(rng: Random, name: str) -> str:
    if rng.random() > 0.02:
        return name
    return rng.choice(("../" + name, "piezo", "piezo.npy.npy", "a/b.npy", "x" * 300, ".npy"))


def _npy(rng: Random, data: bytes) -> bytes:
    """Return an .npy file with another header, or with changed bytes."""
    if rng.random() < 0.3:
        return mutate.raw(rng, data)
    shape = rng.choice(
        ("(10**12,)", "(1000000000000,)", "(4, 620, 1)", "(-1,)", "(2**70,)", "()",
         "(4, 620, 10**9)", "(4L,)", "[4]", "(True,)", "(0, 1000000000000)",
         "(1180591620717411303424,)")
    )  # fmt: skip
    kind = rng.choice(("<f4", "|O", "<U1000000000", "V1000000000", "<M8[s]", "<f16", "zz", ">i2"))
    order = rng.choice(("False", "True", "None"))
    head = f"{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}, }}"
    if rng.random() < 0.1:
        head = rng.choice(("{}", "[" * 5000, "(" * 200 + ")" * 200, head[:-3], "{'descr': " * 90))
    version = rng.choice((b"\x01\x00", b"\x02\x00", b"\x03\x00", b"\x09\x09"))
    body = head.encode() + b"\n"
    size = struct.pack("<H" if version == b"\x01\x00" else "<I", len(body))
    return b"\x93NUMPY" + version + size + body + data[128:]


def _zip_fields(rng: Random, raw: bytes) -> bytes:
    """Change a header field of a member of a ZIP archive: flags, method, sizes or offsets."""
    out = bytearray(raw)
    for signature, fields in (
        (b"PK\x03\x04", (6, 8, 14, 18, 22)),
        (b"PK\x01\x02", (8, 10, 20, 24)),
    ):
        at = -1
        for _ in range(rng.choice((1, 2))):
            at = out.find(signature, at + 1)
        if at >= 0:
            place = at + rng.choice(fields)
            number = rng.choice((0, 1, 8, 9, 12, 14, 93, 99, 2**16 - 1, 2**31, 2**32 - 1))
            out[place : place + 2] = struct.pack("<I", number)[:2]
            if number >= 2**16 - 1:
                out[place : place + 4] = struct.pack("<I", number)
    return bytes(out)


def hdf5(rng: Random, seeds: Seeds, path: Path) -> Path:
    """Import an HDF5 file with unusual features of the format."""
    settings = ("sample_rate_hz", "piezo_unit", "smoothing_alpha", "source")
    with h5py.File(path, "w", libver=rng.choice(("earliest", "latest"))) as file:
        for name, array in arrays(rng, seeds).items():
            held_out = array.astype(h5py.string_dtype()) if array.dtype.kind == "U" else array
            try:
                if name in settings:
                    (file if rng.random() < 0.8 else file["piezo"]).attrs[name] = held_out
                else:
                    file.create_dataset(name.replace("/", "_"), data=held_out)
            except (TypeError, ValueError, KeyError, OSError, RuntimeError):
                continue
        if rng.random() < 0.5:
            _strange(rng, file, path)
    if rng.random() < 0.4:
        path.write_bytes(mutate.raw(rng, path.read_bytes()))
    return path


def _strange(rng: Random, file: h5py.File, path: Path) -> None:
    name = rng.choice((*sorted(file), "extra", "object", "session"))
    if name in file:
        del file[name]
    kind = rng.randrange(12)
    if kind == 0:
        file[name] = h5py.SoftLink("/nothing")
    elif kind == 1:
        file[name] = h5py.SoftLink(f"/{name}")
    elif kind == 2:
        file[name] = h5py.ExternalLink("/etc/passwd", "/")
    elif kind == 3:
        file[name] = h5py.ExternalLink(str(path), "/")
    elif kind == 4:
        file.create_dataset(name, (4,), "S8", external=[("/etc/passwd", 0, 32)])
    elif kind == 5:
        file.create_dataset(name, (10**6, 10**6), "f4", chunks=(1000, 1000))
    elif kind == 6:
        file.create_dataset(name, (2**40,), "i1", chunks=(2**20,), compression="gzip")
    elif kind == 7:
        file.create_dataset(name, data=h5py.Empty("f4"))
    elif kind == 8:
        made = file.create_dataset(name, (4,), h5py.vlen_dtype(np.int32))
        made[0] = [1, 2, 3]
    elif kind == 9:
        file.create_dataset(name, (4,), np.dtype([("a", "f4"), ("b", "S3")]))
    elif kind == 10:
        group = file.create_group(name)
        group["up"] = h5py.SoftLink("/")
        group["self"] = group
    else:
        file.create_dataset(name, (4,), h5py.ref_dtype)
        file.attrs["sample_rate_hz"] = h5py.Empty("f8")


def table(rng: Random, seeds: Seeds, path: Path) -> Path:
    """Import a damaged long CSV."""
    rows = [list(row) for row in seeds.csv]
    if rng.random() < 0.5:
        at = rng.randrange(len(rows[0]))
        for row in rows[rng.choice((0, 1)) :]:
            row[at] = rng.choice((mutate.text(rng), row[at])) if rng.random() < 0.1 else row[at]
    path.write_bytes(mutate.table(rng, rows))
    return path
