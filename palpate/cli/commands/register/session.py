"""`palpate register session`."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rich.console import Console
from tyro.conf import Positional, arg

from palpate.base.errors import refuse_to_overwrite
from palpate.cli.commands.register import _session
from palpate.cli.terminal import PORT
from palpate.cli.terminal.output import console_for, make_folder, require_writable, say, write_json

if TYPE_CHECKING:
    from palpate.cli.commands.register._attended import Dialogue, Pointer
    from palpate.scene import Scene
    from palpate.scene.registered import RegisteredOrgan
    from palpate.world.registration.procedure import Procedure


@dataclass
class Command:
    """Register the organ of a scene step by step: what to touch next, until the error at its targets is small enough.

    examples:
      palpate register session scenes/registration.yaml
      palpate register session my.yaml --attended --accuracy 0.8mm --out registered/liver.yaml

    A scene that states a true pose (registration.simulated) runs unattended with a simulated camera and hand, and the
    true errors are printed too. Otherwise, or with --attended, an operator touches the organ and presses Enter. Nothing
    is written unless the accuracy is met (docs/registration-session.md).
    """

    scene: Positional[Path]
    """Scene file (YAML) with a section registration."""
    accuracy: Annotated[str | None, arg(metavar="LENGTH")] = None
    """Error that no target may exceed with 95 %, such as 1mm; the scene's when left out."""
    motion: Annotated[str | None, arg(metavar="LENGTH")] = None
    """Touch on until a motion of the organ by this much, half-way through the touches, would be told 9 of 10 times."""
    attended: bool = False
    """An operator touches the organ, also where the scene could be simulated."""
    viewer: bool = False
    """Attended: show arms, organ, the next place and the errors of the targets in the browser."""
    port: int = PORT
    """Port of the viewer on 127.0.0.1; the next free one when it is taken."""
    out: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """File for the pose; the file of the scene's frame when left out."""
    force: bool = False
    """Overwrite an existing file."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the result as JSON (docs/json.md); - for the standard output."""
    seed: int | None = None
    """Seed of the simulated errors; the scene's when left out."""

    def __call__(self) -> int:
        """Register, print, write."""
        from palpate.scene import Scene
        from palpate.scene.registered import RegisteredOrgan, file_of

        console = console_for(self.json)
        scene = self._with_demands(Scene.load(self.scene))
        out = self.out or file_of(scene)
        refuse_to_overwrite(out, self.force)
        make_folder(out.parent)
        require_writable(out)
        require_writable(self.json)
        scanned = RegisteredOrgan(scene)
        if scanned.section.simulated is not None and not self.attended:
            procedure, true = self._simulated(console, scene, scanned)
        else:
            procedure, true = self._attended(console, scene, scanned), {}
        data = _session.values(scanned, procedure, [str(self.scene)])
        for line in _session.lines_of_targets(procedure):
            say(console, line)
        for name, error in true.items():
            say(console, f"{1e3 * error:.2f} mm", f"true error at {name} (simulated):")
        for key, what in (
            ("smallest_motion", "half-way through the touches"),
            ("smallest_motion_seen", "between the views"),
        ):
            if data[key] is not None:
                say(console, f"a motion of the organ {what} is told from {1e3 * data[key]:.1f} mm on (9 of 10 times)")
        _session.write(out, data)
        say(console, f"accuracy met after {data['touches']} touches, pose written to {out}")
        took = time.process_time()  # of the whole process, its imports included
        say(console, f"{took:.1f} s of processor time")
        write_json(self.json, data | {"true_errors": true or None, "processor_s": took})
        return 0

    def _with_demands(self, scene: Scene) -> Scene:
        given = {"registration.accuracy": self.accuracy, "registration.motion": self.motion}
        changed = {key: value for key, value in given.items() if value is not None}
        if not changed or scene.registration is None:
            return scene
        from palpate.scene.overrides import override

        return override(scene, changed)

    def _simulated(
        self, console: Console, scene: Scene, scanned: RegisteredOrgan
    ) -> tuple[Procedure, dict[str, float]]:
        from palpate.simulators.room import Room
        from palpate.simulators.unattended import true_errors, unattended

        say(console, "simulated: a depth camera looks at the organ, then a hand touches it")
        room = Room(scene, self.seed)
        procedure = unattended(scanned, room, lambda state: _session.progress(console, scanned.section, state))
        return procedure, true_errors(scanned, room, procedure.found.X)

    def _attended(self, console: Console, scene: Scene, scanned: RegisteredOrgan) -> Procedure:
        from palpate.cli.commands.register import _attended

        with _attended.pointer(scene, scanned, self.seed) as pointer:
            dialogue = _attended.Dialogue(console, scene, scanned, pointer, seed=self.seed)
            with self._shown(console, pointer, dialogue):
                return dialogue.run()

    def _shown(self, console: Console, pointer: Pointer, dialogue: Dialogue) -> AbstractContextManager[object]:
        if not self.viewer:
            return nullcontext()
        from palpate.cli.commands.register import _viewer

        return _viewer.shown(console, pointer, dialogue, self.port)
