"""The verbs: where each is, and what it is for. Importing this imports none of them."""

from __future__ import annotations

from importlib import import_module
from typing import Any, NamedTuple


class Verb(NamedTuple):
    """A verb of the command.

    Parameters
    ----------
    name
        Of the dataclass that is its configuration.
    summary
        The first line of what that says of itself.
    """

    name: str
    summary: str


VERBS = {
    "live": Verb(
        "Live",
        "Show contacts and stiffness as they happen: in the terminal, on a page, to other "
        "programs.",
    ),
    "calibrate": Verb(
        "Calibrate", "Measure noise floors, taps and the Velostat curve of a pair of fingertips."
    ),
    "record": Verb(
        "Record", "Record labelled pinches: the hand closes, the terminal says which ones count."
    ),
    "camera": Verb(
        "Camera", "Compare the strips' contacts with those that a high-speed camera saw."
    ),
    "ports": Verb(
        "Ports", "List serial ports and sound inputs, and say which of them may be a fingertip."
    ),
    "info": Verb(
        "Info",
        "Print versions and ports for a bug report, or what a device says about itself.",
    ),
    "replay": Verb(
        "Replay", "Make a recording a live device: a port that this or any other program can open."
    ),
    "simulate": Verb(
        "Simulate", "Make recordings of simulated pinches: five blocks and eight everyday objects."
    ),
    "import": Verb("Import", "Turn what others have into recordings."),
    "label": Verb(
        "Label",
        "Confirm on a page, by keyboard, where contacts are; the originals stay as they are.",
    ),
    "inspect": Verb("Inspect", "Say what is in a recording, and draw a pinch of it."),
    "export": Verb("Export", "Write the pinches of recordings for other tools."),
    "train": Verb(
        "Train",
        'Learn stiffness models from the pinches of role "train"; save them with a detector.',
    ),
    "adapt": Verb(
        "Adapt",
        "Make a model that answers at any time after a contact, from a few pinches of known "
        "things.",
    ),
    "pretrain": Verb(
        "Pretrain", "Make the network of the any-time model anew, from simulated rigs."
    ),
    "export-model": Verb(
        "ExportModel",
        "Write a trained model as C, as ONNX, or as what a hand is flashed with.",
    ),
    "flash-model": Verb(
        "FlashModel",
        "Send a model to a device that answers by itself: it is kept whole, or not at all.",
    ),
    "evaluate": Verb(
        "Evaluate", "Score a saved model, an any-time one from 2 to 15 ms after the contact."
    ),
    "study": Verb(
        "Study",
        "Do every experiment that the data permit and write report.html and results.json.",
    ),
    "sets": Verb(
        "Sets",
        "Hold the detectors against several real sets, and put what was found of them on one page.",
    ),
    "benchmark": Verb(
        "Benchmark",
        "Ask a regressor, the default one and the in-context network the same about simulated "
        "rigs.",
    ),
    "grasp-study": Verb(
        "GraspStudy",
        "Pick up a household with the twin's hands and every policy; write report and results.",
    ),
}

#: Options that stand in place of a verb.
GENERAL = ("--help", "--version", "--completion")


def configuration(verb: str) -> type[Any]:
    """The dataclass of a verb; imports its module."""
    module = "import_" if verb == "import" else verb.replace("-", "_")
    found: type[Any] = getattr(import_module(f"firstcontact.cli.{module}"), VERBS[verb].name)
    return found


def overview(width: int) -> str:
    """What ``firstcontact --help`` prints, in lines of at most so many characters."""
    from textwrap import wrap

    import firstcontact

    indent = " " * (max(map(len, VERBS)) + 4)
    lines = ["usage: firstcontact [--verbose] VERB [OPTIONS]", "", firstcontact.__doc__ or "", ""]
    for verb, (_, summary) in VERBS.items():
        first, *more = wrap(summary, max(width - len(indent), 20))
        lines += [f"  {verb}".ljust(len(indent)) + first, *(indent + line for line in more)]
    lines += ["", "What each takes: firstcontact VERB --help"]
    lines += ["What it does meanwhile, on standard error: --verbose"]
    return "\n".join([*lines, "Its version: --version; Tab in bash and zsh: --completion"])
