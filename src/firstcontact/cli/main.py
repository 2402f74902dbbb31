"""Entry point of ``firstcontact``: it runs a command, and prints each error as one sentence."""

from __future__ import annotations

import errno
import shutil
import sys
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

from firstcontact.cli.output import Output, outputs
from firstcontact.cli.stopping import Stop, stop_on_signals
from firstcontact.cli.verbs import configuration, overview
from firstcontact.core import ArgumentError, InputError
from firstcontact.core.text import one_line, summarize_error

#: Exit codes: success, unusable input, unexpected error. A verb may return another one. After a
#: signal the code is 128 plus the signal's number.
DONE, INPUT, UNFORESEEN = 0, 2, 70
#: Option of all verbs.
VERBOSE = "--verbose"
#: Longest sentence, characters.
LONGEST = 2000
#: Errors of a full disk, which the user can fix.
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def main(arguments: Sequence[str] | None = None) -> int:
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    verbose = VERBOSE in arguments
    if verbose:
        arguments.remove(VERBOSE)
    # Live ends when its output is closed; other verbs finish their work.
    with outputs(raises=arguments[:1] == ["live"]) as (out, _), stop_on_signals() as stop:
        code = _run(arguments, stop, verbose)
        out.flush()
        return code or _output_code(out)


def _run(arguments: list[str], stop: Stop, verbose: bool) -> int:
    verb = None
    code = None
    try:
        verb = _parse(arguments)
        if verb is not None:
            from firstcontact.cli.logs import logged

            with logged(verbose):
                code = verb.run()
    except InputError as error:
        return _failed(INPUT, _with_option(error, verb))
    except KeyboardInterrupt as interrupt:  # its text may name unfinished work
        return _failed(stop.code, str(interrupt) or "interrupted")
    except SystemExit as end:
        if verb is None:  # the parser printed the help
            raise
        return _failed(INPUT, f"another package ended the command ({summarize_error(end)})")
    except Exception as error:
        # The user can fix a path that cannot be read or written.
        if isinstance(error, OSError) and error.errno in FULL:
            subject = "" if error.filename is None else f"{error.filename}: "
            return _failed(INPUT, f"{subject}{error.strerror}: make room on the disk written to")
        if isinstance(error, OSError) and error.filename is not None:
            return _failed(INPUT, f"{error.filename}: {error.strerror}: check this path")
        from firstcontact.cli.logs import crash_report

        return _failed(UNFORESEEN, crash_report(error, arguments))
    # Ctrl-C is the normal end of some verbs; the loss of the terminal is not.
    orderly = stop.signal is None or stop.signal.name in ("SIGINT", "SIGTERM")
    return code or DONE if orderly else stop.code


def _parse(arguments: list[str]) -> Any:
    """Return the command that the arguments name, as an instance of its dataclass.

    Return None after ``--help`` and ``--version``, which print their text. Raise InputError for
    wrong arguments.
    """
    width = shutil.get_terminal_size().columns
    if not arguments:
        print(overview(width), file=sys.stderr)
        raise ArgumentError("no command is given: choose one of these, such as `firstcontact live`")
    word = arguments[0]
    if word in ("-h", "--help"):
        print(overview(width))
        return None
    if word == "--version":
        from firstcontact import __version__

        print(f"firstcontact {__version__}")
        return None
    verb = configuration(word)
    from firstcontact.cli.options import parse_options

    return parse_options(verb, f"firstcontact {word}", arguments[1:])


def _with_option(error: InputError, verb: Any) -> str:
    """Return the message of an error, after the wrong option or path if one is known.

    ``verb`` is the command, whose options have the names of its fields.
    """
    if not error.parameter or verb is None:
        return str(error)
    field = getattr(verb, "options", {}).get(error.parameter, error.parameter)
    value = getattr(verb, field, None)
    subject = value if isinstance(value, PurePath) else f"--{field.replace('_', '-')}"
    return f"{subject}: {error.message}"


def _failed(code: int, sentence: str) -> int:
    if len(sentence) > LONGEST:  # keep the remedy at the end
        sentence = f"{sentence[: LONGEST // 2]} ... {sentence[-LONGEST // 2 :]}"
    print(f"firstcontact: {one_line(sentence)}", file=sys.stderr)
    return code


def _output_code(out: Output) -> int:
    """Return exit code 2, and print the reason, if standard output could not be written.

    Return 0 otherwise, also if the program that reads standard output has closed it.
    """
    if out.failed is None or out.gone:
        return DONE
    return _failed(INPUT, f"standard output: {out.failed.strerror}: the output is incomplete")


if __name__ == "__main__":
    sys.exit(main())
