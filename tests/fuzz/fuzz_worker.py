"""Worker process that runs inputs one after another and prints their results."""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable
from pathlib import Path

from fuzz_seeds import Seeds
from fuzz_ways import REFUSALS, make_case

from firstcontact.cli.main import main

#: An input may take so much time of a processor, s, and so much memory more, bytes.
SECONDS = 5.0
MEMORY = 400 << 20
#: What is refused by the system, beyond what the process has at the beginning, bytes.
ADDRESSES = 3 << 30
#: Longest sentence that is one.
SENTENCE = 4000
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")

#: What an input came to: its codes, and what is wrong with them, one sentence each.
Outcome = tuple[list[int], list[str]]


def work(
    seed: int, numbers: Iterable[int], seeds: Seeds, place: Path, say: Callable[[str], None]
) -> None:
    """Run inputs. Print the number of each before it starts, then its result, as JSON lines.

    If an input used too much memory, the worker ends early, because a new process measures the
    memory of the next inputs better.
    """
    os.environ["XDG_STATE_HOME"] = str(place / "state")
    os.environ["TMPDIR"] = str(place)
    text = _capture()
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + ADDRESSES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for number in numbers:
        say(json.dumps({"began": number}))
        folder = place / f"input-{number}"
        began = time.process_time()
        route, codes, wrong = run_one(seed, number, seeds, folder, text)
        took = time.process_time() - began
        shutil.rmtree(folder, ignore_errors=True)
        ended = {"ended": number, "route": route, "codes": codes, "wrong": wrong, "took": took}
        say(json.dumps(ended))
        if any("memory" in sentence for sentence in wrong):
            return


def run_one(
    seed: int, number: int, seeds: Seeds, folder: Path, text: Callable[[], tuple[str, str]]
) -> tuple[str, list[int], list[str]]:
    """Make an input in a new folder and run it."""
    folder.mkdir()
    codes: list[int] = []
    wrong: list[str] = []
    try:
        case = make_case(seed, number, seeds, folder)
    except Exception:
        return "?", codes, [f"the fuzzer failed: {traceback.format_exc()[-600:]}"]
    resident = _resident()
    for call in case.calls:
        codes.append(_call(call, wrong))
    for words in case.commands:
        codes.append(_command(words, folder, text, wrong))
    if _resident() - resident > MEMORY:
        wrong.append(f"memory: {(_resident() - resident) >> 20} MiB more")
    return case.route, codes, wrong


def _call(call: Callable[[], None], wrong: list[str]) -> int:
    began = time.process_time()
    try:
        call()
    except REFUSALS:
        return 2
    except BaseException as error:
        wrong.append(_raised(error))
        return 70
    finally:
        _in_time(began, wrong)
    return 0


def _command(
    words: list[str],
    folder: Path,
    text: Callable[[], tuple[str, str]],
    wrong: list[str],
) -> int:
    original = _files(folder)
    began = time.process_time()
    text()
    try:
        code = main(words)
    except SystemExit as left:
        code = left.code if isinstance(left.code, int) else 1
    except BaseException as error:
        wrong.append(_raised(error))
        code = 70
    _in_time(began, wrong)
    _threads(wrong)
    out, err = text()
    if code not in (0, 2):
        wrong.append(f"exit code {code}: {err[-300:].strip()!r}{_logged(folder)}")
    if code == 2 and _files(folder) != original:
        left_over = sorted(set(_files(folder).items()) ^ set(original.items()))
        wrong.append(f"half-written: {left_over[:3]}")
    if code == 2:
        sentences = [line for line in err.splitlines() if line.startswith("firstcontact: ")]
        if len(sentences) != 1 or not err.endswith(sentences[0] + "\n"):
            wrong.append(f"not one sentence: {err[-300:]!r}")
        elif len(sentences[0]) > SENTENCE:
            wrong.append(f"a sentence of {len(sentences[0])} characters: {sentences[0][:200]!r}")
    for name in _files(folder):
        if ".part" in name:
            wrong.append(f"left behind: {name}")
    if "Traceback" in err or re.search(r"^\S+:\d+: \w*Warning", err, re.MULTILINE):
        wrong.append(f"on standard error: {err[-600:]!r}")
    match = _CONTROL.search(out.replace("\r\n", "\n") + err.replace("\r", "\n"))
    if match:
        location = (out + err)[max(0, match.start() - 40) : match.start() + 20]
        wrong.append(f"control character in {words[0]}: {location!r}")
    if "--json" in words:
        _json_lines(out, wrong)
    return code


def _json_lines(out: str, wrong: list[str]) -> None:
    def refuse(name: str) -> None:
        raise ValueError(name)

    for line in out.splitlines():
        try:
            json.loads(line, parse_constant=refuse)
        except ValueError as error:
            wrong.append(f"a line that is no JSON ({error}): {line[:200]!r}")
            return


def _in_time(began: float, wrong: list[str]) -> None:
    took = time.process_time() - began
    if took > SECONDS:
        wrong.append(f"slow: {took:.1f} s of a processor")


def _threads(wrong: list[str]) -> None:
    for thread in threading.enumerate():
        if thread is not threading.main_thread():
            thread.join(3)
            if thread.is_alive() and not thread.daemon:
                wrong.append(f"a thread goes on: {thread.name}")


def _raised(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "/firstcontact/" in f.filename]
    at = ours[-1] if ours else frames[-1]
    location = f"{Path(at.filename).name}:{at.lineno} in {at.name}"
    return f"raised {type(error).__name__} at {location}: {str(error)[:200]!r}"


def _logged(folder: Path) -> str:
    """Return the end of the log of an unexpected error."""
    logs = sorted((folder.parent / "state").rglob("*.log"))
    if not logs:
        return ""
    text = logs[-1].read_text(errors="replace")
    for log in logs:
        log.unlink()
    frames = re.findall(r'File ".*?/(firstcontact/[^"]+)", line (\d+), in (\w+)', text)
    return f" at {' '.join(frames[-1]) if frames else '?'}: {text.strip().splitlines()[-1][:200]}"


def _files(folder: Path) -> dict[str, tuple[int, int]]:
    """Return size and modification time of every file in a folder."""
    collected = {}
    for above, _, names in os.walk(folder):
        for file in (Path(above) / name for name in names):
            state = file.lstat()
            collected[str(file.relative_to(folder))] = state.st_size, state.st_mtime_ns
    return collected


def _resident() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _capture() -> Callable[[], tuple[str, str]]:
    """Keep standard output and error in memory. Return a function that reads the new part."""
    files = [os.memfd_create(name) for name in ("out", "err")]
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for number, file in zip((1, 2), files, strict=True):
        os.dup2(file, number)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", closefd=False, buffering=1)  # noqa: SIM115

    def captured() -> tuple[str, str]:
        texts = []
        for stream, file in zip((sys.stdout, sys.stderr), files, strict=True):
            stream.flush()
            size = os.fstat(file).st_size
            texts.append(os.pread(file, size, 0).decode(errors="surrogateescape"))
            os.ftruncate(file, 0)
            os.lseek(file, 0, os.SEEK_SET)
        return texts[0], texts[1]

    return captured
