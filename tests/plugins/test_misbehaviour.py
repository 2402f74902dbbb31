"""Plug-ins: a command that uses a faulty one fails with its error, and others work."""

import importlib
import itertools
import sys
from collections.abc import Callable

import pytest

from firstcontact.cli.main import main
from firstcontact.cli.verbs import configuration
from firstcontact.contact import DETECTORS, SLIP_DETECTORS
from firstcontact.device import SOURCES
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.grasp import HANDS, POLICIES
from firstcontact.models import ESTIMATORS
from firstcontact.recording import EXPORTERS, IMPORTERS, Header, write_dataset
from firstcontact.streaming.outputs import OUTPUTS

pytestmark = pytest.mark.usefixtures("small_searches")
REGISTRIES = (
    DETECTORS, ESTIMATORS, EXPORTERS, HANDS, IMPORTERS, MODEL_EXPORTERS, OUTPUTS, POLICIES,
    SLIP_DETECTORS, SOURCES,
)  # fmt: skip
#: Counts packages, whose modules stay imported.
_numbers = itertools.count()

Install = Callable[..., str]


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Install a package with one entry point in several groups. Return the module's name."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(site)
    for registry in REGISTRIES:
        registry.reload()

    def make(code, name="bad", entry="ENTRY", groups=""):
        module = f"misbehaving_{next(_numbers)}"
        (site / f"{module}.py").write_text(code, encoding="utf-8")
        info = site / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
        every = groups.split() or [registry.group for registry in REGISTRIES]
        points = "".join(f"[{group}]\n{name} = {module}:{entry}\n" for group in every)
        (info / "entry_points.txt").write_text(points)
        importlib.invalidate_caches()
        return module

    yield make
    for module in [name for name in sys.modules if name.startswith("misbehaving_")]:
        del sys.modules[module]
    for registry in REGISTRIES:
        registry.reload()


@pytest.fixture
def pinches(tmp_path, shore):
    folder = tmp_path / "pinches"
    folder.mkdir()
    write_dataset(shore, folder, Header(shore.layout, "synthetic", "float32"))
    return folder


def run(*words):
    return main([str(word) for word in words])


#: Exit codes for a plug-in that the command checks, and for other errors of its code.
FAILED = (2, 70)


def refused(capsys, reason="ValueError: no"):
    """Assert that the last line names the plug-in's exception."""
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith("firstcontact: ")
    assert reason in last


def test_one_that_was_not_chosen_has_no_effect(install, pinches, tmp_path, capsys):
    module = install("raise ValueError('no')\n")
    assert run("export", pinches, "--to", "hdf5", "--out", tmp_path / "a.h5") == 0
    assert run("train", pinches, "--estimator", "peak", "--out", tmp_path / "m") == 0
    assert run("import", tmp_path / "a.h5", "--out", tmp_path / "back") == 0
    device = ("--device", next(pinches.glob("*.mcap")), "--speed", "inf")
    assert run("live", *device, "--model", tmp_path / "m", "--hand", "print") == 0
    assert (tmp_path / "m" / "model.json").is_file()
    assert module not in sys.modules
    assert "bad" not in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ("export", "PINCHES", "--to", "bad", "--out", "OUT"),
        ("train", "PINCHES", "--estimator", "bad", "--out", "OUT"),
        ("live", "--device", "twin", "--hand", "bad"),
        ("live", "--device", "bad:1"),
        ("live", "--device", "twin", "--output", "bad"),
    ],
)
def test_one_whose_import_fails_is_refused_where_it_was_chosen(
    words, install, pinches, tmp_path, capsys
):
    install("raise ValueError('no')\n")
    places = {"PINCHES": pinches, "OUT": tmp_path / "out"}
    assert run(*(places.get(word, word) for word in words)) == 2
    refused(capsys)
    assert not (tmp_path / "out").exists()


def test_help_lists_names_and_imports_nothing(install, capsys):
    module = install("raise SystemExit(0)\n", "slowly")
    for verb in ("train", "adapt", "study", "live", "export", "import"):
        sys.modules.pop(configuration(verb).__module__, None)
        with pytest.raises(SystemExit) as end:
            run(verb, "--help")
        assert not end.value.code
        captured = capsys.readouterr()
        assert "slowly" in captured.out
        assert captured.err == ""
    assert run("export", "x", "--to", "y", "--out", "z") == 2
    assert "slowly" in capsys.readouterr().err
    assert module not in sys.modules


WRONG = (
    "from types import SimpleNamespace\nENTRY = SimpleNamespace(name='bad')\n",
    "class ENTRY:\n    name = 'bad'\n",
    "ENTRY = 5\n",
    "from firstcontact.grasp.policy import Policy\nclass ENTRY(Policy):\n    name = 'good'\n",
)


@pytest.mark.parametrize("code", WRONG)
@pytest.mark.parametrize("registry", REGISTRIES, ids=lambda registry: registry.kind)
def test_an_object_of_the_wrong_kind_is_refused(code, registry, install):
    install(code)
    with pytest.raises(ValueError, match=r"the plug-in 'bad' .* cannot be loaded"):
        registry.find("bad")
    assert "bad" not in list(registry)


