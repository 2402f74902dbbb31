"""Program that sends numbered samples by LSL, with faults on request.

python soak_lsl_sender.py NAME RATE MODULUS

It reads requests from standard input, one per line. ``hold SECONDS`` delays samples but not their
time stamps. ``lose COUNT`` omits samples. ``nan COUNT`` and ``huge COUNT`` send NaN or 1e300.
``rest`` stops the samples, and ``end`` ends the program. Requests wait until a listener is
connected. The program prints ``ready``, ``heard`` when a listener is connected, and the number of
the last sample after ``rest``.
"""

import os
import sys
import threading
import time
from queue import SimpleQueue

import numpy as np
import pylsl

name, rate, modulus = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
info = pylsl.StreamInfo(name, "Vibration", 1, rate, pylsl.cf_double64, f"{name} of a soak")
channel = info.desc().append_child("channels").append_child("channel")
for key, text in (("label", "count"), ("unit", "V"), ("type", "piezo")):
    channel.append_child_value(key, text)
outlet = pylsl.StreamOutlet(info)
requests: SimpleQueue[list[str]] = SimpleQueue()


def listen() -> None:
    for line in sys.stdin:
        requests.put(line.split())
    os._exit(0)  # who asked is gone


threading.Thread(target=listen, daemon=True).start()
print("ready", flush=True)
while not outlet.wait_for_consumers(0.5):
    pass
print("heard", flush=True)
zero, sent, resting, until = pylsl.local_clock(), 0, False, 0.0
faults = {"lose": 0, "nan": 0, "huge": 0}
while True:
    time.sleep(0.005)
    now = pylsl.local_clock()
    if not requests.empty():
        request, *number = requests.get()
        if request == "end":
            break
        if request == "hold":
            until = now + float(number[0])
        elif request == "rest":
            resting = True
            print(sent - 1, flush=True)
        else:
            faults[request] = int(number[0])
    due = int((now - zero) * rate)
    if resting or now < until or due == sent:
        continue
    numbers = np.arange(sent, due)
    sent = due
    values = (numbers % modulus).astype(np.float64)
    is_sent = np.ones(len(numbers), bool)
    # Never the last sample of a chunk: one that can be counted follows.
    free = max(len(numbers) - 1, 0)
    for fault, count in faults.items():
        n = min(count, free)
        faults[fault] -= n
        free -= n
        if fault == "lose":
            is_sent[free : free + n] = False
        else:
            values[free : free + n] = np.nan if fault == "nan" else 1e300
    stamps = zero + numbers / rate
    outlet.push_chunk(values[is_sent, None].tolist(), stamps[is_sent].tolist())
