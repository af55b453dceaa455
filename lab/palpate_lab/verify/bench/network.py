"""`palpate bench network`: a session across a network beside one without, and both beside packets of strangers.

Four runs of the same scene in real time: without a link (the control), with a follower process behind a relay, the same
with pictures of a camera, and the same while another process sends forged packets to both ends.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
import warnings
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TypedDict

import numpy as np
from rich.table import Table

from palpate.base.errors import PalpateError
from palpate.scene import Scene
from palpate.scene.rig import Rig, build
from palpate.session import Session
from palpate.session.network.channel import MAGIC
from palpate.session.remote.link import RemoteLink
from palpate.session.remote.together import Together

FLOOD = """
import secrets, socket, sys, time
udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
forged = [bytes.fromhex(sys.argv[1]) + secrets.token_bytes(16 + 188) for _ in range(256)]
forged += [secrets.token_bytes(n) for n in range(256)]
ports, rate, sent, begin = [int(p) for p in sys.argv[3:]], float(sys.argv[2]), 0, time.monotonic()
try:
    while True:
        while sent < rate * (time.monotonic() - begin):
            udp.sendto(forged[sent % 512], ("127.0.0.1", ports[sent % len(ports)]))
            sent += 1
        time.sleep(0.002)
except BaseException:
    pass
"""
"""Program that sends forged packets with this beginning (hexadecimal) at a rate [Hz] to ports until it is ended."""
_END = re.compile(
    r"(\d+) ticks, (\d+) missed, (\d+) packets sent, (\d+) refused, largest force (\S+) N, (\S+) s of processor time"
)


class Row(TypedDict):
    """One run; values of the follower are None without one."""

    run: str
    missed_ticks: int
    cycle_p99_us: float
    operator_cpu: float  #: processor time of the session beyond that of the control, over the duration [cores]
    follower_cpu: float | None
    follower_missed: int | None
    follower_ticks: int | None
    refused: int | None  #: packets that both ends refused
    accepted_forged: int  #: packets that arrived at the operator's end beyond those that the follower sent; must be 0


class NetworkBench(TypedDict):
    """Result of the benchmark. The keys are the documented contract of ``--json``."""

    simulated: bool
    seconds: float
    rate_Hz: float
    flood_Hz: float
    rows: list[Row]


def run(seconds: float, flood: float, network: str) -> NetworkBench:
    """All four runs of the scene `remote`."""
    scene = Scene.load("remote")
    section = scene.remote
    assert section is not None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rig = build(scene)
    control, alone = _alone(rig, seconds)
    with tempfile.TemporaryDirectory(prefix="palpate-video-") as folder:
        _pictures(Path(folder))
        linked = partial(_linked, rig, network, seconds, alone)
        rows = [control, linked(0.0), linked(0.0, folder), linked(flood)]
    return {"simulated": True, "seconds": seconds, "rate_Hz": section.rate, "flood_Hz": flood, "rows": rows}


def _pictures(folder: Path) -> None:
    """Pictures of a camera of 640 x 480 pixels, of about 100 KiB."""
    from PIL import Image

    rng = np.random.default_rng(0)
    for k in range(8):
        rough = Image.fromarray(rng.integers(0, 256, (96, 128, 3), np.uint8)).resize((640, 480))
        rough.save(folder / f"{k}.jpg", quality=85)


def _alone(rig: Rig, seconds: float) -> tuple[Row, float]:
    """The control, and its processor time [s]."""
    session, before = Session(rig.scene, rig=rig), time.process_time()
    summary = session.run(seconds, realtime=True)
    spent = time.process_time() - before
    return {"run": "control", "missed_ticks": summary.missed_ticks, "cycle_p99_us": summary.cycle_p99_us,
            "operator_cpu": 0.0, "follower_cpu": None, "follower_missed": None, "follower_ticks": None,
            "refused": None, "accepted_forged": 0}, spent  # fmt: skip


def _linked(rig: Rig, network: str, seconds: float, alone: float, flood: float, video: str | None = None) -> Row:
    section, session = rig.scene.remote, Session(rig.scene, rig=rig)
    assert section is not None
    with Together(rig.scene, network, video) as both:
        with RemoteLink(session, both.at, both.key, section.rate) as link, ExitStack() as stack:
            if flood:
                ports = [str(both.follower), str(link.port)]
                stranger = subprocess.Popen([sys.executable, "-c", FLOOD, MAGIC.hex(), str(flood), *ports])
                stack.callback(stranger.wait)
                stack.callback(stranger.terminate)
            before = time.process_time()
            summary = session.run(seconds, realtime=True)
            spent = time.process_time() - before
        found = link.figures()
    ended = next((m for line in both.words if (m := _END.search(line))), None)
    if ended is None:  # without its numbers, no packet could be called forged
        raise PalpateError("the follower's end broke off", why=" | ".join(both.words[-6:]), mend="run it by itself")
    ticks, missed, sent, refused, _, cpu = (float(x) for x in ended.groups())
    return {
        "run": "linked, flooded" if flood else "linked" if video is None else "linked, video",
        "missed_ticks": summary.missed_ticks,
        "cycle_p99_us": summary.cycle_p99_us,
        "operator_cpu": max(spent - alone, 0.0) / seconds,
        "follower_cpu": cpu / max(ticks / section.rate, 1e-9),
        "follower_missed": int(missed),
        "follower_ticks": int(ticks),
        "refused": int(refused) + int(found["refused"]),
        "accepted_forged": max(int(found["received"]) - int(sent), 0),
    }


def table(found: NetworkBench) -> Table:
    """The runs for a terminal."""
    title = f"{found['seconds']:g} s at {found['rate_Hz']:g} Hz, forged packets at {found['flood_Hz']:g} Hz"
    out = Table(box=None, pad_edge=False, title=title, title_justify="left")
    for column in ("run", "missed ticks", "cycle p99, us", "operator's link, cores", "follower, cores",
                   "follower missed", "refused"):  # fmt: skip
        out.add_column(column, justify="left" if column == "run" else "right")
    for r in found["rows"]:
        cpu = "-" if r["follower_cpu"] is None else f"{r['follower_cpu']:.2f}"
        missed = "-" if r["follower_missed"] is None else f"{r['follower_missed']} of {r['follower_ticks']}"
        refused = "-" if r["refused"] is None else str(r["refused"])
        out.add_row(r["run"], str(r["missed_ticks"]), f"{r['cycle_p99_us']:.1f}", f"{r['operator_cpu']:.2f}", cpu,
                    missed, refused)  # fmt: skip
    return out
