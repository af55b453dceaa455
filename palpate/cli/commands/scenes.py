"""`palpate scenes`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg


@dataclass
class Command:
    """List the scenes that come with Palpate, or copy one to change it.

    examples:
      palpate scenes
      palpate scenes nodule --out my_nodule.yaml

    The name alone runs a scene from any folder: palpate run palpation.
    """

    name: Positional[str] = ""
    """Name of the scene to copy; the scenes are listed when left out."""
    out: Annotated[Path | None, arg(metavar="FILE")] = None
    """The file to write; NAME.yaml in this folder when left out."""
    force: bool = False
    """Overwrite the file."""

    def __call__(self) -> int:
        """List the scenes, or copy one."""
        import difflib

        from palpate.base.errors import SceneError, refuse_to_overwrite
        from palpate.cli.terminal.output import write_text
        from palpate.scene import shipped

        names = shipped.names()
        if not self.name:
            for name in names:
                print(f"{name:12} {shipped.summary(name)}")
            return 0
        if self.name not in names:
            near = difflib.get_close_matches(self.name, names, n=1)
            mend = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(names)}"
            raise SceneError(f"there is no shipped scene {self.name!r}", mend=mend)
        out = self.out or Path(f"{self.name}.yaml")
        refuse_to_overwrite(out, self.force)
        write_text(out, shipped.copy_text(self.name))
        print(f"{out}: copied; run it with: palpate run {out}")
        return 0
