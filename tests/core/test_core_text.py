"""Text: numbers in messages, numbers that people type, units, and quantities of labels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import firstcontact as fc
from firstcontact.core import InputError, fingertip_layout
from firstcontact.core.physics import gent_modulus
from firstcontact.core.quantity import MODULUS, QUANTITIES, RANK, SHORE_A, STIFFNESS
from firstcontact.core.text import counted, parse_float, parse_int, percent, summarize_error
from firstcontact.core.units import COUNTS, fit_unit, parse_unit, unit_of_name


@pytest.mark.parametrize("expected", ["1 pinch", "0 pinches", "2 stretches", "2 epochs", "2 days"])
def test_one_is_singular(expected):
    number, noun = expected.split()
    singular = noun.removesuffix("s") if noun in ("epochs", "days") else noun.removesuffix("es")
    assert counted(int(number), singular) == expected


def test_nouns_in_y_and_large_numbers():
    assert counted(2, "policy") == "2 policies"
    assert counted(1200, "WAV file") == "1,200 WAV files"


def test_percent_has_useful_decimals():
    shares = [(1.0, 1), (0.972, 1), (0.99966, 1), (0.99999, 1), (0.996, 0), (0.4, 0), (1.2, 0)]
    expected = "100.0 %, 97.2 %, 99.97 %, 99.99 %, 99.6 %, 40 %, 120 %"
    assert ", ".join(percent(*share) for share in shares) == expected


@given(st.floats(0, 1, exclude_max=True), st.integers(0, 2))
def test_percent_is_never_rounded_up_to_100(share, decimals):
    text = percent(share, decimals)
    assert float(text.removesuffix(" %")) < 100
    assert len(text) <= len("99.99 %")


@pytest.mark.parametrize(
    ("text", "value"), [("1", 1.0), (" -2.5 ", -2.5), ("+.5e-3", 5e-4), ("1e-05", 1e-5)]
)
def test_plain_numbers(text, value):
    assert parse_float(text) == value


@pytest.mark.parametrize("text", ["1_0", "1_000.5", "１２", "٣", "", " ", "0x10", "1,5", "9_9e1"])
def test_ambiguous_numbers_are_refused(text):
    for parse in (parse_float, parse_int):
        with pytest.raises(ValueError, match="which is not a"):
            parse(text)


@pytest.mark.parametrize("text", ["nan", "inf", "-Infinity", "1e999"])
def test_infinity_is_refused_by_default(text):
    with pytest.raises(ValueError, match="finite"):
        parse_float(text)
    assert str(parse_float(text, finite=False)) in ("nan", "inf", "-inf")


def test_errors_are_summarized_in_one_line():
    assert summarize_error(ValueError("a\n  b")) == "ValueError: a b"
    assert summarize_error(SystemExit()) == "SystemExit"


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


def dataset(*labels):
    data, layout = np.zeros((500, 16)), fingertip_layout()
    return fc.Dataset(tuple(fc.Pinch(data, layout, fc.Label(**label)) for label in labels))


@pytest.mark.parametrize("quantity", QUANTITIES.values(), ids=str)
def test_a_scale_is_undone(quantity):
    values = np.geomspace(max(quantity.least, 1e-3), quantity.most, 20)
    assert np.allclose(quantity.restored(quantity.scaled(values)), values, rtol=1e-12)


@pytest.mark.parametrize("quantity", [MODULUS, STIFFNESS])
def test_errors_of_a_logarithmic_quantity_are_factors(quantity):
    error = float(np.diff(quantity.scaled([5.0, 6.0]))[0])
    assert quantity.error_words(error) == "x1.20"
    assert quantity.error_words(-error) == "x0.83"


def test_a_modulus_is_a_shore_a_where_gents_formula_holds():
    moduli = [1e-6 * gent_modulus(shore) for shore in (2.0, 10.0, 60.0, 96.0)]
    data = dataset(*({"modulus_mpa": m} for m in moduli))
    assert data.quantity is MODULUS
    assert np.allclose(data.shore_a, [np.nan, 10, 60, np.nan], equal_nan=True)


@pytest.mark.parametrize(
    ("labels", "quantity"),
    [
        ([{}], None),
        ([{"hardness_rank": 2}], RANK),
        ([{"stiffness_n_per_mm": 2.0}, {}], STIFFNESS),
        ([{"shore_a": 20.0}, {"hardness_rank": 3}], SHORE_A),
    ],
)
def test_a_dataset_has_one_quantity(labels, quantity):
    assert dataset(*labels).quantity is quantity


@pytest.mark.parametrize("other", ["modulus_mpa", "stiffness_n_per_mm"])
def test_two_measured_quantities_in_a_dataset_are_refused(other):
    data = dataset({"shore_a": 20.0}, {other: 2.0})
    with pytest.raises(InputError, match=f"shore_a and {other}"):
        _ = data.quantity


@pytest.mark.parametrize("value", [0.0, -1.0, 2e6, np.nan, "stiff"])
@pytest.mark.parametrize("name", ["modulus_mpa", "stiffness_n_per_mm"])
def test_an_impossible_label_is_refused(name, value):
    with pytest.raises(InputError, match=name):
        fc.Label(**{name: value})
