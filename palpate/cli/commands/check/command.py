"""`palpate check`."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError, PalpateWarning
from palpate.cli.terminal.output import console_for, say, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.cli.commands.check import grid, mesh, scene

    Findings = grid.Findings | mesh.Findings | scene.Findings | scene.PairsFindings

_SCENES = (".yaml", ".yml")


@dataclass
class Command:
    """Check a scene, a mesh or a distance grid without a run: report mistakes, repairs and recommended settings.

    examples:
      palpate check scenes/palpation.yaml
      palpate check organ.stl --unit mm
      palpate check scan.ply --unit m --feature 4 --noise 0.3
      palpate check organ.stl --repair mended.stl

    --repair writes a copy with cracks sewn, slivers collapsed, thin triangles improved and small holes filled; it
    never changes the file itself.
    """

    file: Positional[Path]
    """Scene (YAML), mesh (STL, OBJ, PLY, ...), volume (.nrrd, .nii.gz, .mha), or distance grid (.npz, .nrrd)."""
    trust: bool = False
    """Of a scene: import the driver that it names, although it is not installed, and check its facts."""
    unit: Literal["mm", "cm", "m", "in"] | None = None
    """Unit of the numbers in a mesh file; when left out that of the file or its format, otherwise mm."""
    label: str | None = None
    """Number or name of the segment of a segmentation."""
    threshold: float | None = None
    """Of a CT volume: smallest value inside, e.g. 200 for bone, in Hounsfield units."""
    radius: Annotated[float | None, arg(metavar="MM")] = None
    """Radius of the sphere that will touch the mesh; the default radius when left out."""
    stiffness: Annotated[float | None, arg(metavar="N/M")] = None
    """Stiffness that the mesh will have; the default stiffness when left out."""
    feature: Annotated[float | None, arg(metavar="MM")] = None
    """Width of the narrowest feature to feel; estimated from the mesh's hollows when left out."""
    noise: Annotated[float | None, arg(metavar="MM")] = None
    """Noise (standard deviation) of the scanner that measured the mesh; estimated from its roughness when left out."""
    repair: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write a repaired copy of the mesh, in the same unit."""
    hole: Annotated[float | None, arg(metavar="MM")] = None
    """Widest hole that --repair fills; a tenth of the mesh when left out."""
    force: bool = False
    """Allow --repair to overwrite a file."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the findings as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Check the file; warnings are printed, mistakes are raised. Returns the exit code."""
        from palpate.devices.certificate.device import is_device
        from palpate.scene import shipped

        console, path = console_for(self.json), shipped.find(self.file)
        is_scene = path.suffix.lower() in _SCENES
        if is_scene and is_device(path):
            raise PalpateError(f"{path}: is the model of a device, not a scene", mend=f"palpate certify {path}")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = self._inspect(path, console)
        texts = [str(w.message) for w in caught if issubclass(w.category, PalpateWarning)]
        for text in texts:
            say(console, text, "warning:", "yellow")
        verdict = "ready to run" if is_scene else "can be touched"
        say(console, f"{path}: {verdict}" + (f", with {len(texts)} warnings" if texts else ""))
        if self.json is not None:
            from palpate.base.arrays.plain import plain

            write_json(self.json, {"file": str(path), "ok": True, "warnings": texts, **plain(result)})
        return 0

    def _inspect(self, path: Path, console: Console) -> Findings:
        from palpate.cli.commands.check import grid, mesh, scene
        from palpate.world.mesh.volume_files import is_volume
        from palpate.world.mesh.volumes import Selection
        from palpate.world.surfaces import volume_grid

        touch = mesh.Touch.of(self.radius, self.stiffness, self.feature, self.noise, self.repair, self.hole, self.force)
        ending = path.suffix.lower()
        if ending in _SCENES:
            return scene.inspect(path, console, self.trust)
        label = int(self.label) if self.label is not None and self.label.isdecimal() else self.label
        part = Selection(label, self.threshold)
        grids = ending == ".npz" or (is_volume(path) and part == Selection() and volume_grid.holds_distances(path))
        if grids:
            return grid.inspect(path, self.unit or "mm", console)
        return mesh.inspect(path, self.unit, part, touch, console)
