"""Targets of the Ability Hand's fingers, compared with closed forms."""

from math import degrees, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command
from firstcontact.grasp.ability import (
    CLOSED,
    INDEX,
    LEAD,
    LEVERS,
    OPEN,
    OPPOSED,
    THUMB,
    Felt,
    Fingers,
)

AT_REST = Felt([20.0] * 5 + [OPPOSED])


def touched(newton: float, finger: int, position: float) -> Felt:
    """Return a state where one sensor of one finger is loaded."""
    touch = [0.0] * 30
    touch[{INDEX: 3, THUMB: 27}[finger]] = newton
    return Felt([position] * 5 + [OPPOSED], touch)


@pytest.mark.parametrize("speed", [0.02, -0.02, 0.0])
def test_both_fingertips_move_at_the_commanded_speed(speed: float) -> None:
    fingers, felt = Fingers(AT_REST), AT_REST
    for _ in range(40):
        fingers.move(Command(speed, 5.0), 0.01, felt)
        felt = Felt(fingers.targets)
    for finger, lever in LEVERS.items():
        travel = (fingers.targets[finger] - 20.0) * lever
        assert travel == pytest.approx(degrees(speed) * 0.4)


@pytest.mark.parametrize("finger", [INDEX, THUMB])
def test_pressing_finger_stays_and_the_other_moves_on(finger: int) -> None:
    other = THUMB if finger == INDEX else INDEX
    fingers = Fingers(AT_REST)
    fingers.move(Command(0.02, 2.0), 0.03, touched(2.0, finger, 19.5))
    assert fingers.targets[finger] == 19.5
    assert fingers.targets[other] > 20.0


@given(
    st.lists(
        st.tuples(st.floats(-0.25, 0.25), st.floats(0, 10), st.floats(0, 0.03), st.floats(-50, 150))
    )
)
def test_targets_stay_within_reach_and_near_a_blocked_finger(
    steps: list[tuple[float, float, float, float]],
) -> None:
    fingers = Fingers(AT_REST)
    for speed, force, seconds, position in steps:
        felt = Felt([position] * 5 + [OPPOSED])
        previous = fingers.targets
        fingers.move(Command(speed, force), seconds, felt)
        for finger in LEVERS:
            target = fingers.targets[finger]
            assert OPEN <= target <= CLOSED
            if speed > 0 and force > 0:
                assert target <= max(position + LEAD, OPEN)
                reach = degrees(speed / LEVERS[finger]) * seconds
                assert target <= previous[finger] + reach + 1e-9


def test_travel_is_the_mean_of_both_arcs() -> None:
    position = [0.0] * 6
    position[INDEX], position[THUMB] = 90.0, 30.0
    expected = (LEVERS[INDEX] * pi / 2 + LEVERS[THUMB] * pi / 6) / 2
    assert Felt(position).travel == pytest.approx(expected)
