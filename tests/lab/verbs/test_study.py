"""``study`` and ``grasp-study``: exit codes, files, refusals and interrupts."""

import json
import os
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

import forked
from firstcontact.cli.main import main
from firstcontact.core import ArgumentError, InputError
from firstcontact_lab.verbs.study import Study


@pytest.fixture
def arrays(tmp_path: Path) -> Path:
    """Return the path of an archive: three materials of known rank, which ring differently."""
    rng = np.random.default_rng(0)
    levels = np.repeat([0, 1, 2], [14, 14, 12])
    piezo = 0.002 * rng.standard_normal((40, 900, 1))
    t = np.arange(400) / 4936.0
    for wave, level in zip(piezo, levels, strict=True):
        wave[500:, 0] += 0.3 * np.sin(2 * np.pi * (60 + 90 * level) * t) * np.exp(-t / 0.01)
    path = tmp_path / "pinches.npz"
    np.savez(
        path,
        piezo=piezo,
        hardness_rank=levels,
        object=np.array(["mat", "box", "desk"])[levels],
        session=np.array(["a", "b"] * 20),
        first_contact=np.full(40, 500),
        sample_rate_hz=4936.0,
        piezo_unit="V",
    )
    return path


def start(path: Path, out: Path, *words: str) -> forked.Program:
    arguments = ["study", "--quick", "--recordings", path, "--out", out, *words]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return forked.Program("command", *arguments, start_new_session=True, **streams)


def test_a_study_of_arrays_writes_both_files(arrays: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start(arrays, out, "--workers", "1", "--parts", "hardness")
    stdout, stderr = process.communicate()
    assert process.returncode == 0, stderr
    assert stdout.strip() == str(out / "report.html")
    assert stderr.endswith("100 % done\n")
    assert "\r" not in stderr
    tree = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert tree["study"]["complete"]
    assert tree["hardness_order"]["spectral_centroid"]["n"] == 3
    assert "--quick" in tree["study"]["command"]
    assert "blocks" not in tree


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_all_processes_and_keeps_the_report(
    arrays: Path, tmp_path: Path, number: signal.Signals
) -> None:
    out = tmp_path / "out"
    process = start(arrays, out)
    # The bar names the second part once the first has been written.
    seen = ""
    while "contact detection" not in seen:
        part = os.read(process.stderr.fileno(), 4096).decode("utf-8", "replace")
        assert part, seen
        seen += part
    if number is signal.SIGTERM:
        process.send_signal(number)
    else:
        os.killpg(process.pid, number)  # as a terminal does: workers get it too
    process.communicate()
    assert process.returncode == 128 + number
    assert not living_in_group(process.pid)
    tree = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert not tree["study"]["complete"]
    assert "Interrupted." in (out / "report.html").read_text(encoding="utf-8")
    assert not list(out.glob(".*.part"))


def living_in_group(group: int) -> list[str]:
    """Return the processes of a group that are not ending."""
    exiting = 0x4  # PF_EXITING of the Linux kernel
    collected = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = stat.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        fields = text.rsplit(")", 1)[1].split()
        if int(fields[2]) == group and not int(fields[6]) & exiting:
            collected.append(text)
    return collected


def test_settings_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    for seed in (-1, 1 << 32):
        with pytest.raises(InputError) as refused:
            Study(seed=seed, out=tmp_path / "out").run()
        assert refused.value.parameter == "seed"
    with pytest.raises(InputError, match="--early-ms"):
        Study(early_ms=50.0).run()
    for parts in ((), ("continuum",)):
        with pytest.raises(InputError, match="waveforms"):
            Study(waveforms=tmp_path / "waveforms.npz", parts=parts).run()
    for workers in (-1, 100_000):
        with pytest.raises(ArgumentError) as refused:
            Study(workers=workers).run()
        assert refused.value.parameter == "workers"


@pytest.mark.parametrize("name", ["not_there_at_all:Loud", ":Loud", "own_regressor"])
def test_an_unknown_regressor_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be imported|no estimator is called"):
        Study(estimator=(name,), out=tmp_path / "out").run()
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("option", "value"), [("--seed", "-1"), ("--workers", "100000")])
def test_numbers_that_make_no_sense_are_refused(
    option: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["grasp-study", option, value, "--out", str(tmp_path / "x")]) == 2
    assert option in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
