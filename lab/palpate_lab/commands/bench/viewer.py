"""`palpate bench viewer`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json
from palpate.cli.terminal.view import require_viewer


@dataclass
class Command:
    """Measure the viewer: frames per second in a headless Chromium that renders by software.

    Needs Chromium. Beside each scene stands an empty page of the same size in the same browser.

    examples:
      palpate bench viewer
      palpate bench viewer scenes/two_hands.yaml --quality full
      palpate bench viewer --every --duration 5
      palpate bench viewer --json viewer.json
    """

    scenes: Positional[tuple[str, ...]] = ("two_hands", "soft_liver")
    """Scene files, or names of shipped scenes, which run in real time."""

    every: bool = False
    """Measure every shipped scene; those that need a device, a robot or a network are left out by name."""

    size: tuple[int, int] = (1200, 700)
    """Width and height of the window [pixels]."""

    duration: float = 10.0
    """Time of each measurement [s]."""

    quality: Literal["automatic", "full", "light"] = "automatic"
    """Of the picture; automatic is light without a graphics card."""

    scale: float | None = None
    """Drawn pixels per pixel of the page; without it the page adapts them to the measured frame rate."""

    picture: Annotated[Path | None, arg(metavar="FOLDER")] = None
    """Write a picture of each page into this folder."""

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.scene import shipped
        from palpate_lab.verify.bench import viewer

        if min(self.size) < 200 or not 1.0 <= self.duration <= 600.0:
            raise PalpateError(
                f"--size {self.size[0]} {self.size[1]} --duration {self.duration:g}: too small or too long",
                mend="at least 200 pixels each way, and 1 to 600 s",
            )
        if self.scale is not None and not 0.1 <= self.scale <= 2.0:
            raise PalpateError(f"--scale {self.scale:g}: must be 0.1 to 2", mend="e.g. --scale 0.5")
        require_viewer()
        console = console_for(self.json)
        require_writable(self.json)
        if self.picture is not None:
            self.picture.mkdir(parents=True, exist_ok=True)
        found = []
        for scene in shipped.names() if self.every else self.scenes:
            file = None if self.picture is None else self.picture / f"{Path(scene).stem}.png"
            try:
                found.append(
                    viewer.run(
                        scene, self.size, self.duration, self.quality, self.scale, file,
                        on_progress=lambda text: say(console, text),
                    )
                )  # fmt: skip
            except PalpateError as error:
                if not self.every:
                    raise
                say(console, f"{scene} is left out: {error.what}")
                continue
            if self.every:  # all scenes take many minutes: what is measured so far is told and kept
                say(console, viewer.table(found[-1:]))
                write_json(None if self.json == Path("-") else self.json, {"rows": found})
        if not found:
            raise PalpateError("none of the scenes could be shown", mend="palpate doctor tells what the viewer lacks")
        if not self.every:
            say(console, viewer.table(found))
        write_json(self.json, {"rows": found})
        return 0
