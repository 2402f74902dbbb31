"""Speed of our decoder of a device's bytes, compared with real time and with a plain decoder.

One minute of samples goes through our decoder and the assembler of blocks. The bytes are cut into
pieces of 1 ms, as a port delivers them, and into pieces of 64 kB, as after a stall. The plain
decoder undoes COBS byte by byte, and uses ``zlib`` for the CRC and ``struct`` for the samples. Both
must give the same samples. Run it with one thread: ``OMP_NUM_THREADS=1 python
benchmarks/decoding.py``.
"""

from __future__ import annotations

import argparse
import struct
import time
import zlib

import numpy as np

from firstcontact.core import Block, fingertip_layout
from firstcontact.device import Descriptor
from firstcontact.device.assembler import Assembler
from firstcontact.device.protocol import (
    FRAME_SAMPLES,
    FrameType,
    descriptor_payload,
    encode,
    samples_payload,
)

LAYOUT = fingertip_layout()
CHANNELS = len(LAYOUT.channels)
#: Runs of each measurement; the best counts.
REPEATS = 5


def stream(seconds: float) -> tuple[bytes, bytes, np.ndarray]:
    """Return the bytes that a device sends in ``seconds`` s.

    The result is the frame with its descriptor, the frames with its samples, and these samples.
    """
    count = round(seconds * LAYOUT.rate / FRAME_SAMPLES) * FRAME_SAMPLES
    # Slow and small signals, as of piezos and taxels, with many zero bytes.
    rng = np.random.default_rng(0)
    steps = rng.normal(0.0, 30.0, (count, CHANNELS)).cumsum(axis=0)
    data = (16_384 + 8_000 * np.sin(steps / 3_000)).astype(np.int16)
    data[:, -2:] = 0  # strips
    greeting = encode(FrameType.DESCRIPTOR, 0, descriptor_payload(1, Descriptor(LAYOUT).to_text()))
    frames = [
        encode(
            FrameType.SAMPLES,
            1 + first // FRAME_SAMPLES,
            samples_payload(first, 0, data[first : first + FRAME_SAMPLES]),
        )
        for first in range(0, count, FRAME_SAMPLES)
    ]
    return greeting, b"".join(frames), data


def ours(greeting: bytes, pieces: list[bytes]) -> tuple[float, list[Block]]:
    """Decode the bytes with this package. Return the time, s, and the decoded blocks."""
    assembler = Assembler()
    assembler.feed(greeting)
    blocks: list[Block] = []
    begin = time.perf_counter()
    for piece in pieces:
        blocks += assembler.feed(piece).blocks
    spent = time.perf_counter() - begin
    assert (assembler.decoder.bad, assembler.counts.lost_samples) == (0, 0)
    return spent, blocks


def plain(pieces: list[bytes]) -> tuple[float, list[tuple[int, ...]]]:
    """Decode the bytes with the plain decoder. Return the time, s, and the rows of samples."""
    row = struct.Struct(f"<{CHANNELS}h")
    rows: list[tuple[int, ...]] = []
    body = bytearray()
    left = code = 0
    begin = time.perf_counter()
    for piece in pieces:
        for byte in piece:
            if byte == 0:
                assert zlib.crc32(body[:-4]) == struct.unpack_from("<I", body, len(body) - 4)[0]
                kind, _ = struct.unpack_from("<BI", body)
                if kind == FrameType.SAMPLES:
                    _, _, n = struct.unpack_from("<IIB", body, 5)
                    rows += [row.unpack_from(body, 14 + row.size * k) for k in range(n)]
                body.clear()
                left = code = 0
            elif left:
                body.append(byte)
                left -= 1
            else:
                if code not in (0, 255):
                    body.append(0)
                code, left = byte, byte - 1
    return time.perf_counter() - begin, rows


def main() -> dict[str, float]:
    """Measure both decoders and print the table. Return the ratios by name."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the stream")
    settings = parser.parse_args()
    greeting, wire, data = stream(settings.seconds)
    seconds = len(data) / LAYOUT.rate
    millisecond = round(len(wire) / seconds / 1e3)
    print(f"{seconds:.0f} s of stream, {len(wire) / seconds / 1e3:.0f} kB/s")
    ratios = {}
    for name, size in (("1 ms", millisecond), ("64 kB", 65_536)):
        pieces = [wire[at : at + size] for at in range(0, len(wire), size)]
        fast, slow = np.inf, np.inf
        for _ in range(REPEATS):
            spent, blocks = ours(greeting, pieces)
            fast = min(fast, spent)
            spent, rows = plain(pieces)
            slow = min(slow, spent)
            assert np.array_equal(np.concatenate([b.data for b in blocks]), data)
            assert np.array_equal(np.array(rows, np.int16), data)
        print(
            f"in pieces of {name}: {seconds / fast:.0f} times real time on one core "
            f"({1e6 * fast / len(pieces):.0f} us a piece), "
            f"{slow / fast:.1f} times faster than byte by byte"
        )
        ratios[f"pieces of {name}, against byte by byte"] = slow / fast
    return ratios


if __name__ == "__main__":
    main()
