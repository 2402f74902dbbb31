"""Program that sends an LSL stream with faults on request, and the function that starts it.

python lsl_outlet.py NAME RATE JITTER_MS

The stream has two channels: ``count``, the sample number modulo ``MODULUS``, and ``disc``, a piezo.
Time stamps have a jitter of JITTER_MS. The program reads requests from standard input, one a line.
``hold SECONDS`` delays samples but not their time stamps. ``lose COUNT`` omits samples.
``nan COUNT`` and ``huge COUNT`` send NaN or 1e300. ``rest`` stops the samples, and ``end`` ends the
program, as does the end of its input. Requests wait until a listener is connected. The program
prints ``ready``, ``heard`` when a listener is connected, and the number of the last sample after
``rest``.
"""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue

import numpy as np

MODULUS = 2**20  # float32 holds it


def start_outlet(name: str, rate: float = 4936.0, jitter: float = 0.0) -> subprocess.Popen[str]:
    """Start the program. It is ready for a listener."""
    words = [sys.executable, __file__, name, str(rate), str(jitter)]
    pipe = subprocess.PIPE
    outlet = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True)
    assert outlet.stdout.readline() == "ready\n"
    return outlet


@contextmanager
def sending(
    name: str, rate: float = 4936.0, jitter: float = 0.0
) -> Iterator[subprocess.Popen[str]]:
    with start_outlet(name, rate, jitter) as outlet:
        try:
            yield outlet
        finally:
            outlet.kill()


def ask(outlet: subprocess.Popen[str], request: str) -> None:
    """Send a request to the program."""
    assert outlet.stdin is not None
    print(request, file=outlet.stdin, flush=True)


def _listen(requests: SimpleQueue[list[str]]) -> None:
    for line in sys.stdin:
        requests.put(line.split())
    os._exit(0)  # the parent process has ended


def main(name: str, rate: float, jitter: float) -> None:
    import pylsl

    info = pylsl.StreamInfo(name, "Vibration", 2, rate, pylsl.cf_double64, f"{name} of a test")
    channels = info.desc().append_child("channels")
    for label, kind in (("count", "count"), ("disc", "piezo")):
        channel = channels.append_child("channel")
        for key, text in (("label", label), ("unit", "V"), ("type", kind)):
            channel.append_child_value(key, text)
    outlet = pylsl.StreamOutlet(info)
    requests: SimpleQueue[list[str]] = SimpleQueue()
    threading.Thread(target=_listen, args=(requests,), daemon=True).start()
    print("ready", flush=True)
    while not outlet.wait_for_consumers(0.5):
        pass
    print("heard", flush=True)
    rng = np.random.default_rng(0)
    zero, sent, is_resting, until = pylsl.local_clock(), 0, False, 0.0
    faults = {"lose": 0, "nan": 0, "huge": 0}  # samples that still get each fault
    while True:
        request = ""
        with suppress(Empty):
            request, *number = requests.get(timeout=0.005)
        now = pylsl.local_clock()
        if request:
            if request == "end":
                break
            if request == "hold":
                until = now + float(number[0])
            elif request == "rest":
                is_resting = True
                print(sent - 1, flush=True)
            else:
                faults[request] = int(number[0])
        due = int((now - zero) * rate)
        if is_resting or now < until or due == sent:
            continue
        numbers = np.arange(sent, due)
        sent = due
        rows = np.stack([numbers % MODULUS, np.sin(numbers / 50)], axis=1)
        stamps = zero + numbers / rate + 1e-3 * jitter * rng.standard_normal(len(numbers))
        begin = 0
        for fault, value in (("nan", np.nan), ("huge", 1e300), ("lose", 0.0)):
            end = min(begin + faults[fault], len(rows))
            faults[fault] -= end - begin
            rows[begin:end] = value
            if fault == "lose":
                rows, stamps = (
                    np.delete(rows, np.s_[begin:end], 0),
                    np.delete(stamps, np.s_[begin:end]),
                )
            begin = end
        if len(rows):
            outlet.push_chunk(rows.tolist(), stamps.tolist())


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]))
