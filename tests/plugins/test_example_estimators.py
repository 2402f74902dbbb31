"""The package examples/plugin_estimators is installed and passes all estimator tests."""

import ast
from pathlib import Path

import pytest

from firstcontact.models import ESTIMATORS
from firstcontact.testing import check_estimator

EXAMPLE = Path(__file__).parents[2] / "examples" / "plugin_estimators" / "more_estimators"


@pytest.mark.parametrize("name", ["gaussian_process", "minirocket"])
def test_estimators_of_another_package_are_found_and_keep_the_promises(name: str) -> None:
    assert name in ESTIMATORS.names, "run `make install`"
    assert name not in ESTIMATORS.builtin_names
    assert ESTIMATORS[name].__module__.startswith("more_estimators.")
    check_estimator(ESTIMATORS[name])


@pytest.mark.parametrize("file", sorted(EXAMPLE.glob("*.py")), ids=lambda file: file.name)
def test_they_import_what_rooms_offer(file: Path) -> None:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("firstcontact"):
            names = f"{node.module}.{'.'.join(alias.name for alias in node.names)}"
            assert "._" not in names
