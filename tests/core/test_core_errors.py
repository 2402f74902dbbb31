"""Only errors that the user can fix are an InputError."""

from __future__ import annotations

from firstcontact.core import InputError


def test_error_text_is_its_message() -> None:
    error = InputError("labels.csv: column shore_a is missing: add it")
    assert str(error) == "labels.csv: column shore_a is missing: add it"
    assert isinstance(error, ValueError)
