"""The twin's kernels compute what the reference does, and check their arguments."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import reference
from pinches import BRITTLE, EVERYDAY, PAPER_RIG, drawn

from firstcontact.core import Command
from firstcontact.core.installation import load_compiled
from firstcontact.twin import BLOCKS
from firstcontact.twin import _run as run_module
from firstcontact.twin._run import PinchRun
from firstcontact.twin.drive import Drive
from firstcontact.twin.mechanics import FingerParameters, Piece, VelostatParameters, integrate_all
from firstcontact.twin.noise import RUBBING
from firstcontact.twin.pinch import excerpt
from firstcontact.twin.sensor import DeviceFilter
from firstcontact.twin.slip_sound import PLACES, SlipParameters

Arguments = tuple[Any, ...]

COMPILED = load_compiled("firstcontact.twin._compiled")


def copied(arguments: Arguments) -> Arguments:
    """Return the arguments with copies of their arrays."""
    return tuple(a.copy() if isinstance(a, np.ndarray) else a for a in arguments)


def arrays(arguments: Arguments) -> list[bytes]:
    return [a.tobytes() for a in arguments if isinstance(a, np.ndarray)]


def assert_close(arguments: Arguments, expected: Arguments) -> None:
    for a, b in zip(arguments, expected, strict=True):
        if isinstance(a, np.ndarray):
            np.testing.assert_allclose(a, b, rtol=1e-8, atol=1e-8 * np.nanmax(np.abs(b), initial=0))


@cache
def pieces() -> list[Arguments]:
    """Return pieces of several pinches to integrate, as plain tuples."""
    taken: list[Arguments] = []

    def take(given: list[Piece]) -> list[int]:
        taken.extend(copied(piece) for piece in given)
        return integrate_all(given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_module, "integrate_all", take)
        for i, condition in enumerate((PAPER_RIG, EVERYDAY)):
            draw = excerpt(drawn(BLOCKS[2 * i], i, condition), 0.003)
            PinchRun(draw, 0.006, 2).advance(30)
            draw = excerpt(drawn(BLOCKS[4 * i], i, condition), 0.004)
            run = PinchRun(draw, 0.3, 0, Drive(latency=0.0), at_rest=False, damped=True)
            run.advance(15)
            run.order(Command(-0.02, 3.0), 16)
            run.advance(20)
            run.advance(1)
            run.order(Command(0.05, 3.0), run.done)
            run.advance(600)
            run.limit = 0.1
            run.advance(300)
        draw = drawn(BRITTLE[0])
        PinchRun(draw, 0.02, 3, at_rest=True).advance(4)
    return taken


def integrate(*arguments: Any) -> int:
    """Integrate one piece with the kernel."""
    (taken,) = COMPILED.integrate_all([arguments])
    return int(taken)


def calls() -> dict[str, tuple[str, Arguments]]:
    """Return the name of each kernel with arguments that take all of its branches."""
    rng = np.random.default_rng(8)
    n = 250
    force = 3.0 * np.abs(rng.standard_normal(n)).cumsum() / n
    force[150:] *= 0.5
    lines = np.exp(1j * rng.uniform(0, 6, 7))
    turns = np.exp(1j * rng.uniform(0, 1, 7))
    scans = rng.integers(0, 1200, (n, 6)).astype(np.uint16)
    scans[::7, 4:] = 0
    state = DeviceFilter()
    filters = (state._place, state._smoothed, state._readings, state._sums)
    slip = SlipParameters()
    factors = np.exp(0.1 * rng.standard_normal((slip.patches, PLACES)))
    patches = np.zeros((slip.patches, 4))
    patches[:, 2] = 1.0
    speed = np.linspace(0.0, 0.2, 30)
    pad: Arguments = (
        np.linspace(2.0, 1.0, 30), speed, np.linspace(0.0, 1.0, 30), 0.2, 0.6, slip,
        FingerParameters(), factors, patches, np.zeros(7), np.zeros(30),
    )  # fmt: skip
    light = copied((*pad[:3], 1e-6, *pad[4:]))
    return {
        "tones": ("tones", (lines, turns, rng.random(6), rng.random(6), rng.random(n))),
        "filtered": ("filtered", (RUBBING, rng.standard_normal(n), np.zeros(n))),
        "piezo": ("piezo_counts", (2.5 * rng.standard_normal(n), np.zeros(n, np.uint16))),
        "force": (
            "force_counts",
            (
                force, rng.dirichlet(np.ones(6)), VelostatParameters(),
                0.01 * rng.standard_normal(n), 2e-4, np.zeros((2, 6)), 5, np.zeros(n, np.uint16),
            ),
        ),
        "filter": ("filter_scans", (scans, *filters, np.zeros((n, 16), np.int16))),
        "smooth": ("smooth", (scans[:, 0].copy(), np.zeros(n, np.int16))),
        "slide": (
            "slide",
            (rng.random((n, 2)), rng.random(n), 0.2, 0.4, 1e-3, np.zeros(2), np.ones((n, 2))),
        ),
        "slip": ("slide_patches", pad),
        "slip of a light object": ("slide_patches", light),
    }  # fmt: skip


@cache
def all_calls() -> dict[str, tuple[str, Arguments]]:
    return calls() | {"integrate": ("integrate", pieces()[0])}


def kernel(name: str) -> Callable[..., Any]:
    function: Callable[..., Any] = integrate if name == "integrate" else getattr(COMPILED, name)
    return function


@pytest.mark.parametrize("name", [n for n, (f, _) in calls().items() if hasattr(reference, f)])
def test_a_kernel_gives_the_numbers_of_the_reference(name: str) -> None:
    function, arguments = calls()[name]
    compiled, expected = copied(arguments), copied(arguments)
    kernel(function)(*compiled)
    getattr(reference, function)(*expected)
    assert_close(compiled, expected)
    assert arrays(compiled) != arrays(arguments)


def test_pieces_of_pinches_have_the_numbers_of_the_reference() -> None:
    sizes = set()
    for arguments in pieces():
        compiled, expected = copied(arguments), Piece(*copied(arguments))
        if expected.times.size > 40:
            continue
        assert integrate(*compiled) == reference.integrate(expected)
        assert_close(compiled, expected)
        assert arrays(compiled) != arrays(arguments)
        sizes.add(expected.times.size)
    assert len(sizes) > 4


def test_pieces_side_by_side_have_the_same_bits() -> None:
    alone, together = ([copied(a) for a in pieces()] for _ in range(2))
    taken = [integrate(*a) for a in alone]
    assert COMPILED.integrate_all(together) == taken
    assert [arrays(a) for a in together] == [arrays(a) for a in alone]
    assert any(t < a[5].size for t, a in zip(taken, alone, strict=True))  # one broke
    assert COMPILED.integrate_all([]) == []


@pytest.mark.parametrize("name", [*calls(), "integrate"])
def test_arrays_of_the_wrong_size_or_kind_are_refused(name: str) -> None:
    function, arguments = all_calls()[name]
    run = kernel(function)
    with pytest.raises(TypeError):
        run(*arguments[:-1])
    for i, a in enumerate(arguments):
        if isinstance(a, np.ndarray):
            other = np.complex64 if a.dtype == np.complex128 else np.float32
            faults: list[Any] = [np.zeros(a.shape, other), a.tobytes(), None]
            if a.size > 1:
                faults.append(np.repeat(a.ravel(), 2)[::2])
            if name != "tones" or i < 4:  # any number of points
                faults += [a.ravel()[:-1].copy(), np.append(a.ravel(), a.ravel()[:1])]
        elif isinstance(a, tuple):
            faults = [a[:-1], (*a, 1.0), tuple(map(str, a)), None]
        else:
            faults = ["1", None]
        for fault in faults:
            wrong = copied(arguments)
            with pytest.raises((ValueError, TypeError, BufferError)):
                run(*wrong[:i], fault, *wrong[i + 1 :])
            assert arrays(wrong) == arrays(arguments)


@pytest.mark.parametrize(
    ("name", "place", "value"),
    [
        ("integrate", 8, 0), ("integrate", 15, 0), ("integrate", 6, np.zeros((2, 1))),
        ("integrate", 9, np.zeros((0, 2))), ("force", 6, -1), ("filter", 1, np.array([48])),
        ("filter", 1, np.array([-2])), ("slip", 5, SlipParameters(patches=11)),
    ],
)  # fmt: skip
def test_a_number_out_of_range_is_refused(name: str, place: int, value: object) -> None:
    function, arguments = all_calls()[name]
    wrong = copied(arguments)
    with pytest.raises(ValueError, match=r"."):
        kernel(function)(*wrong[:place], value, *wrong[place + 1 :])
    assert arrays(wrong) == arrays(arguments)


def test_patches_with_broken_positions_stay_in_bounds() -> None:
    for position in (math.nan, math.inf, -5.0, 1e300):
        function, arguments = calls()["slip"]
        wrong = copied(arguments)
        wrong[8][:, 3] = position
        kernel(function)(*wrong)
        assert wrong[8].shape == arguments[8].shape
