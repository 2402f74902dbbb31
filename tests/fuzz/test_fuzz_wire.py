"""Some damaged inputs from devices and from browsers. The whole fuzzer is run by hand."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random

import pytest
from fuzz_ways import WIRE

from firstcontact.core import InputError


@pytest.mark.parametrize("route", sorted(set(WIRE), key=lambda route: route.__name__))
def test_damage_is_refused_or_taken_for_what_it_is(
    route: Callable[[Random, Path], None], tmp_path: Path
) -> None:
    for number in range(40):
        folder = tmp_path / str(number)
        folder.mkdir()
        with suppress(InputError):
            route(Random(number), folder)
