"""A guardian process, which sends zero wrenches when a haptic node falls silent (cpp/haptics/guardian.hpp).

    python -m palpate.ros.guardian NODE_PID BEAT_FD NODE_NAME WRENCH_TOPIC

The haptic node starts it in its own process session, so that Ctrl-C in the terminal does not reach it.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from typing import Any

from palpate.base.errors import PalpateError


class Guardian:
    """The guardian of this process.

    Args:
        name: name of the guardian's ROS node.
        topic: wrench topic.
        context: arguments of the ROS context.
    """

    def __init__(self, name: str, topic: str, context: Mapping[str, Any]) -> None:
        self.name = name
        self.beat_fd = os.memfd_create("palpate-heartbeat")
        command = [sys.executable, "-m", "palpate.ros.guardian", str(os.getpid()), str(self.beat_fd), name, topic]
        self._process = subprocess.Popen(
            [*command, json.dumps(dict(context))], pass_fds=(self.beat_fd,), start_new_session=True
        )

    @property
    def pid(self) -> int:
        """Process id of the guardian."""
        return self._process.pid

    def await_watching(self, seconds: float = 30.0) -> None:
        """Wait until the guardian watches this process, for at most `seconds` [s].

        Raises:
            PalpateError: the guardian does not start.
        """
        end = time.monotonic() + seconds
        while not self.watching:
            if self._process.poll() is not None or time.monotonic() > end:
                raise PalpateError(
                    "the guardian process does not start", mend="run `palpate ros setup`, which reports the cause"
                )
            time.sleep(0.01)

    @property
    def watching(self) -> bool:
        """True once the guardian has read the heartbeat."""
        return os.pread(self.beat_fd, 8, 8) not in (b"", bytes(8))

    @property
    def alive(self) -> bool:
        """True while the guardian process runs."""
        return self._process.poll() is None

    def kill(self) -> None:
        """Kill the guardian at once, when no node was started."""
        self._process.kill()
        self._process.wait()
        os.close(self.beat_fd)

    def end(self) -> None:
        """Wait until the guardian ends after its node; kill it after 1 s."""
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self.beat_fd)


def main(arguments: list[str]) -> int:
    """Guard until the node has ended."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the guardian ends after its node
    pid, fd, name, topic, context = arguments
    from palpate import ros

    native = ros.load()
    ended_cleanly = native.guard(native.Context(**json.loads(context)), topic, name, int(pid), int(fd))
    if not ended_cleanly:
        print(f"the haptic node died: the guardian has sent zero wrenches to {topic}", file=sys.stderr)
    return 0 if ended_cleanly else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
