"""Options of verbs: values, errors, and names with the same meaning in all verbs."""

from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, get_args

import pytest

from firstcontact.cli import Option, choice
from firstcontact.cli.options import parse_options, verb_arguments
from firstcontact.cli.verbs import configuration, verb_places
from firstcontact.core import InputError


@dataclass(frozen=True)
class Squeeze:
    """Squeeze an object.

    Gently.
    """

    data: Annotated[tuple[Path, ...], Option(positional=True)]
    """Files to read."""
    out: Path
    """Folder to write, 100 % new."""
    force: Annotated[float | None, Option(group="hand")] = None
    """Force, N."""
    times: int = 3
    """Number of times."""
    ms: tuple[float, ...] = (15.0,)
    """Lengths, ms."""
    kind: Annotated[str, choice(("soft", "hard"))] = "soft"
    """Kind of object."""
    side: Literal["left", "right"] = "left"
    """Side of the hand."""
    slowly: Annotated[bool, Option(advanced=True)] = False
    """Close slowly."""


def parsed(*words: str) -> Squeeze:
    verb = parse_options(Squeeze, "hand squeeze", words)
    assert isinstance(verb, Squeeze)
    return verb


def test_each_kind_of_option_is_parsed() -> None:
    words = ("a", "b", "--out", "o", "--force", "1e-1", "--times", "-2", "--ms", "3", "8")
    verb = parsed(*words, "--kind", "hard", "--side=right", "--slowly")
    paths = (Path("a"), Path("b"))
    assert verb == Squeeze(paths, Path("o"), 0.1, -2, (3.0, 8.0), "hard", "right", True)


def test_what_is_left_out_is_the_default() -> None:
    assert parsed("a", "--out", "o") == Squeeze((Path("a"),), Path("o"))


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("a",), "--out"),
        (("--out", "o"), "DATA"),
        (("a", "--out"), "--out"),
        (("a", "--out", "o", "--times", "1_0"), "--times"),
        (("a", "--out", "o", "--times", "1.5"), "--times"),
        (("a", "--out", "o", "--force", "１５"), "--force"),
        (("a", "--out", "o", "--ms", "3", "x"), "--ms"),
        (("a", "--out", "o", "--side", "middle"), "--side"),
        (("a", "--out", "o", "--tims", "3"), "--tims"),
        (("a", "--out", "o", "--tim", "3"), "--tim"),  # names are not cut short
        (("a", "--out", "o", "--slowly=yes"), "--slowly"),
    ],
)
def test_an_unusable_option_is_named(words: tuple[str, ...], named: str) -> None:
    with pytest.raises(InputError) as refused:
        parsed(*words)
    assert named in str(refused.value)
    assert "hand squeeze --help" in str(refused.value)


@pytest.mark.parametrize(("option", "advanced"), [("-h", False), ("--help-all", True)])
def test_the_help_lists_options_in_groups(
    option: str, advanced: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    with pytest.raises(SystemExit) as end:
        parsed(option)
    assert not end.value.code
    text = capsys.readouterr().out
    assert ("--slowly" in text) == advanced
    for line in ("usage: hand squeeze DATA ... --out PATH [OPTIONS]", "hand:", "options:"):
        assert line in text.splitlines()
    for part in ("{soft,hard}", "{left,right}", "(default: 15)", "100 % new.", "Gently."):
        assert part in text


@pytest.mark.parametrize("verb", verb_places())
def test_the_short_help_of_a_verb_is_short(verb: str) -> None:
    listed = [a for a in verb_arguments(configuration(verb)) if not a.option.advanced]
    assert len(listed) <= 10
    for argument in listed:
        assert argument.help.endswith(".")
        # A list of what a registry holds grows with it.
        assert len(argument.help) <= 72 or argument.option.help


def test_an_option_means_the_same_in_every_verb() -> None:
    kinds: defaultdict[str, set[Any]] = defaultdict(set)
    for verb in verb_places():
        if configuration(verb).__module__.startswith(("firstcontact.", "firstcontact_lab.")):
            for argument in verb_arguments(configuration(verb)):
                # An option may be left out, or be given several times.
                several = NoneType in (parts := get_args(argument.kind)) or parts[1:] == (...,)
                kinds[argument.field.name].add(parts[0] if several else argument.kind)
    assert {name: kind for name, kind in kinds.items() if len(kind) > 1} == {}
    assert kinds["model"] == kinds["detector"] == {Path}
    assert kinds["port"] == {int}
