"""The process that dies last: sends zero wrenches where a haptic node falls silent (cpp/haptics/guardian.hpp).

    python -m palpate.ros.guardian NODE_PID BEAT_FD NODE_NAME WRENCH_TOPIC

It is started by the haptic node, in a session of its own, so that Ctrl-C in the terminal does not reach it.
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

from palpate.errors import PalpateError


class Guardian:
    """The guardian of this process.

    Args:
        name: of its ROS node.
        topic: that wrenches go to.
        context: arguments of the ROS context.

    Raises:
        PalpateError: it does not come up.
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
        """Of the process."""
        return self._process.pid

    def await_watching(self, seconds: float = 30.0) -> None:
        """Wait until it watches.

        Raises:
            PalpateError: it does not.
        """
        end = time.monotonic() + seconds
        while not self.watching:
            if self._process.poll() is not None or time.monotonic() > end:
                raise PalpateError(
                    "the guardian process does not start", mend="`palpate ros setup` tells what is wrong"
                )
            time.sleep(0.01)

    @property
    def watching(self) -> bool:
        """Has it looked yet?"""
        return os.pread(self.beat_fd, 8, 8) not in (b"", bytes(8))

    @property
    def alive(self) -> bool:
        """Is it there?"""
        return self._process.poll() is None

    def kill(self) -> None:
        """At once: there was nothing to guard."""
        self._process.kill()
        self._process.wait()
        os.close(self.beat_fd)

    def end(self) -> None:
        """Wait for its own end, which follows that of the node; help after a second."""
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self.beat_fd)


def main(arguments: list[str]) -> int:
    """Guard until the node has ended."""
    for told in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(told, signal.SIG_IGN)  # it ends when the node has
    pid, fd, name, topic, context = arguments
    from palpate import ros

    native = ros.load()
    well = native.guard(native.Context(**json.loads(context)), topic, name, int(pid), int(fd))
    if not well:
        print(f"the haptic node died: the guardian has sent zero wrenches to {topic}", file=sys.stderr)
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
