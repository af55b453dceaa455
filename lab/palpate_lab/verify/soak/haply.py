"""How soon is the force zero when Haply's service fails? The driver beside a stand-in in a process of its own."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from palpate import _core
from palpate.base.errors import DeviceError
from palpate.scene import Scene
from palpate.scene.haply import HaplySection
from palpate.session import Session

LIMIT = 0.02
"""Time from a fault to zero force that is asked for [s]."""
FAULTS = {
    "hang": "did not answer in time",
    "late": "did not answer in time",
    "slow": "did not answer in time",
    "malformed": "no valid state",
    "ebrake": "emergency brake",
    "stall": "motor stalled",
    "uncalibrated": "not calibrated",
    "unplug": "vanished",
    "disconnect": "closed the connection|connection to the service is broken",
    "killed": "closed the connection|connection to the service is broken",
}
"""What fails, and how the summary of the session names it.

`late`: the service answers 20 ms late, and a message acts when it arrives. `slow`: each message takes it 20 ms, one
after the other, and acts at the end.
"""
_ENDS = {"unplug", "disconnect", "killed"}  # what ends a session
_UNSEEN = {"hang", "disconnect", "killed"}  # nobody is there to read the zero: the motors are the device's own matter
_PASSES = {"stall"}  # faults after which the force returns by itself: its first zero counts, otherwise the last force
_PRESSED = 0.4  # force from which on a fault begins [N]
_PATIENCE = 30.0  # longest time that is waited for anything [s]
_AFTER = 0.2  # how long a fault lasts; the zero lies in it [s]
_PROCESSING = 0.02  # time that a slow service takes for each message [s]
_WINDOW = 0.008  # after which the driver counts an answer as missing: Device::kSilent [s]
_SCHEDULING = 0.005  # by which the threads of service and driver may wake late [s]
_IDLE = 10.0  # of the stand-in, so long that the zero is Palpate's [s]


@dataclass(frozen=True)
class Silence:
    """Times from one fault to zero force."""

    fault: str
    cases: int
    rendered_p50_ms: float  # until Palpate's cycle renders zero
    rendered_max_ms: float
    motors_p50_ms: float | None  # until zero has arrived at the motors; None: the service takes no message
    motors_max_ms: float | None
    bound_ms: float  # what the motors' zero can take at most, without late threads: see `bound`
    late: int  # cases above 20 ms; at the motors of a slow service, above the bound and 5 ms for late threads
    named: int  # cases whose session named the fault

    @property
    def bad(self) -> bool:
        """True if a force stayed longer than 20 ms, or a fault was not named."""
        return self.late > 0 or self.named < self.cases


def run(
    repeats: int, rate: float, faults: tuple[str, ...] = tuple(FAULTS), progress: Callable[[str], None] | None = None
) -> list[Silence]:
    """Let each fault happen `repeats` times while the device is pressed.

    Args:
        repeats: number of cases of each fault.
        rate: of the driver [Hz].
        faults: names of `FAULTS`.
        progress: called with the name of each fault before its first case.
    """
    found = []
    for fault in faults:
        if progress is not None:
            progress(fault)
        seen = [_case(fault, rate) for _ in range(repeats)]
        rendered, motors = (np.array([one[i] for one in seen], dtype=float) for i in (0, 1))
        late = rendered > LIMIT
        late |= motors > max(LIMIT, bound(fault, rate) + _SCHEDULING if fault == "slow" else 0.0)
        found.append(
            Silence(
                fault, repeats, 1e3 * float(np.median(rendered)), 1e3 * float(rendered.max()),
                None if fault in _UNSEEN else 1e3 * float(np.median(motors)),
                None if fault in _UNSEEN else 1e3 * float(motors.max()),
                1e3 * bound(fault, rate), int(late.sum()), sum(one[2] for one in seen),
            )
        )  # fmt: skip
    return found


def bound(fault: str, rate: float) -> float:
    """Longest time from a fault until zero force acts on the motors, if all threads run on time [s].

    A message with a force may come in as the fault begins, or a period later, and is the last with a force. A missing
    answer is noticed a window after it, anything else earlier. The zero is the next message. A service that takes a
    time for each message, one after the other, first ends the one with a force, and then the zero takes that time too:
    no client can do better while one message is under way, and a zero alone already takes that time.
    """
    return 1.0 / rate + (2.0 * _PROCESSING if fault == "slow" else _WINDOW)


def _case(fault: str, rate: float) -> tuple[float, float, bool]:
    """Time until zero is rendered [s], until it has arrived at the motors [s] or NaN, and whether it was named."""
    with _Service() as service:
        objects = [{"name": "plane", "plane": {}, "stiffness": 400.0}]
        far = {"xyz": [0.0, 0.0, 0.012]}
        driver = HaplySection(url=f"ws://127.0.0.1:{service.port}", rate=rate).to_text()
        scene = Scene.model_validate({
            "objects": objects, "arms": {"leader": {"driver": driver}}, "mapping": {"scale": 1.0},
            "operator": {"path": [{"t": 0.0, **far}, {"t": 1.0, **far}]},
        })  # fmt: skip
        with Session(scene) as session:
            session.start()
            _wait(lambda: session.state.force > _PRESSED, 0.002, "the simulated hand did not press the plane")
            with _punctual():
                begin = service.fail(fault)
                _wait(lambda: session.state.force == 0.0, 0.0001, "the force stayed")
                rendered = time.monotonic() - begin
            if fault in _ENDS:
                _wait(lambda: session.failed, 0.002, "the session did not end")
            else:
                time.sleep(_AFTER)
            motors = float("nan") if fault in _UNSEEN else service.silent_after(begin, fault in _PASSES)
            summary = session.close()
    if (
        fault != "ebrake"
    ):  # zero that has arrived was rendered before, however late this thread saw it; a brake acts alone
        rendered = float(np.fmin(rendered, motors))
    return rendered, motors, any(re.search(FAULTS[fault], words) for words in summary.faults)


@contextmanager
def _punctual() -> Iterator[None]:
    """Let the threads of Python run before other programs, where the system allows it.

    This thread then sees the zero when it comes: all of them share the interpreter's lock, which one that other
    programs hold up would keep.
    """
    mine = [thread.native_id for thread in threading.enumerate() if thread.native_id is not None]

    def schedule(how: str, priority: int) -> None:
        for thread in mine:
            with suppress(OSError, AttributeError):
                os.sched_setscheduler(thread, getattr(os, how), os.sched_param(priority))

    schedule("SCHED_FIFO", 1)
    try:
        yield
    finally:
        schedule("SCHED_OTHER", 0)


def _wait(true: Callable[[], bool], pause: float, words: str) -> None:
    end = time.monotonic() + _PATIENCE
    while not true():
        if time.monotonic() > end:
            raise DeviceError(f"{words} within {_PATIENCE:g} s", mend="stop other programs, and report this")
        time.sleep(pause)


class _Service:
    """A stand-in of the service in a process of its own."""

    def __enter__(self) -> _Service:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(other,), daemon=True)
        self._process.start()
        other.close()
        self.port = int(self._pipe.recv())
        return self

    def fail(self, fault: str) -> float:
        """Let a fault begin; the time of its beginning on the monotonic clock, which processes share [s]."""
        if fault == "killed":
            begin = time.monotonic()
            os.kill(self._process.pid or 0, signal.SIGKILL)
            return begin
        self._pipe.send(("fail", fault))
        return float(self._pipe.recv())

    def silent_after(self, begin: float, passes: bool) -> float:
        """Time from `begin` until the motors have no force, with `passes` for a moment [s]; infinite if never."""
        self._pipe.send(("silent", (begin, passes)))
        return float(self._pipe.recv())

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.join()
        self._pipe.close()


def _serve(pipe: Connection) -> None:
    """The stand-in's process: obeys what is sent through the pipe until it is killed."""
    from palpate.devices.haply.stand_in import Options, StandIn

    with StandIn(0, Options(idle_after=_IDLE)) as service:
        _core.schedule(True)  # this thread lets faults begin: other programs do not delay them
        pipe.send(service.port)
        act: dict[str, Callable[[Any], float]] = {
            "fail": service.fail,
            "silent": lambda asked: _silent(service, *asked),
        }
        while True:
            try:
                name, value = pipe.recv()
            except EOFError:
                return
            pipe.send(act[name](value))


def _silent(service: Any, begin: float, passes: bool) -> float:
    """Time from `begin` until the motors have no force and get none, from the log of forces that have arrived [s].

    passes: a force may come back, and the first zero counts.
    """
    step = 0.00025
    times = np.arange(begin, begin + _AFTER, step)
    pushed = np.array([service.force(float(t)).any() for t in times])
    if passes:
        return float("inf") if pushed.all() else step * int(np.argmin(pushed))
    return float("inf") if pushed[-1] else step * int(np.max(np.flatnonzero(pushed) + 1, initial=0))
