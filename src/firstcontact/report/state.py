"""What a study has found so far, as ``results.json`` and the report show it."""

from __future__ import annotations

import platform
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from firstcontact.report.findings import Findings

#: Whose versions a result depends on.
PACKAGES = (
    "firstcontact",
    "numpy",
    "scipy",
    "scikit-learn",
    "torch",
    "numba",
    "onnxruntime",
    "matplotlib",
)


@dataclass(slots=True)
class State:
    """A study on its way.

    Parameters
    ----------
    command
        What was typed.
    settings
        Sizes and seeds.
    quick
        Whether it is the small form, whose numbers are not to be quoted.
    findings
        One a subject; the first is the top level of ``results.json``.
    steps
        Titles of all parts, in order.
    done
        How many of them are done.
    interrupted
        Whether it was ended from outside.
    stopped
        The part that ended it and its error, else empty.
    asked
        What the results depend on: the folder of the study is kept from others by it.
    """

    command: str
    settings: Mapping[str, Any]
    quick: bool
    findings: list[Findings]
    steps: Sequence[str]
    done: int = 0
    interrupted: bool = False
    stopped: str = ""
    began: float = field(default_factory=time.monotonic)
    started: str = field(default_factory=lambda: time.strftime("%Y-%m-%d %H:%M %Z"))
    part_seconds: dict[str, float] = field(default_factory=dict)
    asked: Mapping[str, Any] = field(default_factory=dict)

    @property
    def pending(self) -> Sequence[str]:
        """Titles of the parts that are not done."""
        return self.steps[self.done :]

    @property
    def seconds(self) -> float:
        """Time since the study began, s."""
        return time.monotonic() - self.began

    def to_json(self) -> dict[str, Any]:
        """``results.json``: the first subject at the top, others under their names."""
        first, *others = self.findings
        tree: dict[str, Any] = dict(first.tree)
        if first.left_out:
            tree["left_out"] = list(first.left_out)
        for other in others:
            tree[other.name] = dict(other.tree)
            if other.left_out:
                tree[other.name]["left_out"] = list(other.left_out)
        tree["seconds"] = round(self.seconds, 1)
        tree["part_seconds"] = {k: round(v, 1) for k, v in self.part_seconds.items()}
        tree["study"] = {
            "command": self.command,
            "condition": first.name,
            "quick": self.quick,
            "started": self.started,
            "complete": not self.pending,
            **({"stopped": self.stopped} if self.stopped else {}),
            "asked": dict(self.asked),
            "settings": dict(self.settings),
            "seed": self.settings["seed"],
        }
        tree["versions"] = versions()
        if self.pending:
            tree["pending"] = list(self.pending)
        return tree


def versions() -> dict[str, str]:
    """Versions of what results depend on, where it is there."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
