"""The process with the haptic node that `palpate bench ros` measures; arguments: SCENE RATE LEADER TELEOP.

The process runs until its standard input ends and then prints its counts as one line of JSON.
"""

from __future__ import annotations

import json
import resource
import sys

from palpate.ros.haptics import Devices, Limits
from palpate.ros.plant import CrtkPlant
from palpate.scene import Scene
from palpate.session import Session


def main(arguments: list[str]) -> int:
    """Run the haptic node with the scene."""
    path, rate, leader, teleop = arguments
    scene = Scene.load(path)
    plant = CrtkPlant(scene, Devices(leader, "virtual", teleop), Limits(rate=float(rate)))
    session = Session(scene, plant=plant)
    session.start()
    print("ready", flush=True)
    sys.stdin.read()
    session.stop()
    timing, used = session.timing, resource.getrusage(resource.RUSAGE_SELF)
    session.close()
    counted = {k: timing[k] for k in ("published", "ticks", "answer_us", "cycle_us", "scheduler", "guardian_took_over")}
    print(
        json.dumps(counted | {"cpu_s": used.ru_utime + used.ru_stime, "events": plant.events + session.notes}),
        flush=True,
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
