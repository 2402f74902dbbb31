"""The one error that users are meant to read."""

from __future__ import annotations


class InputError(ValueError):
    """What the user gave cannot be used.

    The message is one sentence that names the file, the field in it and the
    remedy. The command line prints it and exits with code 2.
    """
