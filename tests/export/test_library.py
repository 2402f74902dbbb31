"""The exported folder is a valid Arduino library, and its example compiles."""

import re
import shutil
import subprocess
from pathlib import Path

import building
import numpy as np
import pytest
from test_model_parity import learned

from firstcontact import sample
from firstcontact.chain import Image
from firstcontact.core import InputError
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.models import ESTIMATORS, Model, Task
from firstcontact.models.model import shipped_model
from random_chains import python_events, random_stream

STUB = Path(__file__).parents[2] / "firmware" / "teensy" / "stub"


@pytest.fixture(scope="module", params=["network", "svm"])
def library(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    model = shipped_model()
    if request.param == "svm":
        model = Model(model.detector, (learned(ESTIMATORS.default, Task.REGRESSION),))
    MODEL_EXPORTERS["c"].write(model, folder)
    return folder


def test_it_is_a_library(library: Path) -> None:
    properties = (library / "library.properties").read_text(encoding="utf-8")
    conditioned_on = dict(line.split("=", 1) for line in properties.splitlines())
    assert {"name", "version", "architectures", "url"} <= set(conditioned_on)
    names = {path.name for path in (library / "src").iterdir()}
    for path in (library / "src").iterdir():
        assert set(re.findall(r'#include "(.*)"', path.read_text(encoding="utf-8"))) <= names


def test_no_file_of_it_asks_for_memory_or_calls_itself(library: Path) -> None:
    for path in (library / "src").glob("*.c"):
        assert not re.search(r"\b(malloc|calloc|realloc|free|alloca)\b", path.read_text("utf-8"))


def test_its_example_compiles_against_the_stub(
    request: pytest.FixtureRequest, library: Path, tmp_path: Path
) -> None:
    if not shutil.which(f"{building.ARM}g++"):
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi is not installed")
    made = tmp_path / "cycles.o"
    building.run(
        [f"{building.ARM}g++", "-std=gnu++17", *building.WARN[1:], *building.PLAIN, *building.M7,
         "-nostdinc++", "-fno-exceptions", "-fno-rtti", f"-I{STUB}", f"-I{library / 'src'}",
         "-include", "Arduino.h", "-x", "c++", "-c", str(library / "examples/cycles/cycles.ino"),
         "-o", str(made)]
    )  # fmt: skip
    called = re.findall(r"U (\w*fc_\w+)", building.run([f"{building.ARM}nm", "-u", str(made)]))
    assert called
    assert all(name.startswith("fc_") for name in called)


def test_its_main_loop_finds_the_contact_and_predicts(library: Path, tmp_path: Path) -> None:
    command = re.search(r"`(cc .*)`", (library / "README.md").read_text(encoding="utf-8"))
    subprocess.run(f"{command[1]} -Wall -Wextra -Werror", shell=True, cwd=library, check=True)
    pinch = sample("paper-rig")[0]
    lines = "\n".join(f"{index:.6f} {thumb:.6f}" for index, thumb in pinch.vibration())
    process = subprocess.run(
        [library / "loop"], input=lines, capture_output=True, text=True, check=True
    )
    assert re.search(r"^contact \d+\n", process.stdout)
    assert re.search(r"^estimate [\d.]+ \([\d.-]+ to [\d.]+\)$", process.stdout, re.MULTILINE)


@pytest.mark.parametrize("header", ["fc_chain.h", "fc_image.h"])
def test_cpp_links_with_all_functions_of_a_header(tmp_path: Path, header: str) -> None:
    folders = building.INCLUDE
    text = building.run(["cc", "-E", "-P", *folders, str(building.SHARED / "chain" / header)])
    names = set(re.findall(r"^[^({=]*\b(fc_\w+)\([^{}]*?\);", text, re.MULTILINE))
    assert {"fc_image_read", "fc_touch_predict", "fc_svm_predict", "fc_gate_take"} <= names
    source = tmp_path / "main.cpp"
    pointers = ", ".join(f"(void *)&{name}" for name in sorted(names))
    source.write_text(
        f'#include "{header}"\nvoid *all[] = {{{pointers}}};\n'
        "int main() { return all[0] == nullptr; }\n"
    )
    command = ["cc", *building.WARN, *building.PLAIN, *folders]
    objects = [building.compiled(command, path) for path in building.CHAIN]
    program = str(tmp_path / "program")
    building.run(["c++", *folders, str(source), *objects, "-lm", "-o", program])
    building.run([program])


@pytest.mark.parametrize("machine", ["-mthumb -mcpu=cortex-m7", "-marm -march=armv7-a+simd"])
def test_its_network_compiles_for_instruction_sets_of_arm(
    request: pytest.FixtureRequest, library: Path, tmp_path: Path, machine: str
) -> None:
    if not shutil.which(f"{building.ARM}gcc"):
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi is not installed")
    building.run(
        [f"{building.ARM}gcc", "-O2", *machine.split(), "-mfloat-abi=hard",
         "-c", str(library / "src/fc_network.c"), "-o", str(tmp_path / "network.o")]
    )  # fmt: skip


def exported_image(library: Path) -> Image:
    """Return the image in the exported array."""
    text = (library / "src/fc_model_image.c").read_text(encoding="utf-8")
    words = re.findall(r"0x[0-9a-f]+(?=u)", text)
    return Image(np.array([int(word, 16) for word in words], "<u8").tobytes())


def test_the_library_gives_the_events_of_python(library: Path, tmp_path: Path) -> None:
    image = exported_image(library)
    # Without the array, whose image comes as a file. The compiler still checks its header.
    sources = tmp_path / "src"
    shutil.copytree(library / "src", sources)
    rng = np.random.default_rng(3)
    streams = [random_stream(rng) for _ in range(200)]
    data = [
        building.Stream(s.pieces, s.floors if s.has_floors else None, s.alpha, s.hints)
        for s in streams
    ]
    binary = building.Program("streams.c", sources, {}).native(tmp_path / "streams")
    raw = building.ask_native(binary, building.streams(image.data, data), tmp_path)
    estimates = 0
    for stream, records in zip(streams, building.events(raw), strict=True):
        events = python_events(image, stream)
        estimates += sum(e.samples > 0 for e in events)
        wanted = np.array([e[7:] for e in events], np.float32).reshape(-1, 5)
        fields = ("value", "low", "high", "half_width", "spread")
        got = np.stack([records[:-1][name] for name in fields], axis=1)
        assert wanted.tobytes() == got.tobytes()
        assert [tuple(e[:7]) for e in events] == [tuple(r)[:7] for r in records[:-1].tolist()]
    assert estimates > 20


def test_a_detector_that_python_judges_has_no_form_in_c(tmp_path: Path) -> None:
    from firstcontact.contact import make_detector
    from firstcontact.testing import closings

    detector = make_detector("svm").fit(closings(12))
    with pytest.raises(InputError, match="svm"):
        MODEL_EXPORTERS["c"].write(Model(detector), tmp_path)
