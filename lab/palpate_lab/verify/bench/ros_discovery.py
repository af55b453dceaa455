"""`palpate bench ros --discovery`: how soon a client that starts beside a running robot hears and is heard.

The robot is `palpate ros sim` with all arms. The control is a bare rclpy node with the same topics, names and types. It
starts when the robot has ended: clients beside both would wait for both, since the ports of shared memory are common to
all ROS domains, and who opens one may wait 0.3 s for its owner. Each client is a fresh process.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from palpate.base.errors import PalpateError

Figures = dict[str, Any]
"""By the keys of `palpate bench ros --discovery` in docs/json/ros.md."""
STARTS = 20
_PAUSE = 0.73  # after a client's end, so that starts fall at all phases of periodic announcements [s]
_ALONE = 3.0  # after the start of robot or control, so that its first announcements are over [s]
_TIMEOUT = 20.0  # of a client [s]


def run(starts: int = STARTS, on_progress: Callable[[str], None] = lambda _: None) -> Figures:
    """Measure; the result has the keys of `palpate bench ros --discovery`.

    Args:
        starts: number of clients that start beside the robot, and beside the control [-].
        on_progress: called with a line on each step.

    Raises:
        RosMissingError: ROS 2 is not installed.
        PalpateError: robot or control does not start, or a client hears nothing.
    """
    from palpate import ros

    ros.load(on_progress)
    domain = int(os.environ.get("ROS_DOMAIN_ID") or 0)
    with _server("robot", domain, ["-m", "palpate", "ros", "sim"], "Ctrl-C"):
        topics = _outcome(domain, _TOPICS)["topics"]
        on_progress(f"the robot is up, {len(topics)} publishers and subscriptions")
        robot = _clients("robot", domain, starts, on_progress)
    with _server("control", domain, ["-c", _PREPARED + _CONTROL, json.dumps(topics)], "ready", plain=True):
        control = _clients("control", domain, starts, on_progress)
    return figures(robot, control, len(topics))


def _clients(name: str, domain: int, starts: int, on_progress: Callable[[str], None]) -> list[dict[str, float]]:
    """What clients see that start one after the other beside the server `name`: rows for `figures`."""
    time.sleep(_ALONE)
    rows = []
    for start in range(1, starts + 1):
        before = _dropped()
        row = _outcome(domain, _CLIENT, plain=True)
        rows.append(row | {"dropped": _dropped() - before})
        on_progress(f"{name}, start {start} of {starts}: {1e3 * row['pose_s']:.0f} ms")
        time.sleep(_PAUSE)
    return rows


def figures(robot: list[dict[str, float]], control: list[dict[str, float]], topics: int) -> Figures:
    """Percentiles of the clients' times, by the documented keys.

    Args:
        robot: a row per client: `ready_s`, `pose_s`, `command_s` [s], `lost` commands, `dropped` datagrams.
        control: the same beside the control.
        topics: number of publishers and subscriptions of either [-].
    """
    out: Figures = {"starts": len(robot), "topics": topics, "load": os.getloadavg()[0]}
    for prefix, rows in (("", robot), ("control_", control)):
        for key in ("ready", "pose", "command"):
            p50, p95, most = np.percentile([row[f"{key}_s"] for row in rows], [50, 95, 100]).tolist()
            out |= {f"{prefix}{key}_p50_s": p50, f"{prefix}{key}_p95_s": p95, f"{prefix}{key}_max_s": most}
        for key in ("lost", "dropped"):
            out[f"{prefix}{key}"] = float(np.mean([row[key] for row in rows]))
    out["ratio"] = max(out[f"{key}_p95_s"] / out[f"control_{key}_p95_s"] for key in ("pose", "command"))
    return out


def table(result: Figures) -> Table:
    """The result as a table for a terminal."""
    out = Table(title=f"start of a client, {result['starts']} times, {result['topics']} publishers and subscriptions",
                title_justify="left", box=None, padding=(0, 2, 0, 0))  # fmt: skip
    for column in ("", "p50", "p95", "longest", "control p95"):
        out.add_column(column, justify="right" if column else "left")
    rows = {"ready": "its node is made", "pose": "first measured_cp", "command": "first command answered"}
    for key, words in rows.items():
        values = [result[f"{key}_{p}_s"] for p in ("p50", "p95", "max")] + [result[f"control_{key}_p95_s"]]
        out.add_row(words, *(f"{1e3 * value:.0f} ms" for value in values))
    out.caption_justify = "left"
    words = "p95 over that of a bare rclpy node with as many topics"
    out.caption = (
        f"{words}: {result['ratio']:.2f}; load {result['load']:.1f}\n"
        f"datagrams that this machine dropped a start: {result['dropped']:.1f}, control {result['control_dropped']:.1f}"
    )
    return out


def _dropped() -> int:
    """UDP datagrams that full sockets of this machine have dropped since it started; 0 where Linux does not tell."""
    path = Path("/proc/net/snmp")
    names, values = ([line.split() for line in path.read_text().splitlines() if line.startswith("Udp:")]
                     if path.is_file() else ([], []))  # fmt: skip
    return int(dict(zip(names, values, strict=True)).get("RcvbufErrors", 0))


@contextmanager
def _server(name: str, domain: int, command: list[str], ready: str, plain: bool = False) -> Iterator[None]:
    """A process that has printed a line with `ready`; it is terminated at the end of the context."""
    process = subprocess.Popen(
        [sys.executable, *command], env=_environment(domain, plain), stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout
        if not any(ready in line for line in process.stdout):
            raise PalpateError(f"the {name} does not start", mend="see its output above")
        yield
    finally:
        process.terminate()
        process.communicate()


def _outcome(domain: int, program: str, plain: bool = False) -> dict[str, Any]:
    """Run a program in a fresh process; returns the JSON that it prints."""
    done = subprocess.run(
        [sys.executable, "-c", _PREPARED + program], env=_environment(domain, plain), stdout=subprocess.PIPE, text=True,
        timeout=3 * _TIMEOUT, check=False,
    )  # fmt: skip
    if done.returncode or not done.stdout.strip():
        raise PalpateError(f"a client hears nothing within {_TIMEOUT:g} s", mend="run palpate ros setup, then again")
    outcome: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return outcome


def _environment(domain: int, plain: bool) -> dict[str, str]:
    """The environment of a process; `plain`: as of a program that knows nothing of Palpate."""
    from palpate.ros.build import PROFILES

    kept = {key: value for key, value in os.environ.items() if not (plain and key in PROFILES)}
    return kept | {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


_PREPARED = f"""
import importlib, json, sys, time
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
TIMEOUT = {_TIMEOUT}
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
def kind(name):
    package, _, cls = name.split("/")
    return getattr(importlib.import_module(package + ".msg"), cls)
