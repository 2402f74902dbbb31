"""Units that texts name, and numbers that cannot have them."""

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.core.units import COUNTS, fit_unit, parse_unit, unit_of_name


@pytest.mark.parametrize(
    ("text", "name", "scale"),
    [
        ("V", "V", 1.0),
        ("mV", "V", 1e-3),
        ("\u00b5V", "V", 1e-6),
        (" microvolts", "V", 1e-6),
        ("[uV]", "V", 1e-6),
        ("12 bits over 5 V", "V", 5 / 4096),
        ("16-bit", "V", 3.3 / 65536),
        ("counts", "V", 3.3 / 1024),
        ("mg", "m/s2", 9.80665e-3),
        ("m/s\u00b2", "m/s2", 1.0),
        ("kPa", "Pa", 1e3),
        ("Full scale", "full scale", 1.0),
    ],
)
def test_a_text_names_a_unit(text, name, scale):
    unit = parse_unit(text)
    assert (unit.name, unit.scale) == (name, pytest.approx(scale, rel=1e-12))


@pytest.mark.parametrize("text", ["", "N", "MV", "MPa", "furlong", "0 bits", "12 bits over 0 V"])
def test_an_unknown_unit_is_none(text):
    assert parse_unit(text) is None


def test_a_name_may_end_with_its_unit():
    assert unit_of_name("piezo_mV") == unit_of_name("piezo (mV)") == parse_unit("mV")
    assert unit_of_name("time_left") is unit_of_name("piezo") is None


@pytest.mark.parametrize(
    ("unit", "values", "is_force"),
    [
        (COUNTS, [512, 2900], False),  # more than 10 bits
        (COUNTS, [-200, 210], False),  # around 0
        (COUNTS, [120, 128, 140], False),  # 8 bits
        (COUNTS, [0, 3000], True),
        (COUNTS, [-5, 9], True),
        (parse_unit("12 bits"), [0, 5000], False),
        (parse_unit("8 bits"), [-200, 10], False),
        (parse_unit("V"), [512, 700], False),
        (parse_unit("g"), [0, 3e5], False),
        (parse_unit("full scale"), [-4, 900], False),
        (parse_unit("mV"), [-20_000, 0], True),
    ],
)
def test_numbers_that_cannot_have_a_unit_are_refused(unit, values, is_force):
    with pytest.raises(InputError, match=r"piezo.*bits"):
        fit_unit("piezo", unit, np.array(values)[:, None], is_force=is_force)


def test_stated_bits_may_lie_around_zero():
    values = np.array([[-900], [1200]])
    assert fit_unit("piezo", parse_unit("12 bits"), values).offset == 0
    assert fit_unit("piezo", parse_unit("12 bits"), values + 2048).offset == 2048
    apart = np.array([[0.0, 1e6], [0.1, 1e6]])  # the offsets of two sensors are no swing
    assert fit_unit("piezo", parse_unit("V"), apart) == parse_unit("V")
