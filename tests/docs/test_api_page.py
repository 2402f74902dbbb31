"""The pages of the public interface name every public name, once."""

import re
from importlib import import_module

import pytest
from pages import ROOT

import firstcontact as fc
from firstcontact import plugins

PAGES = {
    name: re.findall(
        r"^::: ([\w.]+)$", (ROOT / f"docs/reference/{name}.md").read_text("utf-8"), re.MULTILINE
    )
    for name in ("python", "python-plugins", "python-rooms")
}
#: Rooms with a face for others, from the ground floor up.
ROOMS = re.findall(
    r"^## firstcontact\.(\w+)$",
    (ROOT / "docs/reference/python-rooms.md").read_text("utf-8"),
    re.MULTILINE,
)


def test_the_page_for_users_has_every_name() -> None:
    assert sorted(PAGES["python"]) == sorted(f"firstcontact.{n}" for n in {*fc.__all__, "open"})


def test_the_page_for_plugins_has_every_name() -> None:
    names = sorted(f"firstcontact.plugins.{name}" for name in plugins.__all__)
    assert sorted(PAGES["python-plugins"]) == names


@pytest.mark.parametrize("room", ROOMS)
def test_the_page_of_rooms_has_what_the_others_lack(room: str) -> None:
    others = {*fc.__all__, *plugins.__all__}
    names = [n for n in import_module(f"firstcontact.{room}").__all__ if n not in others]
    listed = [n for n in PAGES["python-rooms"] if n.startswith(f"firstcontact.{room}.")]
    assert sorted(listed) == sorted(f"firstcontact.{room}.{name}" for name in names)
