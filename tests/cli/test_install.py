"""The built wheel and sdist, installed into empty environments."""

import os
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PIP = ("-m", "pip", "--disable-pip-version-check", "--quiet")
BUILD = (
    "import sys; from setuptools import build_meta; getattr(build_meta, sys.argv[1])(sys.argv[2])"
)
#: Without PYTHONPATH, in which pip would find a checkout's package as installed.
ENVIRONMENT = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
pytestmark = pytest.mark.slow


def tracked(*paths: str) -> list[str]:
    """Return the files below these paths that Git tracks or would track."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", *paths]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, check=True).stdout.decode()
    return [name for name in names.split("\0") if (ROOT / name).is_file()]


def build(kind: str, source: Path, out: Path) -> Path:
    """Build a wheel or an sdist with this environment's setuptools."""
    command = [sys.executable, "-c", BUILD, f"build_{kind}", out]
    subprocess.run(command, check=True, cwd=source, stdout=subprocess.DEVNULL)
    (built,) = out.glob("firstcontact-*.whl" if kind == "wheel" else "firstcontact-*.tar.gz")
    return built


def installed(folder: Path, file: str) -> Path:
    """Return the ``bin`` folder of a fresh environment after ``pip install FILE``."""
    venv.create(folder, with_pip=True, symlinks=True)
    install = [folder / "bin" / "python", *PIP, "install", "-c", ROOT / "constraints.txt", file]
    subprocess.run(install, check=True, cwd=folder, env=ENVIRONMENT)
    return folder / "bin"


@pytest.fixture(scope="module")
def wheel_and_sdist(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return a wheel and an sdist, built in a copy: building leaves files behind."""
    folder = tmp_path_factory.mktemp("built")
    source = folder / "source"
    for name in tracked():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, source / name)
    return build("wheel", source, folder), build("sdist", source, folder)


@pytest.fixture(scope="module")
def base(wheel_and_sdist: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the ``bin`` folder of an environment with the wheel and no extra."""
    return installed(tmp_path_factory.mktemp("base"), str(wheel_and_sdist[0]))


@pytest.fixture(scope="module")
def live(wheel_and_sdist: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the ``bin`` folder of an environment with the sdist and the extra for live."""
    return installed(tmp_path_factory.mktemp("live"), f"{wheel_and_sdist[1]}[live]")


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_wheel_has_the_kernels_and_only_the_c_sources_that_are_exported(
    wheel_and_sdist: tuple[Path, Path],
) -> None:
    wheel, _ = wheel_and_sdist
    endings = (".c", ".h", ".ino", "export/c/README.md")
    sources = {Path(name) for name in contents(wheel) if name.endswith(endings)}
    exported = ROOT / "src" / "firstcontact" / "export" / "c"
    expected = {Path("firstcontact/export/c", path.name) for path in exported.iterdir()}
    shared = ROOT / "src"
    expected |= {path.relative_to(shared) for path in shared.glob("firstcontact/c/chain/*")}
    expected |= {Path("firstcontact/c/wire", f"fc_crc32.{suffix}") for suffix in "ch"}
    assert sources == expected
    compiled = {f"firstcontact/{room}/_compiled.abi3.so" for room in ("chain", "device", "twin")}
    assert {name for name in contents(wheel) if name.endswith(".so")} == compiled
    assert wheel.stem.split("-")[2:4] == ["cp311", "abi3"]


def test_the_sdist_has_what_readers_need_and_no_tests(wheel_and_sdist: tuple[Path, Path]) -> None:
    with tarfile.open(wheel_and_sdist[1]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert set(tracked("CHANGELOG.md", "docs", "examples", "firmware")) <= names
    assert not any(name.startswith("tests") for name in names)


def test_the_sdist_installs_what_the_wheel_has(
    live: Path, wheel_and_sdist: tuple[Path, Path]
) -> None:
    (site,) = live.parent.glob("lib/*/site-packages")
    expected = contents(wheel_and_sdist[0])
    package = {name for name in expected if ".dist-info" not in name}
    files = (path for path in site.glob("firstcontact*/**/*.*") if ".dist-info" not in str(path))
    assert {f.relative_to(site).as_posix() for f in files if f.suffix != ".pyc"} == package
    package = {n for n in package if not n.endswith(".abi3.so")}  # they name their build folder
    assert all((site / name).read_bytes() == expected[name] for name in package)


@pytest.mark.parametrize("environment", ["base", "live"])
def test_the_installed_kernels_predict_a_live_pinch(
    environment: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    scripts = request.getfixturevalue(environment)
    rooms = ("chain", "device", "twin")
    loaded = "".join(f"import firstcontact.{room}._compiled; " for room in rooms)
    subprocess.run([scripts / "python", "-I", "-c", loaded], check=True, cwd=tmp_path)
    page = ("--page", "--port", "0") if environment == "live" else ()
    process = run(scripts, "live", "--device", "twin", "--pinches", "1", *page, cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert "Shore A" in process.stdout
    assert "compile" not in process.stderr


def run(scripts: Path, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [scripts / "firstcontact", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env=ENVIRONMENT,
    )


def test_help_needs_no_extra(base: Path, tmp_path: Path) -> None:
    process = run(base, "--help", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert "simulate" in process.stdout


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (["live", "--device", "twin", "--page"], "live"),
        (["study", "--out", "out"], "study"),
    ],
    ids=["live", "study"],
)
def test_a_missing_extra_is_one_sentence_and_exit_2(
    base: Path, tmp_path: Path, arguments: list[str], extra: str
) -> None:
    process = run(base, *arguments, cwd=tmp_path)
    assert process.returncode == 2
    assert process.stderr.count("\n") == 1
    assert f".[{extra}]" in process.stderr
    assert list(tmp_path.iterdir()) == []


def test_importing_and_looking_need_no_extra(base: Path, tmp_path: Path) -> None:
    example = [base / "python", ROOT / "examples" / "own_arrays.py"]
    subprocess.run(example, check=True, cwd=tmp_path, capture_output=True)
    for arguments in (
        ["import", "own.npz", "--out", "own"],
        ["inspect", "own/000_monday.mcap"],
        ["export", "own", "--to", "csv", "--out", "own.csv"],
    ):
        process = run(base, *arguments, cwd=tmp_path)
        assert process.returncode == 0, process.stderr
