"""Errors whose messages users read."""

from __future__ import annotations


class InputError(ValueError):
    """Error for an input that cannot be used.

    The message is one sentence with the file, the field in it and the remedy. The command line
    prints it with the parameter's option and exits with code 2.

    Parameters
    ----------
    message
        Problem, then remedy.
    parameter
        Name of the parameter that is wrong; "" if the message already names the input.

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