"""

_TOPICS = """
rclpy.init()
node = rclpy.create_node("palpate_topics")
end, found, quiet = time.monotonic() + TIMEOUT, [], 0
while time.monotonic() < end and quiet < 20:
    rclpy.spin_once(node, timeout_sec=0.05)
    names = [name for name, _ in node.get_node_names_and_namespaces()]
    if "dvrk" not in names:
        continue
    outs = node.get_publisher_names_and_types_by_node("dvrk", "/")
    ins = node.get_subscriber_names_and_types_by_node("dvrk", "/")
    now = [["out", *row] for row in outs] + [["in", *row] for row in ins]
    quiet, found = (quiet + 1, found) if len(now) == len(found) else (0, now)
print(json.dumps({"topics": [[way, name, types[0]] for way, name, types in found]}))
node.destroy_node()
rclpy.shutdown()
"""

_CONTROL = """
rclpy.init()
node = rclpy.create_node("palpate_control")
publishers = {}
for way, name, type_name in json.loads(sys.argv[1]):
    if way == "out":
        latched = name.rpartition("/")[2] in ("scale", "operating_state")
        publishers[name] = node.create_publisher(kind(type_name), name, LATCHED if latched else 10)
    else:
        answer = publishers.get("/console/teleop/scale") if name == "/console/teleop/set_scale" else None
        node.create_subscription(kind(type_name), name, answer.publish if answer else lambda _: None, 10)
pose = publishers["/MTMR/measured_cp"]
node.create_timer(0.01, lambda: pose.publish(kind("geometry_msgs/msg/PoseStamped")()))
print("ready", flush=True)
try:
    rclpy.spin(node)
except BaseException:  # terminated in the middle of a publication
    pass
"""

_CLIENT = """
Pose, Number = kind("geometry_msgs/msg/PoseStamped"), kind("std_msgs/msg/Float64")
begin, times, sent = time.monotonic(), {}, {}
def mark(name):
    times.setdefault(name, time.monotonic() - begin)
def answered(message):
    if message.data in sent:
        mark("command_s")
        times.setdefault("lost", sorted(sent).index(message.data))
rclpy.init()
node = rclpy.create_node("palpate_client")
node.create_subscription(Pose, "/MTMR/measured_cp", lambda _: mark("pose_s"), 10)
node.create_subscription(Number, "/console/teleop/scale", answered, LATCHED)
command = node.create_publisher(Number, "/console/teleop/set_scale", 10)
mark("ready_s")
first = 0.2 + 0.1 * (time.time() % 1.0)
following = 0.0
while len(times) < 4 and time.monotonic() - begin < TIMEOUT:
    if time.monotonic() >= following:
        following = time.monotonic() + 0.01
        sent[first + 1e-6 * len(sent)] = True
        command.publish(Number(data=list(sent)[-1]))
    rclpy.spin_once(node, timeout_sec=0.002)
if len(times) == 4:
    print(json.dumps(times))
node.destroy_node()
rclpy.shutdown()
"""
