"""Import of ONNX Runtime without its telemetry."""

from __future__ import annotations

import os
from typing import Any


def import_onnxruntime() -> Any:
    """Return the module ``onnxruntime``, imported with its telemetry switched off.

    From version 1.31 on, its import writes a device id and a database of events into the user's
    cache, unless this variable is set. Processes that start later inherit the variable.
    """
    os.environ["ORT_DISABLE_TELEMETRY"] = "1"
    import onnxruntime

    onnxruntime.disable_telemetry_events()  # the caller's program may have imported it before
    return onnxruntime
