"""Write the pages of the Python interface in docs/reference from the docstrings.

python docs/write_api.py
"""

from __future__ import annotations

import enum
import inspect
import re
from importlib import import_module
from pathlib import Path
from types import FunctionType, ModuleType, UnionType
from typing import Any, get_args

from firstcontact.core import Registry
from firstcontact.core.text import nouns

FOLDER = Path(__file__).parent / "reference"
#: Chapters of the page for users, in the order of their work. The last takes all other names.
CHAPTERS = {
    "Load": (
        "sample simulate record import_recordings load plot Dataset Pinch Label Layout Finger "
        "Contact"
    ),
    "Adapt": "calibrate Calibration adapt train load_model Model",
    "Predict": (
        "detect predict Predictions evaluate Evaluation GroupScores closing_speed ClosingSpeed "
        "export_model"
    ),
    "Live": (
        "open Source Health live Event ClosingStart ContactEvent ContactWithdrawn Estimate "
        "NoEstimate PinchDone Verdict ObjectEstimate HandCommand PolicyCommand HandPinch "
        "HandPrediction"
    ),
    "Errors and plug-ins": "",
}
#: Rooms with a face for others, from the ground floor up.
FACES = (
    "core",
    "jobs",
    "recording",
    "signal",
    "chain",
    "contact",
    "twin",
    "grasp",
    "models",
    "export",
    "device",
    "streaming",
    "collect",
    "testing",
)
NOTE = "`docs/write_api.py` writes this page from the docstrings.\n"
USERS = f"""\
# Python for users

`import firstcontact as fc` gives these functions and types, in the order of your work: load,
adapt, predict, live. Begin with the [tutorial](../tutorial/from-python.md). [Plug-in
authors](python-plugins.md) and programs that use [parts of the package](python-rooms.md) have
pages of their own.

The examples run in a folder that holds recordings of the simulated hand:

<!-- elsewhere -->
```sh
firstcontact simulate --out recordings --pinches-per-block 12 --pinches-per-object 0
```

- Functions raise `fc.InputError` for input that they cannot use. Its `parameter` names the
  parameter. The subclasses `ArgumentError`, `FileError`, `DeviceError` and `ModelError` say what
  failed.
- Functions that take a while have a parameter `progress`. True shows a bar. A function is called
  with the number of steps that were just finished.
- The names on these three pages follow semantic versioning. All other names are private.

{NOTE}"""
PLUGINS = f"""\
# Python for plug-in authors

`from firstcontact import plugins` gives three things: the classes from which you derive a detector,
estimator, policy, hand, source or file format; the registries that hold them; and the checks that
they must pass. `CONTRIBUTING.md` has an example of each.

{NOTE}"""
ROOMS = f"""\
# Python: other names

Programs that build on parts of the package import these names from a *room*, a subpackage: `from
firstcontact.contact import detect`.

{NOTE}"""
#: Sections of a docstring that the page shows, and their title there.
TITLES = {
    "Parameters": "Parameters",
    "Attributes": "Attributes",
    "Returns": "Returns",
    "Yields": "Yields",
    "Raises": "Errors",
}


def sections(text: str) -> dict[str, str]:
    """Split a docstring into its sections; "" is the part before the first heading."""
    parts = re.split(r"^(\w[\w ]*)\n-{3,}\n", inspect.cleandoc(text), flags=re.MULTILINE)
    return dict(zip(["", *parts[1::2]], parts[0::2], strict=True))


def prose(text: str) -> str:
    """Convert the markup of docstrings to Markdown, one line per paragraph."""
    text = re.sub(r":\w+:`[~.]?([^`]*)`", r"`\1`", text).replace("``", "`")
    return "\n\n".join(" ".join(part.split()) for part in text.strip().split("\n\n"))


