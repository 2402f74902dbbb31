"""Program that offers an LSL stream: a ramp that counts its samples, and a signal.

python lsl_outlet.py NAME RATE JITTER_MS LOSE_AT LOSE

The count begins at 0. Stamps have a jitter of JITTER_MS. From sample LOSE_AT on, or once a line
arrives if LOSE_AT is "line", LOSE samples are not sent. The program prints "ready" when it sends,
and ends when its input ends.
"""

import sys
import threading
import time
from math import inf

import numpy as np
import pylsl

name, rate, jitter = sys.argv[1], *(float(a) for a in sys.argv[2:4])
lose_at, lose = inf if sys.argv[4] == "line" else float(sys.argv[4]), float(sys.argv[5])
info = pylsl.StreamInfo(name, "Vibration", 2, rate, pylsl.cf_double64, f"{name} of a test")
channels = info.desc().append_child("channels")
for label in ("count", "disc"):
    channel = channels.append_child("channel")
    channel.append_child_value("label", label)
    channel.append_child_value("unit", "V")
    channel.append_child_value("type", "piezo" if label == "disc" else "count")
outlet = pylsl.StreamOutlet(info)
lines, ended = threading.Event(), threading.Event()


def listen() -> None:
    for _ in sys.stdin:
        lines.set()
    ended.set()


threading.Thread(target=listen, daemon=True).start()
print("ready", flush=True)
rng = np.random.default_rng(0)
outlet.wait_for_consumers(30)
zero, count = pylsl.local_clock(), 0
while not ended.is_set():
    time.sleep(0.005)
    due = int((pylsl.local_clock() - zero) * rate)
    numbers = np.arange(count, due)
    if lines.is_set():
        lose_at = min(lose_at, count)
    numbers = numbers[(numbers < lose_at) | (numbers >= lose_at + lose)]
    count = due
    if len(numbers):
        stamps = zero + numbers / rate + 1e-3 * jitter * rng.standard_normal(len(numbers))
        rows = np.stack([numbers, np.sin(numbers / 50)], axis=1)
        outlet.push_chunk(rows.tolist(), stamps.tolist())
