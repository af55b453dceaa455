"""Versions, real-time rights, the processor and the disk."""

from __future__ import annotations

import os
import platform
import shutil
import sys
import threading
import time
from importlib import metadata
from pathlib import Path

from palpate.cli.doctor.finding import Finding, State

LATE = 0.5e-3
"""A thread that wakes later than this cannot keep a rate of 1 kHz [s]."""
MB_PER_SECOND = 0.7
"""Size of a record of one pair (docs/record.md)."""
ENOUGH_MB = 2000.0
"""Free space for three quarters of an hour of a record [MB]."""
_CPUS = Path("/sys/devices/system/cpu")
_LIMITS = "/etc/security/limits.d/palpate.conf"


def versions() -> list[Finding]:
    """Palpate, Python, the system and the libraries of the core install."""
    import palpate
    from palpate import _core

    python = platform.python_version()
    libraries = ", ".join(f"{name} {metadata.version(name)}" for name in ("numpy", "scipy", "pydantic", "mcap"))
    return [
        Finding("versions", "Palpate", "ok", f"{palpate.__version__}, {Path(_core.__file__).parent}"),
        Finding("versions", "Python", "ok", f"{python}, {sys.executable}"),
        Finding("versions", "system", "ok", f"{_system()}, Linux {platform.release()}, {platform.machine()}"),
        Finding("versions", "libraries", "ok", libraries),
    ]


def real_time() -> list[Finding]:
    """May threads of this user run before all others, and how late does a thread wake?"""
    return [_rights(), _kernel(), _lateness()]


def processor() -> list[Finding]:
    """Cores, vector instructions, frequency governor."""
    cores = len(os.sched_getaffinity(0))
    flags = _flags()
    vectors = ", ".join(name for name in ("avx2", "fma", "avx512f") if name in flags) or "none of AVX2 and AVX-512"
    return [
        Finding("processor", "cores", "ok" if cores > 1 else "problem", f"{cores}",
                "a cycle at 1 kHz beside the viewer and the record", "" if cores > 1 else "give the process two cores"),
        Finding("processor", "vector instructions", "ok" if "avx2" in flags else "optional", vectors,
                "soft bodies at full speed", "" if "avx2" in flags else "none: the portable kernels are used"),
        _governor(_CPUS),
    ]  # fmt: skip


def disk() -> list[Finding]:
    """Free space where records, temporary files and cached structures are written."""
    from palpate.base import cache

    places = {"this folder": Path.cwd(), "temporary files": Path(os.environ.get("TMPDIR", "/tmp"))}
    folder = cache.folder()
    if folder is not None:
        places["cache"] = folder
    return [_space(name, place) for name, place in places.items()]


def _system() -> str:
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        return "unknown distribution"


def _rights() -> Finding:
    from palpate import _core

    priority = int(_core.RealTimeOptions().priority)  # of the haptic cycle
    allowed: list[bool] = []
    thread = threading.Thread(target=lambda: allowed.append(_may_run_at(priority)))  # it alone changes its scheduler
    thread.start()
    thread.join()
    needed = "no late ticks while other programs work"
    if allowed[0]:
        return Finding("real-time", "SCHED_FIFO", "ok", f"allowed at priority {priority}", needed)
    name = os.environ.get("USER", "YOUR_NAME")
    fix = f"echo '{name} - rtprio 90' | sudo tee {_LIMITS}, then log in again"
    return Finding("real-time", "SCHED_FIFO", "problem", f"refused at priority {priority}", needed, fix)


def _may_run_at(priority: int) -> bool:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return False
    return True


def _kernel() -> Finding:
    version = platform.version()
    kind = "PREEMPT_RT" if "PREEMPT_RT" in version else "PREEMPT" if "PREEMPT" in version else "without preemption"
    state: State = "ok" if kind.startswith("PREEMPT") else "optional"
    fix = "" if state == "ok" else "a kernel with PREEMPT_RT, e.g. Debian's package linux-image-rt-amd64"
    return Finding("real-time", "kernel", state, kind, "rates above 1 kHz beside a busy machine", fix)


def _lateness(seconds: float = 0.3) -> Finding:
    """How late a plain thread wakes from 1 ms of sleep: a bound from above for the thread of the cycle."""
    late, tick = [], time.perf_counter()
    for _ in range(int(seconds * 1000)):
        tick += 1e-3
        time.sleep(max(0.0, tick - time.perf_counter()))
        late.append(time.perf_counter() - tick)
        tick = max(tick, time.perf_counter() - 1e-3)
    late.sort()
    usual, most = late[int(0.99 * len(late))], late[-1]
    state: State = "ok" if usual < LATE else "problem"
    fix = "" if state == "ok" else "end other programs, or give the virtual machine cores of its own"
    words = (
        f"99 % of {len(late)} wake-ups within {1e3 * usual:.2f} ms, the latest {1e3 * most:.2f} ms (without SCHED_FIFO)"
    )
    return Finding("real-time", "wake-ups", state, words, "a cycle at 1 kHz", fix)


def _flags() -> set[str]:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return set()
    return {flag for line in lines if line.startswith(("flags", "Features")) for flag in line.split(":")[1].split()}


def _governor(cpus: Path) -> Finding:
    found = {path.read_text().strip() for path in cpus.glob("cpu[0-9]*/cpufreq/scaling_governor")}
    needed = "an even duration of the cycle"
    if not found:
        fix = "on the host: sudo cpupower frequency-set -g performance"
        return Finding("processor", "frequency governor", "optional", "not told here (a virtual machine?)", needed, fix)
    state: State = "ok" if found == {"performance"} else "problem"
    fix = "" if state == "ok" else "sudo cpupower frequency-set -g performance"
    return Finding("processor", "frequency governor", state, ", ".join(sorted(found)), needed, fix)


def _space(name: str, place: Path) -> Finding:
    there = next(p for p in (place, *place.parents) if p.exists())
    free = shutil.disk_usage(there).free / 1e6
    writable = os.access(there, os.W_OK)
    state: State = "ok" if writable and free > ENOUGH_MB else "problem"
    words = f"{place}: {free / 1e3:.1f} GB free, about {free / MB_PER_SECOND / 3600:.0f} h of one pair's record"
    if not writable:
        return Finding("disk", name, state, f"{place}: not writable", "records", "work in a folder of yours")
    fix = "" if state == "ok" else "free space, or write records elsewhere: palpate run SCENE --record DISK/FILE.mcap"
    return Finding("disk", name, state, words, "records", fix)
