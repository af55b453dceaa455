"""A disconnected cable: run by test_faults.py in its own network namespace. Prints the observations as JSON."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np


def link(state):
    subprocess.run(["ip", "link", "set", "lo", state], check=True)


def main(folder):
    os.environ["ROS_STATIC_PEERS"] = "127.0.0.1"  # the network has one machine
    link("up")
    subprocess.run(["ip", "route", "add", "224.0.0.0/4", "dev", "lo"], check=True)
    subprocess.run(["ip", "link", "set", "lo", "multicast", "on"], check=True)
    from palpate import ros
    from palpate.record import Record
    from palpate_lab.verify.bench import ros_stand as bench

    stand = bench.Stand(ros.load(), "CABLE", network=True)
    node = bench.Node(stand, folder, "--network")
    try:
        stand.press(60.0)
        first = len(node.output.lines)
        begin = time.monotonic()
        link("down")
        time.sleep(0.5)
        while not (reported := any("the leader is silent" in line for line in node.output.lines[first:])):
            if time.monotonic() > begin + 3.0:  # the watchdog acts within milliseconds; its words are printed in turn
                break
            time.sleep(0.02)
        away = time.monotonic()
        link("up")
        stand.press(30.0)
        felt = stand.mock_leader.wrenches
        later = felt[felt[:, 0] > away]
        seen = {
            "reported": reported,
            "first_after": float(np.linalg.norm(later[0, 3:6])),
            "steepest": stand.steepest(away),
            "came_while_down": int(((felt[:, 0] > begin + 0.05) & (felt[:, 0] < away)).sum()),
        }
        summary = node.end()
        seen["complete"] = Record.open(summary["record"]).complete
    finally:
        if node.process.poll() is None:
            node.process.kill()
        node.process.wait()
    seen["lines"] = node.output.lines[first:]
    print(json.dumps(seen), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
