"""Options of commands: the fields of a command's dataclass, parsed by argparse."""

from __future__ import annotations

import argparse
import ast
import inspect
import shutil
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import MISSING, Field, dataclass, fields
from functools import partial
from textwrap import dedent, fill
from types import NoneType
from typing import Annotated, Any, Literal, NoReturn, get_args, get_origin, get_type_hints

from firstcontact.core import ArgumentError, Registry
from firstcontact.core.installation import require_modules
from firstcontact.core.text import parse_float, parse_int

#: Default group of options.
GENERAL_GROUP = "options"
#: Largest column at which help texts begin.
INDENT = 28


@dataclass(frozen=True, kw_only=True, slots=True)
class Option:
    """Properties of a command-line option, for ``Annotated`` at a field of a command's dataclass.

    Attributes
    ----------
    group
        Title of the group in which the help lists the option.
    advanced
        True to list the option only in ``--help-all``, not in ``--help``.
    positional
        True for an argument that is given by position, without ``--name``.
    names
        Allowed values, which the help lists. The command itself must refuse other values.
    help
        Help text that replaces the field's docstring.
    """

    group: str = GENERAL_GROUP
    advanced: bool = False
    positional: bool = False
    names: tuple[str, ...] = ()
    help: str = ""


#: Condition of the twin: like the published set-up, or like everyday use.
Condition = Annotated[Literal["paper-rig", "everyday"], Option(group="simulated hand")]


class Argument:
    """Option or positional argument of a command, as the field of a dataclass defines it."""

    def __init__(self, field: Field[Any], hint: Any, text: str) -> None:
        kind, *extras = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        self.field = field
        self.kind = kind
        self.option = next((extra for extra in extras if isinstance(extra, Option)), Option())
        self.help = self.option.help or text
        self.flag = "" if self.option.positional else f"--{field.name.replace('_', '-')}"
        self.required = field.default is MISSING and field.default_factory is MISSING
        parts = [part for part in get_args(kind) if part is not NoneType]
        inner = parts[0] if NoneType in get_args(kind) else kind
        self.several = get_origin(inner) is tuple
        #: Type of one value.
        self.single = get_args(inner)[0] if self.several else inner
        is_literal = get_origin(self.single) is Literal
        self.choices = get_args(self.single) if is_literal else self.option.names

    @property
    def metavar(self) -> str:
        """Placeholder of an option's value in the help; the name of a positional argument."""
        if self.option.positional:
            return self.field.name.upper()
        if self.choices:
            return "{" + ",".join(self.choices) + "}"
        return "TEXT" if self.single is str else str(self.single.__name__).upper()

    @property
    def usage(self) -> str:
        if self.flag:
            return f"{self.flag} {self.metavar}"
        several = " ..." if self.several else ""
        return f"{self.metavar}{several}" if self.required else f"[{self.metavar}]"

    def declare(self, parser: Any, *, hidden: bool) -> None:
        """Add the option to a parser or to an option group. If ``hidden``, the help omits it."""
        text = (self.help + self._default_text()).replace("%", "%%")
        settings: dict[str, Any] = {"help": argparse.SUPPRESS if hidden else text}
        name = self.field.name
        if self.kind is bool:
            parser.add_argument(self.flag, dest=name, action="store_true", **settings)
            return
        settings |= {"metavar": self.metavar, "type": _PARSERS.get(self.single, self.single)}
        if get_origin(self.single) is Literal:
            settings |= {"choices": self.choices, "type": str}
        if self.several:
            settings["nargs"] = "+"
        if not self.required:
            settings["default"] = self.field.default
        if self.flag:
            parser.add_argument(self.flag, dest=name, required=self.required, **settings)
        else:
            parser.add_argument(name, **settings, **({} if self.required else {"nargs": "?"}))

    def _default_text(self) -> str:
        default = self.field.default
        if self.required or default in (None, "", ()) or isinstance(default, bool):
            return ""
        values = default if isinstance(default, tuple) else (default,)
        words = (f"{value:g}" if isinstance(value, float) else str(value) for value in values)
        return f" (default: {' '.join(words)})"


def parse_options(verb: type[Any], prog: str, words: Sequence[str]) -> Any:
    parser = _parser(verb, prog, every="--help-all" in words)
    values = vars(parser.parse_args(words))
    return verb(**{k: tuple(v) if isinstance(v, list) else v for k, v in values.items()})


def verb_arguments(verb: type[Any]) -> list[Argument]:
    """Return the options and positional arguments of a command, in the order of its fields."""
    hints = get_type_hints(verb, include_extras=True)
    texts = _field_texts(verb)
    return [Argument(f, hints[f.name], texts.get(f.name, "")) for f in fields(verb)]


def choice(
    names: Iterable[str] | Registry[Any], group: str = GENERAL_GROUP, advanced: bool = False
) -> Option:
    """Return an option whose value is one of ``names``.

    The help lists names from plug-ins, too, without importing these.
    """
    # Iterating a registry would import every plug-in.
    listed = names.names if isinstance(names, Registry) else names
    return Option(names=tuple(listed), group=group, advanced=advanced)


def on_cluster(cluster: str | None) -> AbstractContextManager[None]:
    """Return a context manager that moves heavy computing in its block to a cluster.

    ``cluster`` is the address of the scheduler. If it is None, this computer computes.

    Raises
    ------
    InputError
        The packages for clusters are not installed. Or, raised by ``with``: the cluster fails.
    """
    if cluster is None:
        return nullcontext()
    require_modules("cluster", "distributed")
    from firstcontact.jobs import use_cluster

    return use_cluster(cluster)


def devices(recorded: bool = True, more: str = "") -> Option:
    """Return an option for a device. It also takes a recording if ``recorded``.

    ``more`` is added to the help text.
    """
    from firstcontact.device import SOURCES

    kinds = [SOURCES[name] for name in SOURCES.builtin_names]
    titles = [kind.title for kind in kinds if recorded or not kind.is_replay]
    # The title of a plug-in is in its module, which is not imported for help.
    titles += [
        f"{name}:... of a plug-in" for name in SOURCES.names if name not in SOURCES.builtin_names
    ]
    *first, last = titles
    text = f"{', '.join(first)}, or {last}."
    return Option(group="device", help=text[0].upper() + text[1:] + more)


class _Parser(argparse.ArgumentParser):
    """Argument parser that raises ArgumentError instead of ending the process."""

    def error(self, message: str) -> NoReturn:
        sentence = message.removeprefix("argument ")
        raise ArgumentError(f"{sentence}; all options: `{self.prog} --help-all`")


def _parser(verb: type[Any], prog: str, *, every: bool) -> _Parser:
    """Return the parser for the options of a command, which is the dataclass ``verb``.

    With ``every``, its help lists advanced options, too. ``prog`` is the command as typed, for the
    help.
    """
    arguments = verb_arguments(verb)
    width = shutil.get_terminal_size().columns - 2
    # Positional arguments first, then the required options.
    usage = [a.usage for a in arguments if not a.flag]
    usage += [a.usage for a in arguments if a.flag and a.required]
    paragraphs = inspect.cleandoc(verb.__doc__ or "").split("\n\n")
    parser = _Parser(
        prog=prog,
        usage=" ".join([prog, *usage, "[OPTIONS]"]),
        description="\n\n".join(fill(" ".join(p.split()), width) for p in paragraphs),
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


def _field_texts(verb: type[Any]) -> dict[str, str]:
    """Return the docstring of each field of a command's class, by the field's name.

    Return {} if Python cannot read the source code of the class.
    """
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
}