EXPORTER = """
from firstcontact.recording import Exporter
def write(dataset, path):
    path.write_text("half")
    raise ValueError("no")
ENTRY = Exporter("bad", write)
"""
DETECTOR = """
import numpy as np
from firstcontact.contact.detector import Detector
class ENTRY(Detector):
    name = "bad"
    def fires(self, windows):
        raise ValueError("no")
"""
ESTIMATOR = """
from firstcontact.models import Estimator
from firstcontact.models.windows.baselines import TrainMean
class ENTRY(TrainMean):
    name = title = "bad"
    def fit(self, X, y, groups=None, seed=0):
        raise ValueError("no")
"""


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (EXPORTER, ("export", "PINCHES", "--to", "bad")),
        (DETECTOR, ("train", "PINCHES", "--detector-type", "bad", "--contacts", "detected")),
        (ESTIMATOR, ("train", "PINCHES", "--estimator", "bad")),
    ],
)
def test_one_that_fails_at_work_leaves_nothing(code, words, install, pinches, tmp_path, capsys):
    install(code)
    predictions = [pinches if word == "PINCHES" else word for word in words]
    assert run(*predictions, "--out", tmp_path / "out") in FAILED
    refused(capsys)
    assert not (tmp_path / "out").exists()


IMPORTER = """
from firstcontact.recording import Importer
def stop():
    raise ValueError("no")
class Late(Importer):
    def accepts(self, path, given=()):
        {accepting}
ENTRY = Late("bad", "a .bad file", lambda path, rate: {returned}, suffixes=(".bad",))
"""


@pytest.mark.parametrize(("returned", "accepting"), [("stop()", "return True"), ("1", "stop()")])
def test_an_importer_that_fails_is_named(returned, accepting, install, tmp_path, capsys):
    install(IMPORTER.format(returned=returned, accepting=accepting))
    (tmp_path / "a.bad").write_text("x")
    assert run("import", tmp_path / "a.bad", "--out", tmp_path / "out") == 2
    refused(capsys)
    assert not (tmp_path / "out").exists()


SOURCE = """
from firstcontact.device.opening import SourceKind
from firstcontact.device.replay import ReplaySource
from pathlib import Path
class Tape(ReplaySource):
    def {method}(self, *arguments):
        raise ValueError("no")
ENTRY = SourceKind(
    "bad", "bad:PATH", lambda device, options: Tape(Path(device[4:]), float("inf")), is_replay=True
)
"""


@pytest.mark.parametrize("method", ["__init__", "__enter__", "read", "unused"])
def test_a_source_works_or_its_failure_is_named(method, install, pinches, capsys):
    install(SOURCE.format(method=method))
    recording = next(pinches.glob("*.mcap"))
    ended = run("live", "--device", f"bad:{recording}", "--speed", "inf")
    if method == "unused":
        assert ended == 0
    else:
        assert ended in FAILED
        refused(capsys)


OUTPUT = """
from firstcontact.streaming import Sink
from firstcontact.streaming.outputs import OutputKind
class Bad(Sink):
    name, every = "bad", 0.1
    def {method}(self, *arguments):
        raise ValueError("no")
ENTRY = OutputKind("bad", lambda session, options: {made})
"""


@pytest.mark.parametrize(
    ("method", "made", "reason"),
    [
        ("__init__", "Bad()", "the plug-in 'bad'"),
        ("unused", "5", "int is not a sink"),
        ("open", "Bad()", "outputs failed: bad (ValueError: no)"),
        ("take", "Bad()", "outputs failed: bad (ValueError: no)"),
    ],
)
def test_an_output_that_fails_is_named(method, made, reason, install, pinches, capsys):
    install(OUTPUT.format(method=method, made=made))
    device = ("--device", next(pinches.glob("*.mcap")), "--speed", "inf")
    assert run("live", *device, "--output", "bad") == 2
    refused(capsys, reason)


def test_two_outputs_do_not_share_standard_output(pinches, capsys):
    device = ("--device", next(pinches.glob("*.mcap")), "--speed", "inf")
    assert run("live", *device, "--json", "--output", "text") == 2
    refused(capsys, "json and text")
    assert run("live", *device, "--json", "--output", "json") == 0


HAND = """
from math import inf
from pathlib import Path
from firstcontact.grasp.hand import Begins, Hand, HandLimits
from firstcontact.grasp.policy import Policy
class Both:
    name = title = "bad"
class Diary(Hand):
    name, real, begins = "bad", False, Begins.OTHERS
    limits = HandLimits(0.2, 10.0, 1e6, inf)
    def __init__(self, port=None):
        self.path = Path(port)
    def say(self, word):
        with self.path.open("a") as file:
            print(word, file=file)
        if word == {word!r}:
            raise ValueError("no")
    def send(self, command):
        self.say("send")
    def release(self):
        self.say("release")
    def close(self):
        self.say("close")
    def __enter__(self):
        self.say("enter")
        return self
class Wild(Policy):
    name = title = "bad"
    def begin(self):
        if {word!r} == "begin":
            raise ValueError("no")
        return self.grip.gentle
"""


@pytest.mark.parametrize("word", ["", "enter", "send", "release", "close", "begin"])
def test_the_hand_is_released_whatever_it_or_its_policy_raises(
    word, install, pinches, tmp_path, capsys
):
    code = HAND.format(word=word)
    install(code, entry="Diary", groups="firstcontact.hands")
    install(code, entry="Wild", groups="firstcontact.policies")
    device = ("--device", next(pinches.glob("*.mcap")), "--speed", "inf")
    diary = tmp_path / "diary"
    hand = ("--hand", "bad", "--hand-port", diary, "--policy", "bad")
    ended = run("live", *device, *hand)
    if word:
        assert ended in FAILED
        refused(capsys)
    else:
        assert ended == 0
    words = diary.read_text().splitlines()
    assert words[-1] == "close"
    if word != "enter":
        assert words[-2] == "release"


def test_one_that_ends_the_process_is_no_success(install, pinches, tmp_path, capsys):
    install(EXPORTER.replace('ValueError("no")', "SystemExit(0)"))
    assert run("export", pinches, "--to", "bad", "--out", tmp_path / "out") == 2
    assert "SystemExit: 0" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
