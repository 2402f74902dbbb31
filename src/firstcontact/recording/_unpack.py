"""The records of a chunk, if it is intact; sizes are looked at before anything is allocated."""

from __future__ import annotations

import struct
import zlib
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import breakup_chunk

from firstcontact.recording._sizes import most_unpacked

#: Of a compressor's window, bytes.
_WINDOW = 1 << 27


class Unpacker:
    """Takes the chunks of one file apart.

    Parameters
    ----------
    size
        Of the file, bytes.
    """

    def __init__(self, size: int) -> None:
        self._left = most_unpacked(size)  # for all compressed chunks together
        self.refused = 0  # chunks that would unpack to more than is allowed

    def records(self, body: bytes) -> list[McapRecord] | None:
        """The records of a chunk, or None if its checksum, form or size is wrong."""
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
            # The library takes 0 for "not checked".
            if zlib.crc32(chunk.data) != chunk.uncompressed_crc:
                return None
            return list(breakup_chunk(chunk))
        except (McapError, ZstdError, ValueError, RuntimeError, OverflowError, struct.error):
            return None


def _decompressed(chunk: Chunk) -> bytes:
    """At most one byte more than the chunk says; ValueError where it is not what it says."""
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
        raise ValueError(f"{len(data)} bytes and not {size}")
    return data
