"""`palpate register check`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rich.console import Console
from tyro.conf import Positional, arg

from palpate.cli.commands.register import _session
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from palpate.base.arrays import Array
    from palpate.scene import Scene
    from palpate.scene.registered import RegisteredOrgan
    from palpate.world.registration.touches import Guess


@dataclass
class Command:
    """Check a registration by touch: where contact is felt against where the registered organ predicts it.

    examples:
      palpate register check scenes/registration.yaml
      palpate register check my.yaml --attended --places 12

    The result and its date are kept in the file of the registration. A registration that fails is marked as not
    trusted there, so that no scene uses it, and the command returns 1.
    """

    scene: Positional[Path]
    """Scene file (YAML) with a section registration, whose session has been done."""
    places: int = 8
    """Number of places to touch, at least 4."""
    attended: bool = False
    """An operator touches the organ, also where the scene could be simulated."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the result as JSON (docs/json.md); - for the standard output."""
    seed: int | None = None
    """Seed of the simulated errors; the scene's when left out."""

    def __call__(self) -> int:
        """Touch, compare, keep the result."""
        from palpate.base.errors import RegistrationError
        from palpate.scene import Scene
        from palpate.scene.registered import RegisteredOrgan, entry, file_of
        from palpate.world.frames import files
        from palpate.world.registration.touch_check import check
        from palpate.world.registration.touches import touched_by

        console, scene = console_for(self.json), Scene.load(self.scene)
        if self.places < 4:
            raise RegistrationError(f"--places {self.places} are too few", mend="touch 4 or more, e.g. --places 8")
        path = file_of(scene)
        registered = files.edge(entry(scene), lambda name: path)
        require_writable(path)
        require_writable(self.json)
        scanned = RegisteredOrgan(scene)
        found = _in_organ_frame(scanned, registered.X, registered.covariance)
        simulated = scanned.section.simulated is not None and not self.attended
        X_WT, radius = (self._simulated if simulated else self._attended)(console, scene, scanned, found)
        given = scanned.section
        touched = touched_by(X_WT, radius, 1e-3 * given.touch_mm, 1e-3 * given.tip_mm)
        result = check(scanned.organ, found, touched, given.accuracy)
        for line in _session.lines_of_check(result):
            say(console, line)
        for doubt in result.doubts:
            say(console, doubt, "failed:", "red")
        values = _session.values_of_check(result)
        _keep(path, values)
        say(console, f"{'passed' if result.passed else 'not trusted any more'}, kept in {path}")
        write_json(self.json, values)
        return int(not result.passed)

    def _simulated(
        self, console: Console, scene: Scene, scanned: RegisteredOrgan, found: Guess
    ) -> tuple[list[Array], float]:
        from palpate.simulators.room import Room
        from palpate.world.registration.procedure import nothing_felt
        from palpate.world.registration.touch_check import spread

        say(console, "simulated: a hand touches the organ")
        hand = Room(scene, self.seed).hand
        places = spread(scanned.organ, found.X, self.places, hand.reaches)
        touched = [X for X in (hand.touch(p, n) for p, n in places) if X is not None]
        if 2 * len(touched) <= self.places:
            raise nothing_felt(self.places - len(touched))
        return touched, hand.radius

    def _attended(
        self, console: Console, scene: Scene, scanned: RegisteredOrgan, found: Guess
    ) -> tuple[list[Array], float]:
        from palpate.cli.commands.register import _attended
        from palpate.world.registration.touch_check import spread

        with _attended.pointer(scene, scanned, self.seed) as pointer:
            dialogue = _attended.Dialogue(console, scene, scanned, pointer, seed=self.seed)
            places = [p for p, _ in spread(scanned.organ, found.X, self.places)]
            return dialogue.touches_of(places), pointer.radius


def _in_organ_frame(scanned: RegisteredOrgan, X_WA: Array, covariance: Array) -> Guess:
    import numpy as np

    from palpate.base.arrays.rigid import composed_covariance
    from palpate.world.registration.touches import Guess

    C = composed_covariance(X_WA, covariance, scanned.X_AO, np.zeros((6, 6)))
    return Guess(X_WA @ scanned.X_AO, C)


def _keep(path: Path, values: dict[str, Any]) -> None:
    """Add the check to the file of the registration, and mark the registration as not trusted if it failed."""
    from palpate.base.arrays.yaml_loader import read_yaml

    data = read_yaml(path)
    data |= {"check": values, "trusted": bool(data.get("trusted", True)) and values["passed"]}
    _session.write(path, data)
