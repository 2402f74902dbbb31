"""The headers say for each argument of each function whether it goes in or out."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ["src/firstcontact/c/chain", "src/firstcontact/c/wire", "firmware/[cmnp]*"]
HEADERS = [path for folder in FOLDERS for path in sorted(ROOT.glob(f"{folder}/*.h"))]
#: A comment with the functions, or pointers to functions, that follow it without an empty line.
GROUP = re.compile(r"/\*((?:(?!\*/).)*)\*/\n((?:[ \w*]+\(\*?[^;{}]*\);\n)+)", re.DOTALL)
FUNCTION = re.compile(r"(\w+)\)?\(([^()]*)\);")
DECLARED = re.compile(r"^ *(?:\w+ )+[*(]*(\w+)\)?\((?!void\))[^(){}]*\);", re.MULTILINE)
#: Arguments that a function cannot write, and those that it could write and need not.
READ = re.compile(r"(const (struct )?\w+ \*)?\w+|[\w ]+ \w+")
OPEN = re.compile(r"(const )?void \*\w+")


@pytest.mark.parametrize("header", HEADERS, ids=lambda path: path.name)
def test_each_argument_has_a_line_with_its_direction(header: Path) -> None:
    text = header.read_text(encoding="utf-8")
    described = set()
    for comment, group in GROUP.findall(text):
        for function, arguments in FUNCTION.findall(group):
            described.add(function)
            for argument in re.split(r",\s*", arguments):
                name = re.findall(r"\w+(?=\[|$)", argument)[0]
                line = re.search(
                    rf"^ +(?:\w+, )*{name}(?:, \w+)* +(in, out|in|out)\b", comment, re.M
                )
                assert line or name == "void", f"{function}: {name}"
                if line and not OPEN.fullmatch(argument):
                    assert (line[1] == "in") == bool(READ.fullmatch(argument)), (
                        f"{function}: {name}"
                    )
    assert set(DECLARED.findall(text)) <= described
