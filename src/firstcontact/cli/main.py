"""The ``firstcontact`` command: finds the verb and turns errors into one sentence."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

from firstcontact.core.errors import InputError

#: Verb to the dataclass that is its configuration; one file a verb.
VERBS = {
    "live": "Live",
    "calibrate": "Calibrate",
    "record": "Record",
    "camera": "Camera",
    "ports": "Ports",
    "info": "Info",
    "replay": "Replay",
    "simulate": "Simulate",
    "import": "Import",
    "inspect": "Inspect",
    "export": "Export",
    "train": "Train",
    "evaluate": "Evaluate",
    "study": "Study",
    "grasp-study": "GraspStudy",
}


def _module(verb: str) -> str:
    return "import_" if verb == "import" else verb.replace("-", "_")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb.

    Returns
    -------
    int
        0 done, 2 the input cannot be used, 130 interrupted.
    """
    import tyro

    verbs = {
        verb: getattr(import_module(f"firstcontact.cli.{_module(verb)}"), name)
        for verb, name in VERBS.items()
    }
    verb = tyro.extras.subcommand_cli_from_dict(
        verbs, prog="firstcontact", description=__import__("firstcontact").__doc__, args=arguments
    )
    try:
        verb.run()
    except InputError as error:
        print(f"firstcontact: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("firstcontact: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        return 0
    except OSError as error:
        # A path that cannot be read or written is the user's to mend, wherever it shows up.
        if error.filename is None:
            raise
        print(f"firstcontact: {error.filename}: {error.strerror}: check this path", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
