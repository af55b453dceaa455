"""A gamepad as the master: its sticks move the instrument, and one sees what one cannot feel.

Without a gamepad the example writes the events of a stick into a pipe, as the kernel would. You learn

* how a driver that ships is named: arms.leader.driver: gamepad, or mouse, or gamepad:/dev/input/event5;
* that a device without motors gives no force: a bar shows the force that a hand would feel, up to its cap;
* that the driver in the scene is all that `palpate run` needs.

    python examples/08_gamepad.py --duration 20            # with a gamepad
    python examples/08_gamepad.py --pretended --duration 3   # without
"""

import os
import struct
import sys
import tempfile
import threading
import time
from pathlib import Path

import tyro

import palpate
from palpate.base.errors import DeviceError
from palpate.session import State

SCENE = {
    "objects": [{"name": "liver", "shape": "organ", "triangles": 5000, "stiffness": 400.0, "damping": 2.0}],
    "mapping": {"scale": 0.5},
    "operator": {"palpate": {"hover": 0.01}},
}
STICK_UP_DOWN, FULLY_DOWN = 4, 32767  # code and value of the right stick


def pretend(path: str, stop: threading.Event) -> None:
    """Write events into a pipe: the right stick is pulled down for a while, and released."""
    with open(path, "wb", buffering=0) as pipe:
        for value, seconds in ((FULLY_DOWN, 1.0), (0, 1e9)):
            pipe.write(struct.pack("llHHi", 0, 0, 3, STICK_UP_DOWN, value))
            if stop.wait(seconds):
                return


def bar(state: State, cap: float) -> str:
    """The force as a bar of at most 30 signs."""
    share = min(1.0, state.force / cap)
    return f"{state.t:5.1f} s |{'#' * round(30 * share):<30}| {state.force:.2f} of {cap:g} N"


def main(duration: float = 10.0, pretended: tyro.conf.FlagCreatePairsOff[bool] = False, device: str = "") -> None:
    """Move the instrument by the gamepad, and print the force twice a second."""
    stop = threading.Event()
    if pretended:
        device = str(Path(tempfile.mkdtemp()) / "stick")
        os.mkfifo(device)
        threading.Thread(target=pretend, args=(device, stop), daemon=True).start()
    driver = f"gamepad:{device}" if device else "gamepad"
    scene = palpate.Scene.model_validate({**SCENE, "arms": {"leader": {"driver": driver}}})
    session = palpate.Session(scene)
    printed = 0.0

    def show(state: State) -> None:
        nonlocal printed
        if time.monotonic() - printed > 0.5:
            printed = time.monotonic()
            print(bar(state, scene.stability.force_cap))

    try:
        summary = session.run(duration, on_progress=show)
    except DeviceError as error:  # no gamepad is connected, or it may not be read
        sys.exit(f"error: {error}\nwithout a gamepad: python examples/08_gamepad.py --pretended --duration 3")
    stop.set()
    print(f"{summary.contact_s:.1f} s in contact, at most {summary.peak_force_N:.2f} N")


if __name__ == "__main__":
    tyro.cli(main)
