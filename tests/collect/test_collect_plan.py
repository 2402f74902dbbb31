import pytest

from firstcontact.collect import Item, read_plan
from firstcontact.core import InputError, Label, Role


def test_a_plan_is_read(tmp_path):
    path = tmp_path / "plan.csv"
    path.write_text(
        "object,shore,specimen,pinches,role\nblock 29,29,b29,20,train\nApfel 🍎,,,5,test\n",
        encoding="utf-8",
    )
    assert read_plan(path) == (
        Item("block 29", 20, 29.0, "b29", Role.TRAIN),
        Item("Apfel 🍎", 5, None, "", Role.TEST),
    )
    assert read_plan(path)[1].label("2") == Label(
        "Apfel 🍎", None, None, "Apfel 🍎", "2", Role.TEST
    )


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("object,pinches,colour\na,1,red\n", "'colour'"),
        ("object,shore\na,1\n", "'pinches'"),
        ("object,pinches\n", "plan.csv"),
        ("object,pinches\na,many\n", "line 2: pinches"),
        ("object,pinches\na,1_0\n", "line 2: pinches"),
        ("object,pinches,shore\na,1,soft\n", "line 2: shore"),
        ("object,pinches,role\na,1,both\n", "line 2: role"),
        ("object,pinches\na,0\n", "line 2: a"),
        ("object,pinches\n,3\n", "line 2"),
        ("object,pinches,shore\na,1,120\n", "line 2: a: the value of shore"),
        ("object,pinches\na,1\na,2\n", "line 3: a"),
        ("object,pinches\na,1,5\nb\n", "line 3: pinches"),
    ],
)
def test_invalid_plans_are_refused(tmp_path, text, problem):
    path = tmp_path / "plan.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=problem):
        read_plan(path)


def test_missing_or_binary_plan_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.csv"):
        read_plan(tmp_path / "none.csv")
    (tmp_path / "bytes.csv").write_bytes(b"object,pinches\n\xff\xfe,3\n")
    with pytest.raises(InputError, match=r"bytes\.csv"):
        read_plan(tmp_path / "bytes.csv")


@pytest.mark.parametrize("names", [("b\udcff", ""), ("b", "b\udcff")])
def test_names_outside_utf_8_are_refused(names):
    # as a command line has them that is not UTF-8
    with pytest.raises(InputError):
        Item(names[0], 1, None, names[1])
