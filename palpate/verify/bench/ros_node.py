"""The haptic node that `palpate bench ros` measures, in a process of its own: SCENE RATE LEADER TELEOP.

Runs until its standard input ends; then says in one line of JSON what it counted.
"""

from __future__ import annotations

import json
import resource
import sys

from palpate.ros.haptics import Devices, HapticSession, Limits
from palpate.scene import Scene


def main(arguments: list[str]) -> int:
    """Feel the scene as the puppet moves."""
    path, rate, leader, teleop = arguments
    session = HapticSession(Scene.load(path), Devices(leader, "virtual", teleop), Limits(rate=float(rate)))
    session.start()
    print("ready", flush=True)
    sys.stdin.read()
    session.stop()
    timing, used = session.timing, resource.getrusage(resource.RUSAGE_SELF)
    session.close()
    counted = {k: timing[k] for k in ("published", "ticks", "answer_us", "cycle_us", "scheduler", "guardian_took_over")}
    print(json.dumps(counted | {"cpu_s": used.ru_utime + used.ru_stime, "told": session.told}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
