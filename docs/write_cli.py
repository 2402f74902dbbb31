"""Write docs/reference/cli.md from the help of each verb.

python docs/write_cli.py
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from firstcontact.cli.verbs import verb_places

PAGE = Path(__file__).parent / "reference" / "cli.md"
HEAD = """\
# Command line

`docs/write_cli.py` writes this page from `--help-all`, and a test compares them.

[Exit codes and logs](endings.md).
"""

#: Program that runs the command without installed plug-ins.
ALONE = """
import sys
from firstcontact.core import Registry
Registry._find_plugins = lambda self: {}
from firstcontact.cli.main import main
sys.argv[0] = "firstcontact"
sys.exit(main(sys.argv[1:]))
"""


def help_text(*arguments: str) -> str:
    """Return the ``--help-all`` of a command, 96 columns wide, without colours."""
    option = "--help-all" if arguments else "--help"
    command = [sys.executable, "-c", ALONE, *arguments, option]
    environment = {
        **os.environ,
        "COLUMNS": "96",
        "NO_COLOR": "1",
        "TERM": "dumb",
        "PYTHONIOENCODING": "utf-8",
    }
    process = subprocess.run(
        command, capture_output=True, text=True, check=True, env=environment, encoding="utf-8"
    )
    return "\n".join(line.rstrip() for line in process.stdout.strip().splitlines())


def page() -> str:
    """Return the page."""
    parts = [HEAD, f"```text\n{help_text()}\n```\n"]
    parts += [f"## {verb}\n\n```text\n{help_text(verb)}\n```\n" for verb in verb_places()]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
