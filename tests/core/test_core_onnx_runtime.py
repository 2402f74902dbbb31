"""The CNN runs in ONNX Runtime and leaves nothing in the user's home."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
#: Variables that would place caches elsewhere, or switch telemetry off from outside.
ELSEWHERE = ("XDG_CACHE_HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME", "ORT_DISABLE_TELEMETRY")

NETWORK = """
import sys, numpy as np
from pathlib import Path
from firstcontact.models._network import Network

network = Network(Path(sys.argv[1]).read_bytes(), 74, 1, 1)
assert np.isfinite(network.run(np.ones((3, 1, 1, 74), dtype=np.float32))).all()
"""
#: A program that imported the library by itself; a worker process inherits the switch.
CHILD = (
    NETWORK
    + """
import subprocess
subprocess.run([sys.executable, "-c", "import onnxruntime"], check=True)
"""
)


@pytest.mark.parametrize("script", [NETWORK, CHILD], ids=["inference", "child process"])
def test_a_network_leaves_no_file_in_a_fresh_home(
    script: str, network_graph: bytes, tmp_path: Path
) -> None:
    graph, home = tmp_path / "graph.onnx", tmp_path / "home"
    graph.write_bytes(network_graph)
    home.mkdir()
    environment = {name: value for name, value in os.environ.items() if name not in ELSEWHERE}
    subprocess.run(
        [sys.executable, "-W", "error", "-c", script, str(graph)],
        env={**environment, "HOME": str(home)},
        check=True,
    )
    assert [path for path in home.rglob("*") if not path.is_dir()] == []


def test_only_one_place_imports_onnx_runtime() -> None:
    importers = [
        str(path.relative_to(ROOT))
        for folder in ("src", "tests", "docs", "examples", "benchmarks", "firmware")
        for path in (ROOT / folder).rglob("*.py")
        if any(
            line.split()[:2] in (["import", "onnxruntime"], ["from", "onnxruntime"])
            for line in path.read_text(encoding="utf-8").splitlines()
        )
    ]
    assert importers == ["src/firstcontact/core/_onnx_runtime.py"]
