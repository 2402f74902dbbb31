"""Documentation pages, and the commands in them."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "CHANGELOG.md",
        *ROOT.glob("docs/**/*.md"),
    ]
)
FENCE = re.compile(
    r"^(?:<!-- (?P<mark>[a-z]+) -->\n)?"
    r"(?P<tick>```+)(?P<language>[\w-]*)\n(?P<body>.*?)^(?P=tick)$",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Fence:
    """Fenced code block of a page."""

    page: Path
    line: int
    mark: str
    language: str
    body: str

    @property
    def commands(self) -> list[str]:
        """Commands of the block: continued lines joined, no comments."""
        lines = self.body.replace("\\\n", " ").splitlines()
        return [" ".join(x.split()) for x in lines if x.strip() and not x.startswith("#")]


def fences(page: Path) -> list[Fence]:
    """Return the fenced blocks of a page in order."""
    text = page.read_text(encoding="utf-8")
    return [
        Fence(page, text[: m.start()].count("\n") + 1, m["mark"] or "", m["language"], m["body"])
        for m in FENCE.finditer(text)
    ]


def name(page: Path) -> str:
    """Return the name of a page for test output."""
    return page.relative_to(ROOT).as_posix()
