"""Reader of a chunk's records. It checks sizes before it allocates memory."""

from __future__ import annotations

import struct
import zlib
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import breakup_chunk

from firstcontact.recording._sizes import most_unpacked

#: Largest window of a compressor, bytes.
_WINDOW = 1 << 27


class Unpacker:
    """Unpacker for the chunks of one file."""

    def __init__(self, size: int) -> None:
        self._left = most_unpacked(size)  # bytes left for all compressed chunks together
        self.refused = 0  # number of chunks that exceed the limit

    def records(self, body: bytes) -> list[McapRecord] | None:
        """Return the records of a chunk, or None if its checksum, form or size is wrong."""
        from zstandard import ZstdError

        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(body)))
            if chunk.compression:
                if chunk.uncompressed_size > self._left:
                    self.refused += 1
                    return None
                chunk.data = _decompressed(chunk)
                self._left -= len(chunk.data)
                chunk.compression = ""
            # The library treats 0 as "not checked".
            if zlib.crc32(chunk.data) != chunk.uncompressed_crc:
                return None
            return list(breakup_chunk(chunk))
        except (McapError, ZstdError, ValueError, RuntimeError, OverflowError, struct.error):
            return None


def _decompressed(chunk: Chunk) -> bytes:
    """Decompress a chunk up to one byte beyond its stated size. Raise ValueError on a mismatch."""
    size = int(chunk.uncompressed_size)
    data: bytes
    if chunk.compression == "zstd":
        from zstandard import ZstdDecompressor

        with ZstdDecompressor(max_window_size=_WINDOW).stream_reader(chunk.data) as reader:
            data = reader.read(size + 1)
    else:
        from lz4.frame import LZ4FrameDecompressor

        data = LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
    if len(data) != size:
        raise ValueError(f"the compressed data unpack to {len(data)} bytes instead of {size}")
    return data
