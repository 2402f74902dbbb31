import pytest

from firstcontact.core import InputError
from firstcontact.recording import read_rows
from firstcontact.recording._table import read_columns


def test_blanks_marks_and_missing_cells_do_not_matter(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(
        '\ufeff a , b,note\n1, "two, too",x,beyond\n\n ü\n', encoding="utf-8", newline=""
    )
    assert read_rows(path, ("a", "b")) == [
        (2, {"a": "1", "b": "two, too", "note": "x"}),
        (4, {"a": "ü", "b": "", "note": ""}),
    ]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "column 'a' is missing: give a, b"),
        (b"a,c\n1,2\n", "column 'b' is missing: give a, b"),
        (b"a,b\n\xff,1\n", "is not CSV in UTF-8"),
        (b"a,b\n" + b"1" * 200_000, "is not CSV in UTF-8"),
    ],
)
def test_what_is_no_such_table_is_refused(tmp_path, data, said):
    path = tmp_path / "table.csv"
    path.write_bytes(data)
    with pytest.raises(InputError, match=said):
        read_rows(path, ("a", "b"))
    with pytest.raises(InputError, match="not a regular file"):
        read_rows(tmp_path, ("a", "b"))


def test_rows_are_where_an_editor_shows_them(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text('a,b\n1,2\n\n3,"two\nlines"\n5,6\n', encoding="utf-8")
    columns = read_columns(path)
    assert [columns.place(row) for row in range(3)] == ["line 2", "line 5", "line 6"]
    assert columns.of_rows({"a": ["5"]}, [2]).place(0) == "line 6"


@pytest.mark.parametrize(("mark", "name"), [(";", "semicolons"), ("\t", "tabs"), ("|", "bars")])
def test_another_separator_is_named_as_the_cause(tmp_path, mark, name):
    path = tmp_path / "table.csv"
    path.write_text(f"a{mark}b{mark}c\n0,5{mark}1{mark}2\n", encoding="utf-8")
    for read in (read_columns, lambda path: read_rows(path, ("a",))):
        with pytest.raises(InputError, match=f"line 1 has no comma and 2 {name}"):
            read(path)
