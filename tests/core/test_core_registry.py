"""Entries are imported on first use. Plug-ins are added, and broken ones are left out."""

from importlib.metadata import EntryPoint

import pytest

from firstcontact.core import InputError, Registry
from firstcontact.core import registry as module
from firstcontact.core.registry import foreign_errors

GROUP = "firstcontact.test"


class Blue:
    name = "blue"


class Red:
    name = "red"


def colours(monkeypatch, **points):
    """Return a registry with the entry blue, and plug-ins with these names and locations."""
    entry_points_of_test = [EntryPoint(name, place, GROUP) for name, place in points.items()]
    monkeypatch.setattr(
        module, "entry_points", lambda group: [p for p in entry_points_of_test if group == GROUP]
    )
    return Registry("colour", GROUP, {"blue": f"{__name__}:Blue"})


def test_entries_are_imported_on_first_use(monkeypatch):
    registry = Registry("colour", GROUP, {"far": "nowhere.at.all:Thing", "blue": Blue()})
    assert list(registry) == ["far", "blue"]
    assert registry["blue"].name == "blue"
    assert registry.default == "far"
    with pytest.raises(ModuleNotFoundError):
        registry["far"]
    assert Registry("colour", GROUP, {"blue": Blue()}, default="blue").default == "blue"


def test_plugins_follow_the_built_in_entries(monkeypatch):
    registry = colours(monkeypatch, red=f"{__name__}:Red")
    assert list(registry) == ["blue", "red"]
    assert registry.find("red") is Red
    assert (len(registry), registry.failed) == (2, {})


@pytest.mark.parametrize(
    ("name", "place", "cause"),
    [
        ("red", "nowhere.at.all:Red", "ModuleNotFoundError"),
        ("red", f"{__name__}:Green", "AttributeError"),
        ("green", f"{__name__}:Red", "red"),
        ("blue", f"{__name__}:Red", "colour"),
    ],
)
def test_broken_plugin_is_reported_and_skipped(monkeypatch, caplog, name, place, cause):
    registry = colours(monkeypatch, **{name: place})
    assert [entry.name for entry in registry.values()] == ["blue"]
    assert cause in registry.failed[name]
    assert name in caplog.text
    assert registry.find("blue") is Blue
    if name != "blue":
        with pytest.raises(InputError, match=f"'{name}'"):
            registry.find(name)


def test_unknown_name_is_refused_with_the_choices(monkeypatch):
    registry = colours(monkeypatch, red=f"{__name__}:Red")
    with pytest.raises(InputError, match=r"'green'.*blue, red"):
        registry.find("green")
    with pytest.raises(KeyError):
        registry["green"]


def test_errors_of_other_code_name_it_and_keep_their_cause(tmp_path):
    with (
        pytest.raises(InputError, match=r"^MyModel\.fit raised ValueError: no$") as raised,
        foreign_errors("MyModel.fit"),
    ):
        raise ValueError("no")
    assert isinstance(raised.value.__cause__, ValueError)
    with pytest.raises(InputError, match="mine"), foreign_errors("x"):
        raise InputError("mine")
    with pytest.raises(FileNotFoundError), foreign_errors("x"):
        (tmp_path / "missing").read_text()
    with pytest.raises(KeyboardInterrupt), foreign_errors("x"):
        raise KeyboardInterrupt
