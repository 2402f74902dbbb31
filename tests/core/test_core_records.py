"""Untrusted JSON is either accepted as valid, or refused with one sentence."""

from dataclasses import dataclass

import pytest

from firstcontact.core import InputError
from firstcontact.core.records import Count, Name, read_record


@dataclass(frozen=True)
class Part:
    sample: Count
    weight: float


@dataclass(frozen=True)
class Record:
    name: Name
    parts: tuple[Part, ...]


def read(text, longest=10000):
    return read_record(text.encode("utf-8", "surrogatepass"), Record, "x.json", "mend it", longest)


def test_valid_records_are_read():
    tree = '{"name": "Äpfel", "parts": [{"sample": 3, "weight": 1, "new": {"a": []}}]}'
    assert read(tree) == Record("Äpfel", (Part(3, 1.0),))


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ('{"name": "a"}', "parts"),
        ('{"name": 3, "parts": []}', "name is wrong"),
        ('{"name": "a", "parts": [{"sample": -1, "weight": 1}]}', r"parts\[0\].sample is wrong"),
        ('{"name": "a", "parts": [{"sample": 1e18, "weight": 1}]}', "sample"),
        ('{"name": "a", "parts": [{"sample": 1, "weight": 1e999}]}', "weight is wrong"),
        ('{"name": "a", "parts": [{"sample": 1, "weight": NaN}]}', "not JSON"),
        ('{"name": "a", "parts": [{"sample": 1, "weight": ' + "9" * 400 + "}]}", "weight is wrong"),
        ('{"name": "' + "a" * 201 + '", "parts": []}', "name is wrong"),
        ('{"name": "a", "parts": [], "b": ' + "[" * 5000 + "]" * 4000, "nested too deeply"),
        ('{"name": "\udcff", "parts": []}', "not JSON in UTF-8"),
        ("[]", "object"),
        ("", "not JSON"),
        (" " * 20_000, "more than 10000"),
    ],
)
def test_invalid_records_are_refused(text, field):
    with pytest.raises(InputError, match=field) as caught:
        read(text)
    message = str(caught.value)
    assert message.startswith("x.json")
    assert message.endswith(": mend it")
    assert "\n" not in message
