import pytest

from firstcontact.core import InputError
from firstcontact.recording.table import read_columns, read_rows


def test_blanks_byte_order_marks_and_missing_cells_are_ignored(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(
        '\ufeff a , b,note\n1, "two, too",x,beyond\n\n ü\n', encoding="utf-8", newline=""
    )
    assert read_rows(path, ("a", "b")) == [
        (2, {"a": "1", "b": "two, too", "note": "x"}),
        (4, {"a": "ü", "b": "", "note": ""}),
    ]


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "'a'"),
        (b"a,c\n1,2\n", "'b'"),
        (b"a,b\n\xff,1\n", r"table\.csv"),
        (b"a,b\n" + b"1" * 200_000, r"table\.csv"),
    ],
)
def test_invalid_tables_are_refused(tmp_path, data, problem):
    path = tmp_path / "table.csv"
    path.write_bytes(data)
    with pytest.raises(InputError, match=problem):
        read_rows(path, ("a", "b"))
    with pytest.raises(InputError, match=tmp_path.name):
        read_rows(tmp_path, ("a", "b"))


def test_line_numbers_match_an_editor(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text('a,b\n1,2\n\n3,"two\nlines"\n5,6\n', encoding="utf-8")
    columns = read_columns(path)
    assert [columns.place(row) for row in range(3)] == ["line 2", "line 5", "line 6"]
    assert columns.of_rows([2]).place(0) == "line 6"


@pytest.mark.parametrize(("mark", "name"), [(";", "semicolons"), ("\t", "tabs"), ("|", "bars")])
def test_other_separators_are_refused_by_name(tmp_path, mark, name):
    path = tmp_path / "table.csv"
    path.write_text(f"a{mark}b{mark}c\n0,5{mark}1{mark}2\n", encoding="utf-8")
    for read_table in (read_columns, lambda path: read_rows(path, ("a",))):
        with pytest.raises(InputError, match=f"line 1 .*{name}"):
            read_table(path)
