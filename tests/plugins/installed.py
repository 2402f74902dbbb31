"""Programs that run with the example plug-in installed."""

from __future__ import annotations

import subprocess

import forked


def run(environment: dict[str, str], *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run Python code with these arguments."""
    return forked.run("code", *arguments, env=environment)


def firstcontact(
    environment: dict[str, str], *arguments: object
) -> subprocess.CompletedProcess[str]:
    """Run the command line."""
    return forked.firstcontact(*arguments, env=environment)
