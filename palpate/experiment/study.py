"""An experiment on disk: the frozen plan, the journals of its participants, and their records.

DIR/manifest.json                      seeds, versions, digests and the plan, written before the first trial
DIR/P01/journal.jsonl                  what happened, one line an event, each on the disk before the next begins
DIR/P01/trial-007-attempt-1/.../record.mcap
"""

from __future__ import annotations

import contextlib
import json
import os
import platform
import random
import shutil
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

from palpate.base import limits
from palpate.base.arrays.plain import plain
from palpate.base.errors import JournalError, OutputError, PalpateError
from palpate.experiment.journal import FILE, Journal, Progress, progress_of
from palpate.experiment.model import ExperimentFile
from palpate.experiment.plan import Plan, PlannedTrial, plan_of
from palpate.experiment.scenes import Settings
from palpate.scene.scene import Scene

MANIFEST = "manifest.json"
CODES = "codes.json"
"""File that leads from pseudonyms to the codes of the shared table; keep it apart, or delete it."""
BYTES_PER_TICK = 1500
"""Space that a tick of a record takes at most, before compression [bytes]."""


class Study:
    """An experiment in a folder; made there if it is new, otherwise compared with what was frozen.

    Args:
        experiment: the file.
        folder: where its data are.
        people: pseudonyms; those of the file when left out.
        simulated: True if all participants are simulated.
        frozen: False only looks: nothing is written into a folder that holds no experiment.
        trust: True lets drivers beside the scene files run (docs/security.md).

    Raises:
        JournalError: the folder holds another experiment, or a file was changed after the plan was frozen.
        OutputError: the folder cannot be written. SceneError, MeshError: a condition cannot run.
    """

    def __init__(
        self,
        experiment: ExperimentFile,
        folder: Path,
        people: tuple[str, ...] | None = None,
        simulated: bool = False,
        frozen: bool = True,
        trust: bool = False,
    ) -> None:
        self.experiment, self.folder, self.simulated = experiment, folder, simulated
        self.people = experiment.people if people is None else people
        self.plan: Plan = plan_of(experiment, self.people)
        self.settings = Settings(experiment, trust)
        self._frozen = self._manifest()
        path = folder / MANIFEST
        if path.exists():
            _require_same(read_manifest(path), self._frozen, path)
        elif frozen:
            self.freeze()

    def freeze(self) -> None:
        """Write the plan, unless it was written before.

        Raises:
            OutputError: the folder cannot be written.
        """
        path = self.folder / MANIFEST
        if not path.exists():
            _write_at_once(path, json.dumps(self._frozen, indent=1))

    def _manifest(self) -> dict[str, Any]:
        from palpate import __version__

        values = self.experiment.model_dump(mode="json")
        return {
            "experiment": values,
            "sha256": sha256(json.dumps(values, sort_keys=True).encode()).hexdigest(),
            "scenes": {f"{t}/{c}": _digest(setting.scene) for (t, c), setting in self.settings.all().items()},
            "simulated": self.simulated,
            "seed": self.experiment.seed,
            "plan": {who: [plain(asdict(one)) for one in trials] for who, trials in self.plan.items()},
            "palpate": __version__,
            "python": platform.python_version(),
        }

    def codes(self) -> dict[str, str]:
        """Random codes of the participants for data to share, drawn once and kept in `CODES`.

        Raises:
            JournalError: the file was changed. OutputError: it cannot be written.
        """
        path = self.folder / CODES
        if path.exists():
            known = _read(path)
            if set(known) != set(self.people):
                what = f"{CODES} is not that of these participants"
                raise JournalError(what, where=str(path), mend="restore it, or delete it: new codes are drawn")
            return known
        numbers = list(range(1, len(self.people) + 1))
        random.SystemRandom().shuffle(numbers)
        codes = {who: f"A{k:03d}" for who, k in zip(self.people, numbers, strict=True)}
        _write_at_once(path, json.dumps(codes))
        path.chmod(0o600)
        return codes

    def trial(self, who: str, number: int) -> PlannedTrial:
        """A planned trial, by its number from 1."""
        return self.plan[who][number - 1]

    def journal(self, who: str) -> Journal:
        """The journal of a participant, to write; it is to be closed.

        Raises:
            PalpateError: nobody has this pseudonym. SweepError: another process writes it.
        """
        self.require(who)
        return Journal(self.folder / who, len(self.plan[who]))

    def progress(self, who: str) -> Progress:
        """What a participant has done so far."""
        return progress_of(self.folder / who / FILE)

    def require(self, who: str) -> None:
        """Refuse a pseudonym that the experiment does not list.

        Raises:
            PalpateError: nobody has this pseudonym.
        """
        if who not in self.plan:
            shown = ", ".join(self.people[:8]) + (", ..." if len(self.people) > 8 else "")
            mend = f"name one of {shown}; the list cannot grow after the plan was frozen"
            raise PalpateError(f"there is no participant {who!r}", where=self.experiment.file, mend=mend)

    def require_space(self, trial: PlannedTrial) -> None:
        """Refuse to begin a trial that the disk cannot hold.

        Raises:
            OutputError: too little space is free.
        """
        setting = self.settings.of(trial.task, trial.condition)
        needed = BYTES_PER_TICK * setting.scene.rates.haptic * setting.course.task.time_limit
        free = shutil.disk_usage(self.folder).free
        if free < needed:
            what = f"no space for trial {trial.number}: {free / 1e6:.0f} MB are free, {needed / 1e6:.0f} MB are needed"
            mend = "make space, then run the same command again: it continues with this trial"
            raise OutputError(what, where=str(self.folder), mend=mend)


