"""Both ends and the relay between them on this machine, by one command: ``remote: {together: true}``."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from palpate.base.errors import PalpateError
from palpate.scene.scene import Scene
from palpate.session.network.conditions import TRACES
from palpate.session.network.keys import make_key, read_key

_READY = re.compile(r"listening on \S+ port (\d+)")


def network_name(scene: Scene) -> str:
    """Network of a scene's section ``remote``: its name, or the path of a trace, relative to the scene's folder."""
    name = "none" if scene.remote is None else scene.remote.network
    return str(scene.path_to(name, scene.where("remote", "network"))) if name.endswith(TRACES) else name


class Together:
    """The follower's end and a relay as processes of their own, with a key for this run.

    with Together(scene, "netfi-delay-2") as link:
        RemoteLink(session, link.at, link.key)
    """

    def __init__(self, scene: Scene, network: str, video: str | None = None) -> None:
        self._scene, self._network, self._stack = scene, network, ExitStack()
        self._more = [] if video is None else ["--video", video]
        self.at = ("127.0.0.1", 0)  #: address of the relay
        self.follower = 0  #: port of the follower's end
        self.key = b""  #: the shared key
        self.words: list[str] = []  #: what both processes said at their end

    def __enter__(self) -> Self:
        """Start both processes.

        Raises:
            PalpateError: one of them cannot start; the message has its words.
        """
        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="palpate-remote-")))
        make_key(folder / "key")
        self.key = read_key(folder / "key")
        with ExitStack() as opened:
            opened.push(self._stack.pop_all())
            self.follower = self._start(
                opened, "follower", self._scene.file, "--port", "0", "--key", str(folder / "key"), *self._more
            )
            to = f"127.0.0.1:{self.follower}"
            port = self._start(opened, "relay", "--to", to, "--network", self._network, "--port", "0")
            self.at = ("127.0.0.1", port)
            self._stack = opened.pop_all()
        return self

    def _start(self, stack: ExitStack, *words: str) -> int:
        """Start a process; returns the port on which it listens."""
        command = [sys.executable, "-m", "palpate", "serve", *words]
        environment = {**os.environ, "PYTHONUNBUFFERED": "1", "COLUMNS": "200"}
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
        )
        stack.callback(self._end, process)
        said = []
        for line in process.stdout or ():
            said.append(line.rstrip())
            if found := _READY.search(line):
                return int(found[1])
        raise PalpateError(
            f"palpate serve {words[0]} did not start", why=" | ".join(said[-6:]), mend="run it by itself"
        )

    def _end(self, process: subprocess.Popen[str]) -> None:
        process.terminate()
        try:
            rest, _ = process.communicate(timeout=5.0)
        except subprocess.TimeoutExpired:
            process.kill()
            rest, _ = process.communicate()
        self.words += [line for line in rest.splitlines() if line.strip()]

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End both processes."""
        self._stack.close()
