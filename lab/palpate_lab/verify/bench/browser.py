"""A headless Chromium that renders by software, driven over its DevTools protocol."""

from __future__ import annotations

import base64
import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from palpate.base.errors import MissingExtraError, PalpateError
from palpate.cli.terminal import chromium
from palpate_lab.verify.processes import end as end_process

FLAGS = (
    "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-background-networking", "--disable-component-update", "--disable-quic", "--no-first-run",
    "--hide-scrollbars", "--remote-debugging-port=0", "about:blank",
)  # fmt: skip
_START = 60.0  # longest start of the browser [s]


class Page:
    """One page of the browser."""

    def __init__(self, connection: Any) -> None:
        self._connection, self._number = connection, 0
        self._session: str | None = None
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.send("Page.enable")

    def send(self, method: str, timeout: float = 120.0, **params: Any) -> dict[str, Any]:
        """The result of a method of the protocol.

        Raises PalpateError when the browser refuses it or does not answer in `timeout` [s].
        """
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": params}
        if self._session is not None and not method.startswith(("Target.", "SystemInfo.")):
            message["sessionId"] = self._session
        self._connection.send(json.dumps(message))
        end = time.monotonic() + timeout
        while (left := end - time.monotonic()) > 0.0:
            try:
                answer = json.loads(self._connection.recv(timeout=left))
            except TimeoutError:
                break
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise PalpateError(f"Chromium refused {method}", why=str(answer["error"].get("message")))
                return dict(answer["result"])
        raise PalpateError(f"Chromium did not answer {method} in {timeout:g} s", mend="try on a machine with less load")

    def open(self, url: str, size: tuple[int, int]) -> None:
        """Opens an address in a window of a size, width and height [pixels]."""
        self.send(
            "Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False
        )
        self.send("Page.navigate", url=url)

    def evaluate(self, expression: str) -> Any:
        """Value of a JavaScript expression; a promise is awaited. Raises PalpateError with what it throws."""
        found = self.send("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in found:
            raise PalpateError("the page raised an error", why=str(found["exceptionDetails"].get("exception")))
        return found["result"].get("value")

    def wait_for(self, expression: str, timeout: float = 300.0) -> None:
        """Waits until an expression is true. Raises PalpateError after `timeout` [s]."""
        end = time.monotonic() + timeout
        while not self.evaluate(f"Boolean({expression})"):
            if time.monotonic() > end:
                raise PalpateError(f"the page was not ready in {timeout:g} s", why=f"never true: {expression}")
            time.sleep(0.1)

    def photograph(self, file: Path) -> None:
        """Writes the page as PNG."""
        file.write_bytes(base64.b64decode(self.send("Page.captureScreenshot")["data"]))

    def processor_seconds(self) -> dict[str, float]:
        """Processor time of the browser's processes by their type [s]."""
        spent: dict[str, float] = {}
        for one in self.send("SystemInfo.getProcessInfo")["processInfo"]:
            spent[one["type"]] = spent.get(one["type"], 0.0) + float(one["cpuTime"])
        return spent


@contextmanager
def open_browser() -> Iterator[Page]:
    """A page of a new browser with an empty profile; both are gone afterwards.

    Raises PalpateError when no Chromium is installed or it does not start, MissingExtraError without `viewer`.
    """
    program = chromium.find()
    if program is None:
        raise PalpateError("no Chromium was found", why=f"none of {', '.join(chromium.NAMES)} is on the PATH",
                           mend="install it (Debian: apt-get install chromium)")  # fmt: skip
    try:
        from websockets.sync.client import connect
    except ModuleNotFoundError as missing:
        raise MissingExtraError("the measurement of the viewer", "viewer") from missing
    with tempfile.TemporaryDirectory(prefix="palpate-browser-", ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [program, f"--user-data-dir={profile}", *FLAGS], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            with connect(
                _address(process, Path(profile)), max_size=None, compression=None, open_timeout=_START
            ) as connection:
                yield Page(connection)
        finally:
            end_process(process)


def _address(process: subprocess.Popen[bytes], profile: Path) -> str:
    """Address of the browser's DevTools, which it writes into its profile."""
    file, end = profile / "DevToolsActivePort", time.monotonic() + _START
    while time.monotonic() < end and process.poll() is None:
        lines = file.read_text().split() if file.exists() else []
        if len(lines) == 2:
            return f"ws://127.0.0.1:{lines[0]}{lines[1]}"
        time.sleep(0.05)
    raise PalpateError("Chromium did not start", why=f"exit status {process.poll()}", mend="run it by hand to see why")
