"""`palpate ros topic`."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Literal

from tyro.conf import Positional

from palpate.base.errors import PalpateError

_PARTS = {"list": 0, "echo": 1, "hz": 1, "pub": 3}


@dataclass
class Command:
    """Replace `ros2 topic` where the ros2 command is not installed: list, echo, hz, pub.

    examples:
      palpate ros topic list
      palpate ros topic echo /MTMR/measured_cp --count 1
      palpate ros topic hz /MTMR/measured_cp
      palpate ros topic pub /console/emulate_clutch sensor_msgs/msg/Joy "buttons: [1]"
      palpate ros topic pub /MTMR/body/servo_cf geometry_msgs/msg/WrenchStamped "wrench: {force: {z: 1}}"
    """

    what: Positional[Literal["list", "echo", "hz", "pub"]]
    """list: names and types; echo: each message as YAML; hz: rate and intervals; pub: publish a message."""
    words: Positional[tuple[str, ...]] = ()
    """TOPIC; for pub: TOPIC TYPE YAML."""
    count: int | None = None
    """echo, hz: end after this number of messages."""
    duration: float | None = None
    """echo, hz: end after this time [s]."""
    rate: float = 0.0
    """pub: repeat at this rate until Ctrl-C [Hz]; once when left out."""
    network: bool = False
    """Communicate with other machines; otherwise only within this one."""

    def __call__(self) -> int:
        """List, print, measure or send; returns the exit code."""
        from palpate.ros import topic

        if len(self.words) != _PARTS[self.what] and not (self.what == "pub" and len(self.words) == 2):
            needed = {"list": "nothing more", "pub": "TOPIC TYPE YAML"}.get(self.what, "a TOPIC")
            raise PalpateError(f"palpate ros topic {self.what} takes {needed}", mend="palpate ros topic --help")
        with topic.node(self.network) as here:
            if self.what == "list":
                for name, kind in topic.topics(here):
                    print(f"{name}  {kind}", flush=True)
            elif self.what == "pub":
                name, kind, *text = self.words
                topic.publish(here, name, kind, text[0] if text else "{}", None if self.rate <= 0 else self.rate)
            elif self.what == "echo":
                topic.listen(here, self.words[0], _show, self.count, self.duration)
            else:
                self._hz(here)
        return 0

    def _hz(self, here: Any) -> None:
        import numpy as np

        from palpate.ros import topic

        times: list[float] = []
        topic.listen(here, self.words[0], lambda _: times.append(time.monotonic()), self.count, self.duration or 3.0)
        steps = np.diff(times)
        if not len(steps):
            what = f"{self.words[0]}: {len(times)} messages came, too few for a rate"
            raise PalpateError(what, mend="listen longer, e.g. --duration 10")
        span = 1e3 * np.percentile(steps, [0, 50, 100])
        print(f"average rate: {1.0 / steps.mean():.1f} Hz, {len(times)} messages")
        print(f"  interval: shortest {span[0]:.2f}, median {span[1]:.2f}, longest {span[2]:.2f} ms")


def _show(message: Any) -> None:
    import yaml

    from palpate.ros import topic

    print(yaml.safe_dump(topic.as_plain(message), sort_keys=False) + "---", flush=True)
