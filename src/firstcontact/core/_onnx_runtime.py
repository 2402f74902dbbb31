"""Import of ONNX Runtime without its telemetry."""

from __future__ import annotations

import os
from typing import Any


def import_onnxruntime() -> Any:
    """Import ONNX Runtime with its telemetry switched off, and return the module.

    From version 1.31 on, the import writes a device ID and a database of events into the user's
    cache. An environment variable prevents this, and child processes inherit it.
    """
    os.environ["ORT_DISABLE_TELEMETRY"] = "1"
    import onnxruntime

    onnxruntime.disable_telemetry_events()  # the caller's program may have imported it before
    return onnxruntime