def summary(subject: Any) -> str:
    """Return the first paragraph of a docstring."""
    if isinstance(subject, Registry):
        return f"All {nouns(2, subject.kind)} by name, including plug-ins."
    if isinstance(subject, dict):
        return f"By name: {', '.join(f'`{name}`' for name in subject)}."
    if isinstance(subject, UnionType):
        return f"One of {', '.join(f'`{kind.__name__}`' for kind in get_args(subject))}."
    return prose(sections(subject.__doc__ or "")[""]).split("\n\n")[0]


def entries(text: str) -> list[str]:
    """List the names and descriptions of a section as items of a page."""
    items = []
    for entry in re.split(r"\n(?=\S)", text.strip("\n")):
        name, _, described = entry.partition("\n")
        names = ", ".join(f"`{part.strip()}`" for part in name.split(","))
        items.append(f"- {names}: {prose(described)}".rstrip(": "))
    return items


def signature(name: str, subject: Any) -> str:
    """Return the signature of a function or class with types; "" if it is not callable."""
    if is_enum(subject):
        return ""
    if inspect.isclass(subject) and (
        getattr(subject, "_is_protocol", False) or inspect.isabstract(subject)
    ):
        return ""
    try:
        called = inspect.signature(subject)
    except (TypeError, ValueError):
        return ""
    # Types are shown as the module writes them, not resolved.
    parameters = [p.replace(annotation=_type(p.annotation)) for p in called.parameters.values()]
    lines = [f"{_parameter(p)}," for p in parameters]
    starred = next((k for k, p in enumerate(parameters) if p.kind is p.KEYWORD_ONLY), None)
    if starred is not None:
        lines.insert(starred, "*,")
    returned = called.return_annotation
    result = "" if inspect.isclass(subject) else f" -> {_type(returned)}"
    short = f"{name}({' '.join(lines).rstrip(',')}){result}"
    if len(short) <= 96:
        return short
    return "\n".join([f"{name}(", *(f"    {line}" for line in lines), f"){result}"])


def is_enum(subject: Any) -> bool:
    """Return True for an enumeration."""
    return inspect.isclass(subject) and issubclass(subject, enum.Enum)


def _type(annotation: Any) -> str:
    if annotation is inspect.Parameter.empty:
        return ""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return text.replace("firstcontact.core.files.", "")


def _parameter(parameter: inspect.Parameter) -> str:
    text = (
        parameter.name if not parameter.annotation else f"{parameter.name}: {parameter.annotation}"
    )
    if parameter.default is inspect.Parameter.empty:
        return text
    default = repr(parameter.default)
    # Objects without a literal, and sets of them, whose order is random, are not shown.
    default = "..." if "<" in default else default
    return f"{text} = {default}"


def described(name: str, subject: Any) -> list[str]:
    """Return the lines about one public name."""
    lines = [f"### {name}", ""]
    if isinstance(subject, Registry):
        names = ", ".join(f"`{entry}`" for entry in subject.builtin_names)
        lines += [f"{summary(subject)} Built in: {names}.", ""]
        return lines
    if isinstance(subject, UnionType | dict | ModuleType):
        return [*lines, summary(subject), ""]
    if called := signature(name, subject):
        lines += ["```text", called, "```", ""]
    parts = sections(subject.__doc__ or "")
    lines += [prose(parts[""]), ""]
    if is_enum(subject):
        lines += [f"Members: {', '.join(f'`{member.name}`' for member in subject)}.", ""]
    for section, title in TITLES.items():
        if section in parts:
            lines += [f"{title}:", "", *entries(parts[section]), ""]
    if inspect.isclass(subject) and not is_enum(subject):
        listed = fields(subject, "\n".join(lines))
        lines += ["Attributes:", "", *listed, ""] if listed else []
        listed = members(subject, "\n".join(lines))
        lines += ["Members:", "", *listed, ""] if listed else []
    if "Examples" in parts:
        lines += ["```pycon", parts["Examples"].strip(), "```", ""]
    return lines


