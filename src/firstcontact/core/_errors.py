"""Errors that users are meant to read."""

from __future__ import annotations


class InputError(ValueError):
    """An input that cannot be used.

    The message is one sentence that names the file, the field in it and the remedy. The command
    line prints it, with the option of the parameter, and exits with code 2.

    Parameters
    ----------
    message
        What is wrong, and the remedy.
    parameter
        Name of the parameter that is wrong; "" where the message names what it is about.

    Examples
    --------
    >>> import firstcontact as fc
    >>> try:
    ...     fc.adapt(seed=-1)
    ... except fc.InputError as error:
    ...     print(error.parameter)
    seed
    """

    def __init__(self, message: str, parameter: str = "") -> None:
        super().__init__(f"{parameter}: {message}" if parameter else message)
        self.message = message
        self.parameter = parameter
