"""Options of verbs: the fields of a verb's dataclass become a command line through argparse."""

from __future__ import annotations

import argparse
import ast
import inspect
import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import MISSING, Field, dataclass, fields
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from textwrap import dedent, fill
from types import NoneType
from typing import Annotated, Any, Literal, NoReturn, get_args, get_origin, get_type_hints

from firstcontact.core import InputError, Registry, parse_float, parse_int

#: Default group of options.
GENERAL_GROUP = "options"
#: Largest column at which help texts begin.
INDENT = 28


@dataclass(frozen=True, kw_only=True, slots=True)
class Option:
    """Properties of an option that its field's type and docstring cannot express.

    Attributes
    ----------
    group
        Title under which the help lists the option.
    advanced
        True to list it only in ``--help-all``.
    positional
        True for an argument without a name.
    names
        Allowed names, which the help lists. The verb itself refuses other names.
    help
        Text in place of the field's docstring.
    """

    group: str = GENERAL_GROUP
    advanced: bool = False
    positional: bool = False
    names: tuple[str, ...] = ()
    help: str = ""


#: Condition of the twin: like the published set-up, or like everyday use.
Condition = Annotated[Literal["paper-rig", "everyday"], Option(group="simulated hand")]


@dataclass(frozen=True)
class Argument:
    """One option, or one positional argument, of a verb."""

    field: Field[Any]
    kind: Any
    option: Option
    help: str

    @property
    def flag(self) -> str:
        """Return the name on the command line; empty for a positional argument."""
        if self.option.positional:
            return ""
        return f"--{self.field.name.replace('_', '-')}"

    @property
    def choices(self) -> tuple[str, ...]:
        """Return the allowed values; empty if the values are not listed."""
        kind = _without_none(self.kind)
        return get_args(kind) if get_origin(kind) is Literal else self.option.names

    @property
    def required(self) -> bool:
        """Return True if the verb does not run without this argument."""
        return self.field.default is MISSING and self.field.default_factory is MISSING

    @property
    def metavar(self) -> str:
        """Return the placeholder of the value in the help; for a positional argument, its name."""
        if self.option.positional:
            return self.field.name.upper()
        kind = _without_none(self.kind)
        if get_origin(kind) is tuple:
            kind = get_args(kind)[0]
        names = "{" + ",".join(self.choices) + "}"
        return names if self.choices else {str: "TEXT"}.get(kind, kind.__name__.upper())

    def declare(self, parser: Any, *, hidden: bool) -> None:
        """Add the option to a parser or to an option group. If ``hidden``, the help omits it."""
        text = (
            argparse.SUPPRESS if hidden else (self.help + self._default_text()).replace("%", "%%")
        )
        name = self.field.name
        if self.kind is bool:
            parser.add_argument(self.flag, dest=name, action="store_true", help=text)
            return
        kind = _without_none(self.kind)
        settings: dict[str, Any] = {"help": text, "metavar": self.metavar}
        if get_origin(kind) is tuple:
            settings["nargs"], kind = "+", get_args(kind)[0]
        if get_origin(kind) is Literal:
            settings["choices"], kind = self.choices, str
        settings["type"] = _PARSERS.get(kind, kind)
        if not self.required:
            settings["default"] = self.field.default
        if self.option.positional:
            settings |= {} if self.required else {"nargs": "?"}
            parser.add_argument(name, **settings)
        else:
            parser.add_argument(self.flag, dest=name, required=self.required, **settings)

    def _default_text(self) -> str:
        default = self.field.default
        if self.required or default in (None, "", ()) or isinstance(default, bool):
            return ""
        values = default if isinstance(default, tuple) else (default,)
        return f" (default: {' '.join(_text(value) for value in values)})"


def parse_options(verb: type[Any], prog: str, words: Sequence[str]) -> Any:
    """Return the verb with the options in these words."""
    parser = _parser(verb, prog, every="--help-all" in words)
    former = getattr(verb, "former", {})
    for word in words:
        if (name := word.partition("=")[0]) in former:
            parser.error(f"{name} is now {former[name]}")
    values, unknown_words = parser.parse_known_args(words)
    if unknown_words:
        _refuse_unknown(parser, verb, unknown_words)
    return verb(**{k: tuple(v) if isinstance(v, list) else v for k, v in vars(values).items()})


def verb_arguments(verb: type[Any]) -> list[Argument]:
    """Return the options and positional arguments of a verb, in the order of its fields."""
    hints = get_type_hints(verb, include_extras=True)
    texts = _field_texts(verb)
    arguments = []
    for field in fields(verb):
        hint, *extras = (
            get_args(hints[field.name])
            if get_origin(hints[field.name]) is Annotated
            else (hints[field.name],)
        )
        option = next((extra for extra in extras if isinstance(extra, Option)), Option())
        text = option.help or texts.get(field.name, "")
        arguments.append(Argument(field, hint, option, text))
    return arguments


