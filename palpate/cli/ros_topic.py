"""`palpate ros topic`."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from palpate.errors import PalpateError
from palpate.ros import topic as work

if TYPE_CHECKING:
    from palpate.cli.ros import Topic

_PARTS = {"list": 0, "echo": 1, "hz": 1, "pub": 3}


def topic(o: Topic) -> int:
    """What `ros2 topic` does; returns the exit code."""
    if len(o.words) != _PARTS[o.what] and not (o.what == "pub" and len(o.words) == 2):
        needed = {"list": "nothing more", "pub": "TOPIC TYPE YAML"}.get(o.what, "a TOPIC")
        raise PalpateError(f"palpate ros topic {o.what} takes {needed}", mend="palpate ros topic --help")
    with work.node(o.network) as here:
        if o.what == "list":
            for name, kind in work.topics(here):
                print(f"{name}  {kind}", flush=True)
        elif o.what == "pub":
            name, kind, *text = o.words
            work.publish(here, name, kind, text[0] if text else "{}", None if o.rate <= 0 else o.rate)
        elif o.what == "echo":
            work.listen(here, o.words[0], _show, o.count, o.duration)
        else:
            _hz(here, o)
    return 0


def _show(message: Any) -> None:
    print(yaml.safe_dump(work.as_plain(message), sort_keys=False) + "---", flush=True)


def _hz(here: Any, o: Topic) -> None:
    times: list[float] = []
    work.listen(here, o.words[0], lambda _: times.append(time.monotonic()), o.count, o.duration or 3.0)
    steps = np.diff(times)
    if not len(steps):
        raise PalpateError(f"{o.words[0]}: {len(times)} messages came", mend="--duration gives it longer")
    span = 1e3 * np.percentile(steps, [0, 50, 100])
    print(f"average rate: {1.0 / steps.mean():.1f} Hz, {len(times)} messages")
    print(f"  apart: shortest {span[0]:.2f}, median {span[1]:.2f}, longest {span[2]:.2f} ms")
