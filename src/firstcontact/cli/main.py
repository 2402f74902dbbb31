"""The ``firstcontact`` command: finds the verb and turns errors into one sentence."""

from __future__ import annotations

import errno
import shutil
import sys
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

from firstcontact import __version__
from firstcontact.cli.output import Output, outputs
from firstcontact.cli.stopping import Stop, stopping
from firstcontact.cli.verbs import configuration, overview
from firstcontact.core import ForeignCode, InputError, culprit, in_a_line, is_interrupt, one_line

#: Exit codes; a signal's is 128 and its number.
DONE, INPUT, UNFORESEEN = 0, 2, 70
#: The option of all verbs.
VERBOSE = "--verbose"
#: Characters of a sentence that are shown.
LONGEST = 2000
#: The disk's, and so the user's to mend.
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb.

    Returns
    -------
    int
        0 done, 2 the input cannot be used, 70 a fault of ours, 128 and its number for a signal
        (130 for Ctrl-C).
    """
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    verbose = VERBOSE in arguments
    if verbose:
        arguments.remove(VERBOSE)
    # Live ends when nobody reads it; other verbs have work to do that is not for the reader.
    with outputs(raises=arguments[:1] == ["live"]) as (out, _), stopping() as stop:
        code = _run(arguments, stop, verbose)
        out.flush()
        return code or _unsaid(out)


def _run(arguments: list[str], stop: Stop, verbose: bool) -> int:
    verb = None
    try:
        verb = _parsed(arguments)
        if verb is not None:
            from firstcontact.cli.logs import logged

            with logged(verbose), ForeignCode():
                verb.run()
    except InputError as error:
        return _failed(INPUT, _with_option(error, verb))
    except KeyboardInterrupt as interrupt:  # which may say what is left unfinished
        return _failed(stop.code, str(interrupt) or "interrupted")
    except BaseException as error:
        if verb is None and isinstance(error, SystemExit):  # the help was printed
            raise
        if culprit(error) and is_interrupt(error):  # which a plug-in made into something else
            return _failed(stop.code, "interrupted")
        if not isinstance(error, Exception):  # no verb ends so: the command is not done
            what = f"other code ended the command ({in_a_line(error)})"
            return _failed(INPUT, f"{what}: remove packages that add plug-ins to firstcontact")
        # A path that cannot be read or written is the user's to mend, wherever it shows up.
        if isinstance(error, OSError) and error.errno in FULL:
            where = "" if error.filename is None else f"{error.filename}: "
            return _failed(INPUT, f"{where}{error.strerror}: make room on the disk written to")
        if isinstance(error, OSError) and error.filename is not None:
            return _failed(INPUT, f"{error.filename}: {error.strerror}: check this path")
        from firstcontact.cli.crash import told

        return _failed(UNFORESEEN, told(error, arguments))
    # Verbs that run until they are stopped end in order; without a terminal that is no success.
    orderly = stop.signal is None or stop.signal.name in ("SIGINT", "SIGTERM")
    return DONE if orderly else stop.code


def _parsed(arguments: list[str]) -> Any:
    """The verb with its options; None where a general option was all."""
    if not arguments:
        print(overview(shutil.get_terminal_size().columns), file=sys.stderr)
        raise InputError("name a verb")
    word = arguments[0]
    if word in ("-h", "--help"):
        print(overview(shutil.get_terminal_size().columns))
        return None
    if word == "--version":
        print(f"firstcontact {__version__}")
        return None
    if word == "--completion":
        from firstcontact.cli.completion import completion_script

        print(completion_script(), end="")
        return None
    verb = configuration(word)
    import tyro

    from firstcontact.cli.option_numbers import option_numbers
    from firstcontact.cli.refusals import refusals

    # What it prints holds words of the command line, and goes out as plain text like all else.
    tyro._experimental_options["ansi_codes"] = False
    with refusals(f"firstcontact {word}"):
        return tyro.cli(
            verb,
            prog=f"firstcontact {word}",
            args=arguments[1:],
            registry=option_numbers(),
        )


def _with_option(error: InputError, verb: Any) -> str:
    """Return the message of an error with the option, or the path, in place of the parameter."""
    if not error.parameter or verb is None:
        return str(error)
    field = getattr(verb, "options", {}).get(error.parameter, error.parameter)
    value = getattr(verb, field, None)
    subject = value if isinstance(value, PurePath) else f"--{field.replace('_', '-')}"
    return f"{subject}: {error.message}"


def _failed(code: int, sentence: str) -> int:
    if len(sentence) > LONGEST:  # of what was quoted; the remedy stands at the end
        sentence = f"{sentence[: LONGEST // 2]} ... {sentence[-LONGEST // 2 :]}"
    print(f"firstcontact: {one_line(sentence)}", file=sys.stderr)
    return code


def _unsaid(out: Output) -> int:
    """2 where what was printed could not be kept, though somebody wanted it."""
    if out.failed is None or out.gone:
        return DONE
    return _failed(INPUT, f"standard output: {out.failed.strerror}: what was said is not all there")


if __name__ == "__main__":
    sys.exit(main())