def read_manifest(path: Path) -> dict[str, Any]:
    """The manifest of an experiment.

    Raises:
        JournalError: the file cannot be read, or is none.
    """
    found = _read(path)
    if "plan" not in found:
        raise JournalError("this is no manifest of an experiment", where=str(path), mend="name another folder: --out")
    return found


def _read(path: Path) -> dict[str, Any]:
    mend = "restore it, or name another folder with --out; the records in this one are untouched"
    try:
        found = json.loads(limits.read_text(path))
    except (OSError, ValueError, RecursionError) as error:
        raise JournalError(f"{path.name} cannot be read", where=str(path), why=str(error), mend=mend) from None
    if not isinstance(found, dict):
        raise JournalError(f"{path.name} does not hold what was written", where=str(path), mend=mend)
    return found


def _require_same(found: dict[str, Any], now: dict[str, Any], path: Path) -> None:
    mend = "undo the change to go on, or begin a new experiment in another folder with --out; nothing was lost"
    changed = _difference(found.get("experiment"), now["experiment"])
    if changed:
        what = f"the experiment file was changed after its plan was frozen: {changed}"
        raise JournalError(what, where=str(path), mend=mend)
    scenes = [key for key in now["scenes"] if found.get("scenes", {}).get(key) != now["scenes"][key]]
    if scenes:
        what = f"the scene of {scenes[0]} was changed after the plan was frozen"
        raise JournalError(what, where=str(path), mend=mend)
    for key, words in (("simulated", "the kind of its participants"), ("plan", "the plan")):
        if found.get(key) != now[key]:
            what = f"the folder holds another experiment: {words} differs"
            raise JournalError(what, where=str(path), mend="name another folder with --out")


def _difference(was: Any, now: Any, place: str = "") -> str:
    """The first value that differs, in words; empty without one."""
    if isinstance(was, dict) and isinstance(now, dict):
        for key in sorted(was.keys() | now.keys()):
            found = _difference(was.get(key), now.get(key), f"{place}.{key}" if place else key)
            if found:
                return found
        return ""
    return "" if was == now else f"{place} was {json.dumps(was)[:80]} and is {json.dumps(now)[:80]}"


def _write_at_once(path: Path, text: str) -> None:
    """Write a file that is either absent or complete, whatever ends the process."""
    part = path.with_suffix(".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with part.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
        sync_folder(path.parent)
    except OSError as error:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        why = error.strerror or str(error)
        raise OutputError(
            f"{path.name} cannot be written", where=str(path), why=why, mend="name another --out"
        ) from None


def sync_folder(folder: Path) -> None:
    """Return when the names in a folder are on the disk."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _digest(scene: Scene) -> str:
    """A digest of all values of a scene, and of its files."""
    found = sha256(json.dumps(scene.model_dump(mode="json"), sort_keys=True).encode())
    for index, obj in enumerate(scene.objects):
        if obj.file is not None:
            found.update(limits.read_bytes(scene.path_of(index)))
    return found.hexdigest()[:16]
