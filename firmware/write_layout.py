"""Write core/fc_layout.h: the descriptor of the fingertips for the firmware.

It contains ``firstcontact.core.fingertip_layout()`` and the package's version. Run this after you
change either.
"""

from __future__ import annotations

import json
from pathlib import Path

from firstcontact import __version__
from firstcontact.core import ChannelKind, fingertip_layout
from firstcontact.device.descriptor import layout_to_send

PAGE = Path(__file__).parent / "core" / "fc_layout.h"
HEAD = """\
/* The descriptor that the device sends. Written by write_layout.py: do not edit. */
#ifndef FC_LAYOUT_H
#define FC_LAYOUT_H

#define FC_FIRMWARE_VERSION "@VERSION@"

#define FC_LAYOUT \\
"""
TAIL = """

/* Volts of a reading are (reading - offset) * scale. */
#define FC_PIEZO_OFFSET @PIEZO_OFFSET@
#define FC_PIEZO_SCALE @PIEZO_SCALE@
#define FC_FORCE_OFFSET @FORCE_OFFSET@
#define FC_FORCE_SCALE @FORCE_SCALE@

/* board and source are string literals; source is "real", "twin" or "synthetic". */
#define FC_DESCRIPTOR_TEXT(board, source) \\
    "{\\"firmware\\":\\"firstcontact " FC_FIRMWARE_VERSION " (" board ")\\"," \\
    "\\"sensor\\":\\"piezo + 3x2 Velostat, two fingertips\\",\\"hand\\":\\"\\"," \\
    "\\"source\\":\\"" source "\\",\\"layout\\":" FC_LAYOUT "}"

#endif
"""


def text() -> str:
    """Return the text of the header."""
    layout = json.dumps(layout_to_send(fingertip_layout()), separators=(",", ":"))
    pieces = layout.replace("},{", "},\n{").replace("],", "],\n").split("\n")
    lines = ['    "' + piece.replace('"', '\\"') + '"' for piece in pieces]
    tail = TAIL
    for name, kind in (("PIEZO", ChannelKind.VIBRATION), ("FORCE", ChannelKind.FORCE)):
        channel = next(c for c in fingertip_layout().channels if c.kind is kind)
        tail = tail.replace(f"@{name}_OFFSET@", repr(channel.offset))
        tail = tail.replace(f"@{name}_SCALE@", repr(channel.scale))
    return HEAD.replace("@VERSION@", __version__) + " \\\n".join(lines) + tail


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
