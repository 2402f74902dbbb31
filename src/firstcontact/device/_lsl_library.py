"""Lab Streaming Layer library, shared by the LSL source and the LSL sink."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from firstcontact.core import InputError, install_command, require_modules

#: Files that liblsl reads its settings from. A user who has one chose the level of its log.
_SETTINGS = (
    "lsl_api.cfg",
    "~/lsl_api/lsl_api.cfg",
    "/etc/lsl_api/lsl_api.cfg",
)


def lsl_library() -> Any:
    """Load pylsl, with a log of warnings and errors only.

    Raises
    ------
    InputError
        pylsl is missing, or its C library is.
    """
    require_modules("live", "pylsl")
    try:
        import pylsl
    except RuntimeError as error:  # the library of C is not there
        raise InputError(f"LSL needs liblsl ({error}): {install_command('live')}") from error
    has_settings = "LSLAPICFG" in os.environ or any(
        Path(name).expanduser().exists() for name in _SETTINGS
    )
    if not has_settings:
        # Without settings liblsl prints on standard error which ones it takes.
        with suppress(AttributeError, NotImplementedError):  # older than 1.17.7
            pylsl.set_config_content("[log]\nlevel = -1\n")
    return pylsl
