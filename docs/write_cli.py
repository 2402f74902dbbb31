"""Write the help of each command into docs/reference/cli.md.

python docs/write_cli.py
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).parent / "reference" / "cli.md"
START = "<!-- commands: docs/write_cli.py writes them from --help-all -->\n"
END = "<!-- /commands -->\n"

#: Program that prints the help of each verb as JSON, without installed plug-ins.
HELP = """
import contextlib, io, json, sys
from firstcontact.core import Registry
Registry._find_plugins = lambda self: {}
from firstcontact.cli.main import main
from firstcontact.cli.verbs import verb_places

def help_text(*arguments):
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        main(list(arguments))
    return "\\n".join(line.rstrip() for line in text.getvalue().strip().splitlines())

texts = {verb: help_text(verb, "--help-all") for verb in verb_places()}
json.dump({"": help_text("--help"), **texts}, sys.stdout)
"""


def page(text: str) -> str:
    """Return the page with the help of each verb, 96 columns wide, without colours."""
    environment = {**os.environ, "COLUMNS": "96", "NO_COLOR": "1", "TERM": "dumb"}
    process = subprocess.run(
        [sys.executable, "-c", HELP], capture_output=True, check=True, env=environment
    )
    overview, *texts = json.loads(process.stdout).items()
    parts = [f"```text\n{overview[1]}\n```\n"]
    parts += [f"## {verb}\n\n```text\n{text}\n```\n" for verb, text in texts]
    head, _, rest = text.partition(START)
    return "\n".join([head + START, *parts, END + rest.partition(END)[2]])


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
