"""The page's own files, read once: what is not in this table does not exist."""

from __future__ import annotations

from importlib.resources import files

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}


def load() -> dict[str, tuple[str, bytes]]:
    """Content type and bytes of each file, by the path under which it is served."""
    table = {}
    for item in files(__package__).joinpath("static").iterdir():
        suffix = "." + item.name.rpartition(".")[2]
        if suffix in TYPES:
            table["/" + item.name] = TYPES[suffix], item.read_bytes()
    table["/"] = table["/index.html"]
    return table
