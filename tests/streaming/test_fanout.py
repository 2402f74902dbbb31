"""Slow or failing sinks: they do not delay others, and their lost events are counted."""

import threading

from streams import LONG, Keeper

from firstcontact.core import fingertip_layout
from firstcontact.device import Descriptor
from firstcontact.streaming import Update
from firstcontact.streaming._sinks import WAITING, Fanout

DESCRIPTOR = Descriptor(fingertip_layout())


class Raiser(Keeper):
    def take(self, update: Update) -> None:
        super().take(update)
        raise RuntimeError("a viewer's fault")


def updates(n: int) -> list[Update]:
    return [Update(ledger={"number": float(i)}) for i in range(n)]


def test_a_stuck_sink_loses_the_oldest_and_nobody_else_anything() -> None:
    go_on = threading.Event()
    stuck, quick = Keeper("stuck", go_on), Keeper("quick")
    fanout = Fanout([stuck, quick], DESCRIPTOR)
    sent = updates(3 * WAITING)
    fanout.put(sent[0])
    assert stuck.taking.wait(LONG)
    for update in sent[1:]:
        fanout.put(update)
    dropped = fanout.dropped["stuck"]
    go_on.set()
    fanout.close(LONG)
    assert dropped == len(sent) - 1 - WAITING
    assert stuck.updates == [sent[0], *sent[-WAITING:]]
    # What the quick one got depends on its thread; what it lost is counted.
    assert len(quick.updates) + fanout.dropped["quick"] == len(sent)


def test_a_raising_sink_is_told_and_left_out() -> None:
    raiser, other = Raiser("raiser"), Keeper("other")
    fanout = Fanout([raiser, other], DESCRIPTOR)
    sent = updates(10)
    for update in sent:
        fanout.put(update)
    fanout.close(LONG)
    assert other.updates == sent
    assert len(raiser.updates) == 1
    assert raiser.order == ["open", "close"]
    assert fanout.failed == {"raiser": "RuntimeError: a viewer's fault"}
    assert fanout.dropped["raiser"] == len(sent) - 1


def test_closing_does_not_wait_for_ever() -> None:
    go_on = threading.Event()
    stuck = Keeper("stuck", go_on)
    fanout = Fanout([stuck], DESCRIPTOR)
    fanout.put(Update())
    assert stuck.taking.wait(LONG)
    for update in updates(7):
        fanout.put(update)
    fanout.close(0.01)
    assert stuck.order == ["open"]
    # What it did not take in time is no silent loss.
    assert fanout.dropped == {"stuck": 7}
    go_on.set()
    fanout.close(LONG)
    assert stuck.order == ["open", "close"]


def test_who_is_patient_loses_nothing() -> None:
    go_on = threading.Event()
    slow = Keeper("slow", go_on)
    fanout = Fanout([slow], DESCRIPTOR, patient=True)
    sent = updates(3 * WAITING)
    feeding = threading.Thread(target=lambda: [fanout.put(update) for update in sent])
    feeding.start()
    assert slow.taking.wait(LONG)
    go_on.set()
    feeding.join(LONG)
    fanout.close()
    assert slow.updates == sent
    assert fanout.dropped == {"slow": 0}


def test_patience_ends_with_a_stop() -> None:
    go_on, stopped = threading.Event(), threading.Event()
    stuck = Keeper("stuck", go_on)
    fanout = Fanout([stuck], DESCRIPTOR, patient=True, stopped=stopped.is_set)
    sent = updates(3 * WAITING)
    feeding = threading.Thread(target=lambda: [fanout.put(update) for update in sent])
    feeding.start()
    assert stuck.taking.wait(LONG)
    feeding.join(0.1)
    assert feeding.is_alive()
    stopped.set()
    feeding.join(LONG)
    fanout.close(0.01)
    assert stuck.order == ["open"]
    assert fanout.dropped == {"stuck": len(sent) - 1}
    go_on.set()
    fanout.close(LONG)
