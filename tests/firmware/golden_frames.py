"""Frames of the wire protocol byte by byte, which C and Python must both produce."""

from __future__ import annotations

from typing import NamedTuple


class Golden(NamedTuple):
    """One frame: payload and complete frame as hex text, including the final zero."""

    name: str
    type: int
    counter: int
    payload: str
    wire: str


GOLDEN = (
    Golden("hello", 0x81, 0x0, "01", "028101010106014856291300"),
    Golden("start", 0x82, 0x1, "", "0382010101058a73b8b500"),
    Golden("stop", 0x83, 0xFFFFFFFF, "", "0a83ffffffffbc1ddfee00"),
    Golden("mark", 0x84, 0x3, "417066656c20c3bc", "03840301010d417066656c20c3bca0a8a4f500"),
    Golden("mark without words", 0x84, 0x4, "", "0384040101051876260d00"),
    Golden("descriptor", 0x01, 0x0, "01040302017b7d", "02010101010c01040302017b7d72b682d300"),
    Golden("one sample", 0x02, 0x7,
           "000000000000000001f8fff9fffafffbfffcfffdfffeffffff00000100020003000400050006000700",
           "030207010101010101010101011201f8fff9fffafffbfffcfffdfffeffffff0102010202020302040205"
           "0206020705f507d60800"),
    Golden("five samples, numbers about to wrap", 0x02, 0x100,
           "feffffff010200000500000101020203030404050506060707080809090a0a0b0b0c0c0d0d0e0e0f0fe8"
           "03e904ea05eb06ec07ed08ee09ef0af00bf10cf20df30ef40ff510f611f712d007d108d209d30ad40bd5"
           "0cd60dd70ed80fd910da11db12dc13dd14de15df16b80bb90cba0dbb0ebc0fbd10be11bf12c013c114c2"
           "15c316c417c518c619c71aa00fa110a211a312a413a514a615a716a817a918aa19ab1aac1bad1cae1daf"
           "1e",
           "020202010107feffffff010201020501a30101020203030404050506060707080809090a0a0b0b0c0c0d"
           "0d0e0e0f0fe803e904ea05eb06ec07ed08ee09ef0af00bf10cf20df30ef40ff510f611f712d007d108d2"
           "09d30ad40bd50cd60dd70ed80fd910da11db12dc13dd14de15df16b80bb90cba0dbb0ebc0fbd10be11bf"
           "12c013c114c215c316c417c518c619c71aa00fa110a211a312a413a514a615a716a817a918aa19ab1aac"
           "1bad1cae1daf1e3a551d1600"),
    Golden("payload of 245 bytes: a run of 254, then nothing", 0x7F, 0x1010101,
           "0102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f202122232425262728292a"
           "2b2c2d2e2f303132333435363738393a3b3c3d3e3f404142434445464748494a4b4c4d4e4f5051525354"
           "55565758595a5b5c5d5e5f606162636465666768696a6b6c6d6e6f707172737475767778797a7b7c7d7e"
           "7f808182838485868788898a8b8c8d8e8f909192939495969798999a9b9c9d9e9fa0a1a2a3a4a5a6a7a8"
           "a9aaabacadaeafb0b1b2b3b4b5b6b7b8b9babbbcbdbebfc0c1c2c3c4c5c6c7c8c9cacbcccdcecfd0d1d2"
           "d3d4d5d6d7d8d9dadbdcdddedfe0e1e2e3e4e5e6e7e8e9eaebecedeeeff0f1f2f3f4f5",
           "ff7f010101010102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f2021222324"
           "25262728292a2b2c2d2e2f303132333435363738393a3b3c3d3e3f404142434445464748494a4b4c4d4e"
           "4f505152535455565758595a5b5c5d5e5f606162636465666768696a6b6c6d6e6f707172737475767778"
           "797a7b7c7d7e7f808182838485868788898a8b8c8d8e8f909192939495969798999a9b9c9d9e9fa0a1a2"
           "a3a4a5a6a7a8a9aaabacadaeafb0b1b2b3b4b5b6b7b8b9babbbcbdbebfc0c1c2c3c4c5c6c7c8c9cacbcc"
           "cdcecfd0d1d2d3d4d5d6d7d8d9dadbdcdddedfe0e1e2e3e4e5e6e7e8e9eaebecedeeeff0f1f2f3f4f562"
           "e578ae0100"),
    Golden("marker", 0x03, 0x9,
           "48130000417066656c20c3bc", "0303090101034813010d417066656c20c3bc70b4e8ab00"),
    Golden("stopped", 0x04, 0xA, "d1c0000011000000", "03040a010103d1c0010211010105861df5cb00"),
    Golden("refused", 0x05, 0xB, "01737065616b732076657273696f6e2031",
           "03050b01011601737065616b732076657273696f6e20313c5cd9fc00"),
    Golden("line feeds and flow control", 0x03, 0x1311,
           "110a0d130d0a1113", "04031113010d110a0d130d0a1113a78632b500"),
    Golden("contact", 0x06, 0xC,
           "c2120000c81200000101", "03060c010103c2120103c81201070101bfab27a800"),
    Golden("estimate", 0x07, 0xD, "c2120000d01200000f000102000026420000f24100005342a8ba0600",
           "03070d010103c2120103d01201020f030102010326420103f24101065342a8ba060559fe3a9a00"),
    Golden("state of a model, refused", 0x08, 0xE,
           "0286000000006e6f", "03080e0101030286010101076e6fa4a4d63300"),
    Golden("a model begins", 0x86, 0xF, "0100000078563412b0fd0100efbeadde",
           "03860f0101020101010878563412b0fd0109efbeadde9ef5032500"),
    Golden("a piece of a model", 0x87, 0x10,
           "c8000000000100ff", "038710010102c8010101020106ff0951f65b00"),
    Golden("a model ends", 0x88, 0x11, "", "038811010105b43c11af00"),
)  # fmt: skip
