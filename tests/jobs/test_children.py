"""Child processes end with their parent, however it ends."""

import os
import subprocess
import sys
from contextlib import contextmanager

import pytest

from firstcontact.jobs import Child
from processes import PATIENCE, gone, stop

#: Children that do not listen, each in a way of its own.
DEAF = {
    "sleeps": "import signal; signal.pause()",
    "is busy": "while True: pass",
    "keeps the lock": "import ctypes; ctypes.PyDLL(None).pause()",
    "holds signals back": (
        "import signal; [signal.signal(n, signal.SIG_IGN) for n in (1, 2, 3, 15)]; signal.pause()"
    ),
}
ECHO = "import sys\nfor line in sys.stdin: print('heard', line, end='', flush=True)"
PARENT = """
import sys, threading
from firstcontact.jobs import Child
made = []
# In a thread that ends: the child must not end with that.
thread = threading.Thread(target=lambda: made.append(Child("child")))
thread.start(); thread.join()
made[0].answer(60.0)
print(made[0].pid, flush=True)
sys.stdin.read()
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """The module ``child``, importable by processes. Each test writes its content."""
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    monkeypatch.setenv("PYTHONPATH", path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path / "child.py"


@contextmanager
def child(*options):
    process = Child("child", *options)
    try:
        yield process
    finally:
        process.end(0.0)


def test_lines_travel_in_both_directions(module):
    module.write_text(f"import sys; print(*sys.argv[1:], flush=True)\n{ECHO}")
    with child("--one", "two") as process:
        assert process.answer(PATIENCE) == "--one two"
        for line in ("a", "übung", "x" * 100_000):
            process.tell(line, PATIENCE)
            assert process.answer(PATIENCE) == f"heard {line}"
        assert os.getsid(process.pid) != os.getsid(0), "not in the group that the terminal signals"
        assert process.end(PATIENCE), "by itself"
        assert gone(process.pid)
        assert process.end(PATIENCE)
        with pytest.raises(OSError, match="ended"):
            process.tell("more", 1.0)
        with pytest.raises(OSError, match="ended"):
            process.answer(1.0)


def test_crash_of_a_child_raises(module):
    module.write_text("raise SystemExit(3)")
    with child() as process, pytest.raises(BrokenPipeError):
        process.answer(PATIENCE)


@pytest.mark.parametrize("words", DEAF.values(), ids=DEAF)
def test_deaf_child_times_out_and_is_ended(module, words):
    module.write_text(f"print('ready', flush=True)\n{words}")
    with child() as process:
        assert process.answer(PATIENCE) == "ready"
        with pytest.raises(TimeoutError):
            process.answer(0.01)
        with pytest.raises(TimeoutError):
            process.tell("x" * 1_000_000, 0.01)
        assert not process.end(0.01)
        assert gone(process.pid)


@pytest.mark.parametrize(
    ("words", "is_stopped"),
    [(DEAF["is busy"], False), (DEAF["keeps the lock"], False), (DEAF["sleeps"], True)],
)
def test_children_die_with_a_killed_parent(module, words, is_stopped):
    module.write_text(f"print('ready', flush=True)\n{words}")
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", PARENT], stdin=pipe, stdout=pipe) as parent:
        pid = int(parent.stdout.readline())
        if is_stopped:
            stop(pid)
        parent.kill()
        assert gone(pid)


def test_child_ignores_modules_of_the_working_folder(module, tmp_path_factory, monkeypatch):
    module.write_text(ECHO)
    folder = tmp_path_factory.mktemp("user")
    folder.joinpath("lazy_loader.py").write_text("raise SystemExit('of the user')")
    monkeypatch.chdir(folder)
    with child() as process:
        process.tell("hello", PATIENCE)
        assert process.answer(PATIENCE) == "heard hello"


def test_suspended_child_with_wakes_is_continued(module):
    proof = module.with_name("done")
    module.write_text(
        f"import sys, pathlib\nprint('ready', flush=True)\nsys.stdin.read()\n"
        f"pathlib.Path({str(proof)!r}).touch()\n"
    )
    code = PARENT.replace('Child("child")', 'Child("child", wakes=True)')
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", code], stdin=pipe, stdout=pipe) as parent:
        pid = int(parent.stdout.readline())
        stop(pid)
        parent.kill()
        assert gone(pid)
    assert proof.exists()
