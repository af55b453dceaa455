"""``palpate study demonstrations``."""

from __future__ import annotations

import math
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, make_folder, require_writable, say, write_json


@dataclass
class Command:
    """Simulated operators palpate scenes by the hundred, with forces, straight into one LeRobot data set.

    examples:
      palpate study demonstrations palpation --episodes 1000 --out dataset
      palpate study demonstrations nodule --vary objects.0.stiffness=200:400 --operators 50 --out dataset

    Each episode has its own operator, place, direction, force and values of the scene. The same command gives the same
    data set, and takes up one that was interrupted.
    """

    scenes: Positional[tuple[Path, ...]]
    """Scene files (YAML), or names of shipped scenes; they take turns."""
    out: Annotated[Path, arg(metavar="DIR")] = Path("demonstrations")
    """Folder of the data set; new, or empty."""
    episodes: Annotated[int, arg(metavar="N")] = 100
    """Number of episodes."""
    seconds: float = 10.0
    """Length of an episode [s]."""
    operators: Annotated[int, arg(metavar="N")] = 20
    """Number of simulated operators, who take turns (docs/operators.md)."""
    vary: Annotated[tuple[str, ...], arg(metavar="PATH=LOW:HIGH")] = ()
    """Values of the scene that are drawn for each episode, e.g. objects.0.stiffness=200:600."""
    spread: float = 0.008
    """Largest distance of the palpated place from the scene's, along x and y [m]."""
    seed: int = 7
    """Seed of all random numbers."""
    names: Literal["openh", "dvrk"] = "openh"
    """Names of Open-H-Embodiment, or of the dVRK's data collection."""
    version: Literal["3.0", "2.1"] = "3.0"
    """Version of the format."""
    fps: Annotated[int, arg(metavar="HZ")] = 30
    """Frames per second."""
    executor: Literal["local", "dask"] = "local"
    """local: processes of this machine; dask: a Dask cluster whose workers share the folder. Both give equal data."""
    address: Annotated[str | None, arg(metavar="TCP://HOST:PORT")] = None
    """Address of an existing Dask scheduler; without it, --executor dask starts a cluster on this machine."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Number of processes on this machine; default: one per core."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write facts of the data set as JSON (docs/json/export.md); - for the standard output."""

    def __call__(self) -> int:
        """Perform the episodes, write the data set, and say what it holds."""
        from functools import partial

        from palpate.base.sweep import Axis, sweep
        from palpate.export import Options
        from palpate.export.folder import require_free, whole_folder
        from palpate.export.formats.lerobot import write_episodes
        from palpate.export.formats.lerobot.splits import ordered
        from palpate_lab.studies.demonstrations import work

        console = console_for(self.json)
        require_writable(self.json)
        require_free(self.out)
        parts = self.out.parent / f".{self.out.name}.episodes"
        plan = self._plan(parts)
        make_folder(parts)
        try:
            swept = sweep(
                partial(work.episode, plan=plan), {"episode": Axis(range(self.episodes))}, self.seed, self.executor,
                workers=self.workers, address=self.address, resume=parts / "journal", console=console,
                title="demonstrations",
            )  # fmt: skip
        except KeyboardInterrupt:
            say(console, f"finished episodes are kept in {parts}: run the same command again to continue")
            raise
        listed = ordered(range(self.episodes), lambda k: not swept.values[k]["done"])
        options = Options(names=self.names, version=self.version, fps=self.fps)
        with whole_folder(self.out) as draft:
            episodes = (work.taken_up(plan, k, swept.values[k]) for k in listed)
            facts = write_episodes(episodes, draft, options, self._words())
        shutil.rmtree(parts)
        self._report(console, facts, swept.values)
        return 0

    def _plan(self, parts: Path) -> Any:
        from palpate.base.errors import PalpateError
        from palpate.scene import Scene
        from palpate_lab.studies.demonstrations.work import Plan, require_palpation

        if not self.scenes:
            raise PalpateError("there is no scene to palpate", mend="name one, such as palpation")
        if self.seconds > 30.0:
            raise PalpateError(f"--seconds {self.seconds:g}: an operator performs for 30 s at most", mend="give less")
        scenes = tuple(Scene.load(one) for one in self.scenes)
        for scene in scenes:
            require_palpation(scene)
        vary = tuple(_range(text) for text in self.vary)
        where = str(parts.resolve())
        return Plan(scenes, vary, self.operators, self.seed, self.seconds, self.spread, self.fps, where)

    def _words(self) -> str:
        names = ", ".join(str(one) for one in self.scenes)
        varied = f" Varied in each: {', '.join(self.vary)}." if self.vary else ""
        return (
            f"Simulated: {self.operators} simulated operators palpated {names} in closed loop, feeling the force with "
            f"delay and error and moving with noise; models of people, not people. Place, direction and force of the "
            f"strokes differ between episodes, all drawn from the seed {self.seed}.{varied} Episodes that touched for "
            f"less than half of their time, or with another force, are the split failure."
        )

    def _report(self, console: Any, facts: dict[str, Any], values: dict[int, Any]) -> None:
        done = sum(one["done"] for one in values.values())
        found = {**facts, "format": "lerobot", "out": str(self.out), "done": done,
                 "peak_N": max(one["peak_N"] for one in values.values())}  # fmt: skip
        say(console, f"{facts['episodes']} episodes, {facts['frames']} frames; {done} done, the others are `failure`")
        say(console, str(self.out), "wrote")
        write_json(self.json, found)


def _range(text: str) -> tuple[str, float, float]:
    """A path with its range, from ``objects.0.stiffness=200:600``."""
    from palpate.base.errors import PalpateError

    name, _, limits = text.partition("=")
    try:
        low, high = (float(part) for part in limits.split(":"))
    except ValueError:
        low, high = 1.0, 0.0
    if not name or not -math.inf < low <= high < math.inf:
        mend = "write a path and two rising numbers: objects.0.stiffness=200:600"
        raise PalpateError(f"--vary {text!r} is no range", mend=mend)
    return name, low, high