def fields(kind: type, documented: str) -> list[str]:
    """List the attributes of a class that comments of its source describe."""
    lines = []
    for base in kind.__mro__:
        if not base.__module__.startswith("firstcontact"):
            continue
        comments = r"((?:^    #: .*\n)+)    (\w+): "
        for comment, name in re.findall(comments, inspect.getsource(base), re.MULTILINE):
            text = re.sub(r"^ *#: ", "", comment, flags=re.MULTILINE)
            if not name.startswith("_") and f"- `{name}`" not in documented + "\n".join(lines):
                lines.append(f"- `{name}`: {prose(text)}")
    return lines


def members(kind: type, documented: str) -> list[str]:
    """List methods and properties of a class with their first sentences."""
    lines = []
    for name in dir(kind):
        subject = inspect.getattr_static(kind, name)
        is_method = isinstance(subject, FunctionType | classmethod | staticmethod)
        if name.startswith("_") or not (is_method or isinstance(subject, property)):
            continue
        function: Any = subject.fget if isinstance(subject, property) else getattr(kind, name)
        described = subject if isinstance(subject, property) else function
        parts = sections(inspect.getdoc(described) or "")
        if not function.__module__.startswith("firstcontact") or f"`{name}`" in documented:
            continue
        called = ""
        if is_method:
            names = [p for p in inspect.signature(function).parameters if p != "self"]
            called = f"({', '.join(names)})"
        lines.append(f"- `{name}{called}`: {prose(parts['']).split(chr(10))[0]}".rstrip(": "))
        if is_method and "Parameters" in parts:
            lines += [f"    {entry}" for entry in entries(parts["Parameters"])]
    return lines


def example(module: ModuleType) -> str:
    """Return the example of a module as a fence; "" without one."""
    parts = sections(module.__doc__ or "")
    return f"```pycon\n{parts['Examples'].strip()}\n```\n" if "Examples" in parts else ""


def chapter(module: ModuleType, words: list[str]) -> str:
    """Return signature, description, members and example of names of a module."""
    return "\n".join(line for word in words for line in described(word, getattr(module, word)))


def room(name: str) -> str:
    """Return the table of the public names of a room."""
    full = f"firstcontact.{name}"
    module = import_module(full)
    rows = [f"| `{word}` | {summary(getattr(module, word))} |" for word in module.__all__]
    head = f"## {full}\n\n{summary(module)}\n\n| name | |\n|---|---|\n"
    return head + "\n".join(rows) + "\n"


def public_names() -> dict[str, list[str]]:
    """Return the public names by module, functions first."""
    names = {}
    for name in ("firstcontact", "firstcontact.plugins"):
        module = import_module(name)
        words = set(module.__all__) | ({"open"} if name == "firstcontact" else set())
        functions = {word for word in words if inspect.isfunction(getattr(module, word))}
        names[name] = [*sorted(functions), *sorted(words - functions)]
    return names


def users() -> str:
    """Return the page for users."""
    module = import_module("firstcontact")
    words = public_names()["firstcontact"]
    chosen = {title: names.split() for title, names in CHAPTERS.items()}
    placed = {name for names in chosen.values() for name in names}
    chosen[list(chosen)[-1]] += [word for word in words if word not in placed]
    texts = (
        f"## {title}\n\n{chapter(module, [name for name in names if name in words])}"
        for title, names in chosen.items()
    )
    return "\n".join([USERS, example(module), *texts])


def plugins() -> str:
    """Return the page for authors of plug-ins."""
    module = import_module("firstcontact.plugins")
    words = public_names()[module.__name__]
    return "\n".join([PLUGINS, example(module), "## Names\n", chapter(module, words)])


def pages() -> dict[str, str]:
    """Return the text of each page by its file."""
    return {
        "python.md": users(),
        "python-plugins.md": plugins(),
        "python-rooms.md": "\n".join([ROOMS, *map(room, FACES)]),
    }


if __name__ == "__main__":
    for file, text in pages().items():
        (FOLDER / file).write_text(text, encoding="utf-8")
