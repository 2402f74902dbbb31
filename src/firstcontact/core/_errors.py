"""Exceptions for inputs that cannot be used. Users read the messages."""

from __future__ import annotations


class InputError(ValueError):
    """Error for an input that cannot be used, such as a damaged file or a wrong parameter.

    The message names the file and the field in it, says what is wrong, and gives a remedy. The
    command line prints it with the parameter's option and exits with code 2. The subclasses say
    what failed, for programs: ``ArgumentError``, ``FileError``, ``DeviceError``, ``ModelError``.

    Parameters
    ----------
    message
        Text of the error: the problem, then the remedy.
    parameter
        Name of the function parameter that is wrong; "" if the message already names the input.

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


class ArgumentError(InputError):
    """Error for an argument of a function. ``parameter`` names it.

    Examples
    --------
    >>> import firstcontact as fc
    >>> try:
    ...     fc.adapt(seed=-1)
    ... except fc.ArgumentError as error:
    ...     print(error.parameter)
    seed
    """


class FileError(InputError):
    """Error for a file or folder that cannot be read, written or used.

    Examples
    --------
    >>> import firstcontact as fc
    >>> try:
    ...     fc.load("no-such-folder")
    ... except fc.FileError as error:
    ...     print("no-such-folder" in error.message)
    True
    """


class DeviceError(InputError):
    """Error for a device, or for the samples that it sends.

    Examples
    --------
    >>> import firstcontact as fc
    >>> try:
    ...     fc.open("lsl:")
    ... except fc.DeviceError as error:
    ...     print("lsl:" in error.message)
    True
    """


class ModelError(InputError):
    """Error for a model or its folder: damaged, or unfit for the task or the data.

    Examples
    --------
    >>> import firstcontact as fc
    >>> try:
    ...     fc.load_model("no-such-model")
    ... except fc.ModelError as error:
    ...     print("no-such-model" in error.message)
    True
    """
