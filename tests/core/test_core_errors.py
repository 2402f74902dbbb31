"""Errors say by their class what failed, and untrusted JSON is valid or refused."""

import ast
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.collect.guide import Item
from firstcontact.contact import make_detector
from firstcontact.core import InputError
from firstcontact.core.records import Count, Name, read_record
from firstcontact.device import open_source
from firstcontact.jobs import worker_count
from firstcontact.models.registry import model_class


def damaged_model(folder: Path) -> Path:
    """Return the folder of a model whose weights are cut short."""
    fc.adapt().save(folder / "model")
    weights = next((folder / "model").glob("*.safetensors"))
    weights.write_bytes(weights.read_bytes()[:100])
    return folder / "model"


def damaged_recording(folder: Path) -> Path:
    """Return a file that only has the name of a recording."""
    (folder / "damaged.mcap").write_bytes(b"no recording")
    return folder / "damaged.mcap"


def opened(device: str) -> None:
    with open_source(device):
        pass


CASES: dict[str, tuple[type[fc.InputError], Callable[[Path], object]]] = {
    "seed": (fc.ArgumentError, lambda folder: fc.adapt(seed=-1)),
    "seconds": (fc.ArgumentError, lambda folder: next(fc.live(fc.open(), seconds=-1))),
    "speed": (fc.ArgumentError, lambda folder: fc.open(speed=0.0)),
    "positions": (fc.ArgumentError, lambda folder: fc.closing_speed(np.arange(3.0), [0.0], at=1.0)),
    "workers": (fc.ArgumentError, lambda folder: worker_count(-1)),
    "rate": (fc.ArgumentError, lambda folder: fc.train(fc.sample("strikes"), rate=20.0)),
    "pinches": (fc.ArgumentError, lambda folder: fc.simulate(folder, pinches_per_block=-1)),
    "names": (fc.ArgumentError, lambda folder: Item("x" * 500, 1)),
    "no file": (fc.FileError, lambda folder: fc.load(folder / "none")),
    "not empty": (fc.FileError, lambda folder: fc.simulate(damaged_recording(folder).parent)),
    "damaged file": (fc.FileError, lambda folder: fc.load(damaged_recording(folder))),
    "no table": (fc.FileError, lambda folder: fc.import_recordings(folder / "none.csv", folder)),
    "no port": (fc.DeviceError, lambda folder: opened(str(folder / "ttyACM7"))),
    "no name": (fc.DeviceError, lambda folder: opened("lsl:")),
    "no unit": (fc.DeviceError, lambda folder: opened(f"csv:{folder}/ttyACM7=")),
    "no model": (fc.ModelError, lambda folder: fc.load_model(folder / "none")),
    "damaged model": (fc.ModelError, lambda folder: fc.load_model(damaged_model(folder))),
    "no predictor": (fc.ModelError, lambda folder: fc.Model().predict(fc.sample("strikes"))),
    "kind": (fc.ModelError, lambda folder: model_class("none", of_windows=True)),
    "untrained": (fc.ModelError, lambda folder: make_detector("svm").chain_constants(4936.0)),
    "no detector": (fc.ModelError, lambda folder: fc.Model().own_detector),
}


@pytest.mark.parametrize("case", CASES)
def test_the_class_of_an_error_says_what_failed(case: str, tmp_path: Path) -> None:
    kind, fail = CASES[case]
    with pytest.raises(fc.InputError) as error:
        fail(tmp_path)
    assert type(error.value) is kind, error.value


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


#: Files that raise InputError itself, for what is no file, device, model or argument: the
#: installation, a cluster, a terminal, outputs and the code of others.
PLAIN = {
    "core/installation.py": 3, "core/registry.py": 1, "jobs/cluster.py": 3,
    "cli/guided.py": 2, "cli/verbs/__init__.py": 1, "cli/verbs/live.py": 1,
}  # fmt: skip


def test_only_a_few_errors_do_not_say_what_failed() -> None:
    package = Path(fc.__file__).parent
    plain = Counter(
        file.relative_to(package).as_posix()
        for file in package.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text("utf-8")))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "InputError"
    )
    assert plain == PLAIN
