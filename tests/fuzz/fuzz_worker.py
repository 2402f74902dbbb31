"""Worker process that runs inputs one after another and writes their results."""

import faulthandler
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
from fuzz_ways import make_case

from firstcontact.cli.main import main
from firstcontact.core import InputError

#: An input that takes longer hangs, s.
HANGS = 30.0
#: Limits of an input: time of a processor, s, and additional memory, bytes.
SECONDS = 5.0
MEMORY = 400 << 20
#: Memory that the system refuses, beyond what the process has at the beginning, bytes.
ADDRESSES = 3 << 30
#: Longest message, characters.
SENTENCE = 4000
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def work(seed: int, numbers: Iterable[int], seeds: Seeds, place: Path) -> None:
    """Run inputs. Write a JSON line for each into the file ``results``.

    If an input used too much memory, the worker ends early, because a new process measures the
    memory of the next inputs better.
    """
    place.mkdir()
    os.environ["XDG_STATE_HOME"] = str(place / "state")
    os.environ["TMPDIR"] = str(place)
    text = _capture()
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + ADDRESSES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with (place / "results").open("w", buffering=1) as results:
        for number in numbers:
            folder = place / f"input-{number}"
            faulthandler.dump_traceback_later(HANGS, exit=True)
            route, codes, wrong = _run(seed, number, seeds, folder, text)
            faulthandler.cancel_dump_traceback_later()
            shutil.rmtree(folder, ignore_errors=True)
            result = {"number": number, "route": route, "codes": codes, "wrong": wrong}
            print(json.dumps(result), file=results)
            if any("memory" in sentence for sentence in wrong):
                return


def _run(
    seed: int, number: int, seeds: Seeds, folder: Path, text: Callable[[], tuple[str, str]]
) -> tuple[str, list[int], list[str]]:
    """Make an input in a new folder and run it. Return its route, exit codes and findings."""
    folder.mkdir()
    wrong: list[str] = []
    try:
        case = make_case(seed, number, seeds, folder)
    except Exception:
        return "?", [], [f"the fuzzer failed: {traceback.format_exc()[-600:]}"]
    resident = _resident()
    codes = [_timed(lambda call=call: _call(call, wrong), wrong) for call in case.calls]
    for words in case.commands:
        codes.append(_command(words, folder, text, wrong))
    if _resident() - resident > MEMORY:
        wrong.append(f"memory: {(_resident() - resident) >> 20} MiB more")
    return case.route, codes, wrong


def _timed(run: Callable[[], int], wrong: list[str]) -> int:
    began = time.process_time()
    try:
        return run()
    except BaseException as error:
        frames = traceback.extract_tb(error.__traceback__)
        at = ([f for f in frames if "/firstcontact/" in f.filename] or frames)[-1]
        location = f"{Path(at.filename).name}:{at.lineno} in {at.name}"
        wrong.append(f"raised {type(error).__name__} at {location}: {str(error)[:200]!r}")
        return 70
    finally:
        took = time.process_time() - began
        if took > SECONDS:
            wrong.append(f"slow: {took:.1f} s of a processor")


def _call(call: Callable[[], None], wrong: list[str]) -> int:
    try:
        call()
    except InputError:
        return 2
    return 0


def _main(words: list[str]) -> int:
    try:
        return main(words)
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else 1


def _command(
    words: list[str], folder: Path, text: Callable[[], tuple[str, str]], wrong: list[str]
) -> int:
    original = _files(folder)
    text()
    code = _timed(lambda: _main(words), wrong)
    for thread in threading.enumerate():
        if thread is not threading.main_thread():
            thread.join(3)
            if thread.is_alive() and not thread.daemon:
                wrong.append(f"a thread goes on: {thread.name}")
    out, err = text()
    if code not in (0, 2):
        wrong.append(f"exit code {code}: {err[-300:].strip()!r}{_logged(folder)}")
    if code == 2:
        if _files(folder) != original:
            left_over = sorted(set(_files(folder).items()) ^ set(original.items()))
            wrong.append(f"half-written: {left_over[:3]}")
        sentences = [line for line in err.splitlines() if line.startswith("firstcontact: ")]
        if len(sentences) != 1 or not err.endswith(sentences[0] + "\n"):
            wrong.append(f"not one sentence: {err[-300:]!r}")
        elif len(sentences[0]) > SENTENCE:
            wrong.append(f"a sentence of {len(sentences[0])} characters: {sentences[0][:200]!r}")
    wrong += [f"left behind: {name}" for name in _files(folder) if ".part" in name]
    if "Traceback" in err or re.search(r"^\S+:\d+: \w*Warning", err, re.MULTILINE):
        wrong.append(f"on standard error: {err[-600:]!r}")
    printed = out.replace("\r\n", "\n") + err.replace("\r", "\n")
    if match := _CONTROL.search(printed):
        location = printed[max(0, match.start() - 40) : match.start() + 20]
        wrong.append(f"control character in {words[0]}: {location!r}")
    if "--json" in words:
        wrong += _json_faults(out)
    return code


def _json_faults(out: str) -> list[str]:
    def refuse(name: str) -> None:
        raise ValueError(name)

    for line in out.splitlines():
        try:
            json.loads(line, parse_constant=refuse)
        except ValueError as error:
            return [f"a line that is no JSON ({error}): {line[:200]!r}"]
    return []


def _logged(folder: Path) -> str:
    """Return the end of the log of an unexpected error."""
    logs = sorted((folder.parent / "state").rglob("*.log"))
    texts = [log.read_text(errors="replace") for log in logs]
    for log in logs:
        log.unlink()
    frames = re.findall(r'File ".*?/(firstcontact/[^"]+)", line (\d+), in (\w+)', "".join(texts))
    return f" at {' '.join(frames[-1])}: {texts[-1].splitlines()[-1][:200]}" if frames else ""


def _files(folder: Path) -> dict[str, tuple[int, int]]:
    """Return size and modification time of every file in a folder."""
    states = {}
    for above, _, names in os.walk(folder):
        for file in (Path(above) / name for name in names):
            state = file.lstat()
            states[str(file.relative_to(folder))] = state.st_size, state.st_mtime_ns
    return states


def _resident() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _capture() -> Callable[[], tuple[str, str]]:
    """Keep standard output and error in memory. Return a function that reads the new part."""
    files = [os.memfd_create(name) for name in ("out", "err")]
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
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