def choice(
    names: Iterable[str] | Registry[Any], group: str = GENERAL_GROUP, advanced: bool = False
) -> Option:
    """Return an option that takes one of ``names``. Plug-ins are listed but not imported."""
    # Iterating a registry would import every plug-in.
    listed = names.names if isinstance(names, Registry) else names
    return Option(names=tuple(listed), group=group, advanced=advanced)


def devices(recorded: bool = True, more: str = "") -> Option:
    """Return an option that takes a device and, if ``recorded``, also a recording."""
    from firstcontact.device import SOURCES

    kinds = [SOURCES[name] for name in SOURCES.builtin_names]
    titles = [kind.title for kind in kinds if recorded or not kind.recorded]
    # The title of a plug-in is in its module, which is not imported for help.
    titles += [
        f"{name}:... of a plug-in" for name in SOURCES.names if name not in SOURCES.builtin_names
    ]
    *first, last = titles
    text = f"{', '.join(first)}, or {last}."
    return Option(group="device", help=text[0].upper() + text[1:] + more)


class _Parser(argparse.ArgumentParser):
    """Argument parser that raises errors instead of printing them and ending the process."""

    def error(self, message: str) -> NoReturn:
        sentence = message.removeprefix("argument ")
        raise InputError(f"{sentence}; all options: `{self.prog} --help-all`")


def _parser(verb: type[Any], prog: str, *, every: bool) -> _Parser:
    """Return the parser of a verb. Its help lists advanced options only if ``every`` is true."""
    arguments = verb_arguments(verb)
    width = shutil.get_terminal_size().columns - 2
    required = [a for a in arguments if a.required and a.flag]
    usage = [prog, *(_positional_usage(a) for a in arguments if not a.flag)]
    usage += [f"{a.flag} {a.metavar}" for a in required]
    parser = _Parser(
        prog=prog,
        usage=f"{' '.join(usage)} [OPTIONS]",
        description="\n\n".join(
            fill(" ".join(paragraph.split()), width)
            for paragraph in inspect.cleandoc(verb.__doc__ or "").split("\n\n")
        ),
        formatter_class=partial(
            argparse.RawDescriptionHelpFormatter, max_help_position=INDENT, width=width
        ),
        allow_abbrev=False,
        add_help=False,
    )
    groups: dict[str, Any] = {"arguments": parser.add_argument_group("arguments")}
    for argument in arguments:
        title = argument.option.group if argument.flag else "arguments"
        if title not in groups:
            groups[title] = parser.add_argument_group(title)
        argument.declare(groups[title], hidden=argument.option.advanced and not every)
    help_ = parser.add_argument_group("help")
    help_.add_argument("-h", "--help", action="help", help="Print this text.")
    help_.add_argument("--help-all", action="help", help="Print all options.")
    return parser


def _positional_usage(argument: Argument) -> str:
    several = " ..." if get_origin(argument.kind) is tuple else ""
    return f"{argument.metavar}{several}" if argument.required else f"[{argument.metavar}]"


def _refuse_unknown(parser: _Parser, verb: type[Any], unknown_words: list[str]) -> NoReturn:
    """Raise InputError for words that belong to no option; the message names the nearest option."""
    flags = {a.flag: a for a in verb_arguments(verb) if a.flag}
    for word in unknown_words:
        name = word.partition("=")[0]
        if name.startswith("-"):
            near = get_close_matches(name, flags, n=1)
            guess = f": perhaps you meant {near[0]}" if near else ""
            parser.error(f"{name} is not an option{guess}")
    parser.error(f"{unknown_words[0]!r} belongs to no option")


def _field_texts(verb: type[Any]) -> dict[str, str]:
    """Return the docstring below each field; nothing if the source code is not available."""
    try:
        body = ast.parse(dedent(inspect.getsource(verb))).body[0]
    except (OSError, TypeError, SyntaxError):
        return {}
    assert isinstance(body, ast.ClassDef)
    texts = {}
    for statement, following in zip(body.body, body.body[1:], strict=False):
        match statement, following:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(
                value=ast.Constant(value=str(text))
            ):
                texts[name] = " ".join(text.split())
    return texts


def _without_none(kind: Any) -> Any:
    """Return the type X of ``X | None``, and any other type unchanged."""
    parts = [part for part in get_args(kind) if part is not NoneType]
    return parts[0] if NoneType in get_args(kind) else kind


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _number(parse: Callable[[str], float]) -> Callable[[str], float]:
    def parsed(word: str) -> float:
        try:
            return parse(word)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{word!r}, {error}") from None

    return parsed


#: Parsers of numbers, as for files. A speed may be infinite.
_PARSERS: dict[Any, Callable[[str], Any]] = {
    int: _number(parse_int),
    float: _number(partial(parse_float, finite=False)),
    Path: Path,
    str: str,
}
