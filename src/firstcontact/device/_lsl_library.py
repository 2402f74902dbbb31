"""Lab Streaming Layer library, shared by the LSL source and the LSL sink."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from firstcontact.core import InputError, install_command, require_modules

#: Settings files of liblsl. A user who has one has chosen the log level there.
_SETTINGS = (
    "lsl_api.cfg",
    "~/lsl_api/lsl_api.cfg",
    "/etc/lsl_api/lsl_api.cfg",
)


def lsl_library() -> Any:
    """Return the module pylsl, set to log only warnings and errors.

    Raises
    ------
    InputError
        The package pylsl or its C library is missing.
    """
    require_modules("live", "pylsl")
    try:
        import pylsl
    except RuntimeError as error:  # the C library is missing
        raise InputError(f"LSL needs liblsl ({error}): {install_command('live')}") from error
    has_settings = "LSLAPICFG" in os.environ or any(
        Path(name).expanduser().exists() for name in _SETTINGS
    )
    if not has_settings:
        # Without settings liblsl prints its default settings on standard error.
        with suppress(AttributeError, NotImplementedError):  # liblsl before 1.17.7
            pylsl.set_config_content("[log]\nlevel = -1\n")
    return pylsl
