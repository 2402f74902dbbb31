"""Damaged files of other programs: MATLAB, XDF, FLAC, label tracks and their tables."""

from __future__ import annotations

import io
import struct
from functools import cache
from pathlib import Path
from random import Random

import fuzz_mutate as mutate
import numpy as np
from fuzz_seeds import Seeds, signal

RATE = 4000.0
#: Samples of a file, and where something touches, s.
SAMPLES, TOUCHES = 4000, (0.4, 0.8)
CHANNELS = [
    ["variable", "sensor", "finger", "rate_hz", "unit", "scale", "offset"],
    ["pac", "hydrophone", "index", "2200", "", "0.5", "2000"],
    ["pressure", "", "index", "100", "", "1", "0"],
]
STREAMS = [
    ["stream", "sensor", "finger", "rate_hz", "column", "unit", "scale", "offset"],
    ["disc", "piezo", "index", "4000", "0", "V", "1", "0"],
]


@cache
def _heard() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    rng = np.random.default_rng(7)
    out = 0.01 * rng.standard_normal(SAMPLES)
    for at in TOUCHES:
        begin = round(at * RATE)
        out[begin : begin + 300] += signal(45.0, rng)[-300:]
    return out


@cache
def _mat() -> bytes:
    from scipy.io import savemat

    n, out = 50, io.BytesIO()
    rng = np.random.default_rng(8)
    arrays = {
        "pac": rng.integers(1900, 2100, (22, n)).astype(np.uint16),
        "pressure": rng.integers(0, 4000, (1, n)).astype(np.uint16),
    }
    savemat(out, arrays, do_compression=False)
    return out.getvalue()


def mat(rng: Random, seeds: Seeds, folder: Path) -> list[str]:
    """Import a MATLAB file with a table of its variables, or sometimes with arrays of pinches."""
    path, table = folder / "a.mat", folder / "channels.csv"
    if rng.random() < 0.3:
        from scipy.io import savemat

        labelled_contacts = {k: v for k, v in seeds.arrays.items() if rng.random() < 0.95}
        savemat(path, labelled_contacts)
        path.write_bytes(mutate.raw(rng, path.read_bytes()))
        return ["import", str(path)]
    path.write_bytes(mutate.raw(rng, _mat()) if rng.random() < 0.6 else _mat())
    table.write_bytes(mutate.table(rng, CHANNELS))
    return ["import", str(path), "--channels", str(table)]


def _chunk(tag: int, content: bytes) -> bytes:
    return b"\x04" + struct.pack("<IH", len(content) + 2, tag) + content


def _stream(rng: Random, number: int, name: str, rate: float, kind: str, texts: bool) -> bytes:
    """Return an XDF stream with header, samples, clock offset and footer, often inconsistent."""
    message = str(rate) if rng.random() < 0.85 else str(rng.choice((0, -1, "nan", 1e12, "x", "")))
    width = "1" if rng.random() < 0.9 else str(rng.choice((0, -1, 2, 10**9, "x")))
    xml = (
        f"<?xml version='1.0'?><info><name>{name}</name><type>x</type><channel_count>{width}"
        f"</channel_count><nominal_srate>{message}</nominal_srate><channel_format>{kind}"
        "</channel_format><created_at>1</created_at><desc/></info>"
    )
    of = struct.pack("<I", number)
    parts = [_chunk(2, of + xml.encode())]
    values = _heard().astype("<f4")
    times = TOUCHES if texts else tuple(np.arange(SAMPLES) / RATE)
    for start in range(0, len(times), 500):
        sample = times[start : start + 500]
        body = of + b"\x04" + struct.pack("<I", len(sample))
        for i, at in enumerate(sample, start):
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
    """Import a vibration stream and a stream of markers."""
    path, table = folder / "a.xdf", folder / "channels.csv"
    kind = rng.choice(("float32", "float32", "float32", "double64", "int8", "string", "x"))
    body = b"XDF:" + _chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>")
    body += _stream(rng, 1, "disc", RATE, kind, texts=False)
    body += _stream(rng, rng.choice((2, 2, 2, 1)), "marks", 0.0, "string", texts=True)
    path.write_bytes(mutate.raw(rng, body) if rng.random() < 0.4 else body)
    words = ["import", str(path)]
    if rng.random() < 0.3:
        table.write_bytes(mutate.table(rng, STREAMS))
        words += ["--channels", str(table)]
    return words


@cache
def _flac() -> bytes:
    import soundfile

    out = io.BytesIO()
    soundfile.write(out, 0.3 * _heard() / np.abs(_heard()).max(), round(RATE), format="FLAC")
    return out.getvalue()


def sound(rng: Random, _: Seeds, folder: Path) -> list[str]:
    """Import FLAC with an Audacity label track, or with a table of the contacts."""
    path = folder / "a.flac"
    path.write_bytes(mutate.raw(rng, _flac()) if rng.random() < 0.4 else _flac())
    if rng.random() < 0.5:
        events = folder / "labels.txt"
        lines = [f"{at:.6f}\t{at + 0.01:.6f}\teraser; shore_a=40\n" for at in TOUCHES]
        lines.insert(1, "\\\t100.0\t2000.0\n")
        text = "".join(lines).replace("\t", rng.choice(("\t", "\t", "\t", " ", "\t\t")))
        if rng.random() < 0.5:
            text = text.replace("40", str(rng.choice(mutate.NUMBERS)))
        raw = text.encode()
        events.write_bytes(mutate.raw(rng, raw) if rng.random() < 0.7 else raw)
    else:
        events = folder / "events.csv"
        rows = [["onset_s", "shore_a", "object"], *([str(at), "40", "x"] for at in TOUCHES)]
        events.write_bytes(mutate.table(rng, rows))
    return ["import", str(path), "--events", str(events)]


def journal(rng: Random, _: Seeds, folder: Path) -> list[str]:
    """Continue the journal of a label page."""
    import json

    from firstcontact.core import Block, Channel, ChannelKind, Layout
    from firstcontact.recording import Header, RecordingWriter

    layout = Layout((Channel("disc", ChannelKind.VIBRATION, None, "V"),), RATE)
    with RecordingWriter(folder / "a.mcap", Header(layout, "real", dtype="float32")) as writer:
        writer.write(Block(_heard().astype(np.float32)[:, None], 0))
    computed = rng.choice((2, 2, 2, 2, 0, 3))
    lines = [json.dumps({"labelling": ["a.mcap"], "found": computed}).encode()]
    for _ in range(rng.randrange(1, 6)):
        do = rng.choice(("accept", "reject", "move", "add", "label", "undo"))
        number, sample = rng.choice((0, 1, 1, 2, 2**40)), rng.choice((0, 1650, 2**40))
        tree = {"do": do, "number": number, "sample": sample, "object": "x", "shore_a": 40.0}
        plain = json.dumps(tree).encode()
        lines.append(mutate.tree(rng, tree) if rng.random() < 0.4 else plain)
    (folder / "out").mkdir()
    raw = b"\n".join(lines) + rng.choice((b"\n", b"\n", b""))
    (folder / "out" / "labels.jsonl").write_bytes(
        mutate.raw(rng, raw) if rng.random() < 0.2 else raw
    )
    return ["label", str(folder / "a.mcap"), "--finish"]


MAKERS = (mat, xdf, sound, sound, journal)
