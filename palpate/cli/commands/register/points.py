"""`palpate register points`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import Positional, UseAppendAction, arg

from palpate.cli.commands.register import _common


@dataclass
class Command(_common.Register):
    """Register fiducials: the pose of the moving frame in the fixed frame, with its error predicted at targets.

    examples:
      palpate register points scan.csv tracker.csv --target tumour=0.02,0.01,-0.05 --out X_KS.yaml
      palpate register points psm1.csv psm2.csv --unknown --json -

    Files of 3D Slicer (.fcsv, .mrk.json) are read in LPS. A CSV has one row per marker: columns x, y, z, optionally
    name (rows then correspond by name) and sx, sy, sz (standard deviations). The same command registers two arms that
    touched the same points, or each other's tips.
    Targets are in the moving frame. docs/registration.md explains the figures.
    """

    moving: Positional[Path]
    """Fiducials in the moving frame (CSV)."""
    fixed: Positional[Path]
    """The same fiducials in the fixed frame (CSV)."""
    target: Annotated[UseAppendAction[tuple[str, ...]], arg(metavar="[NAME=]X,Y,Z")] = ()
    """Target in the moving frame [m]; may be repeated."""
    unknown: bool = False
    """The rows do not correspond: find out which marker is which."""
    fle: float | None = None
    """Localisation error of both files together, rms length [m]; default: columns sx, sy, sz, or the residuals."""
    limit: float | None = None
    """Largest TRE that is enough [m]; beyond it the command says where to add a point, and returns 1.

    With an estimated localisation error the upper 95 % bound of the TRE counts: points are added until the limit is
    met, which would flatter the estimate itself.
    """

    def __call__(self) -> int:
        """Register, print, write."""
        from palpate.world.registration import files, points

        console = self.begin()
        names, goals = _common.targets(self.target)
        moving, fixed = (files.read_points(path, self.unit) for path in (self.moving, self.fixed))
        alone, unit = tuple[str, ...](), ""
        if not self.unknown:
            moving, fixed, alone = files.by_name(moving, fixed)
            moving, fixed, unit = files.in_measured_unit(moving, fixed, (self.moving.name, self.fixed.name))
        stated = self.fle is not None
        found = points(
            moving.p, fixed.p, goals, correspond=not self.unknown, names=moving.names,
            fle=self.fle if stated else fixed.sigma, fle_moving=None if stated else moving.sigma,
        )  # fmt: skip
        values = _common.values_of("points", found, names)
        values["names"] = list(moving.names)
        values["outlier_names"] = [moving.names[i] for i in found.outliers]
        if unit:
            values["warnings"].append(unit)
        if alone:
            values["warnings"].append(f"markers in one file alone, not used: {', '.join(alone)}")
        self.finish(console, [*_lines(values), *self._advice(values)], values, (self.moving, self.fixed))
        return int(self.limit is not None and any(tre > self.limit for tre in values["tre_95"]))

    def _advice(self, values: dict[str, Any]) -> list[str]:
        added = values["addition"]
        if added is None:
            return []
        lead = "one more point lowers the TRE most"
        if self.limit is not None and max(values["tre_95"]) > self.limit:
            lead = f"not enough for {1e3 * self.limit:g} mm: add a point"
        place = ", ".join(f"{x:+.3f}" for x in added["p"])
        return [f"{lead} at ({place}) m of the moving frame: largest TRE {1e3 * max(added['tre']):.3f} mm"]


def _lines(values: dict[str, Any]) -> list[str]:
    used = sum(i >= 0 for i in values["correspondence"]) - len(values["outliers"])
    origin = "estimated from the residuals" if values["estimated"] else "as stated"
    left = [x for i, x in enumerate(values["leave_one_out"]) if x is not None and i not in values["outliers"]]
    lines = [
        "X, fixed = X moving:", *_common.lines_of_pose(values["X"]),
        f"{used} points used; FRE {1e3 * values['fre']:.3f} mm rms; FLE {1e3 * values['fle']:.3f} mm rms, {origin}",
    ]  # fmt: skip
    if values["estimated"] and values["tre_95"]:
        lines.append(
            f"upper 95 % bound of the largest TRE, which --limit judges: {1e3 * max(values['tre_95']):.3f} mm rms"
        )
    if left:
        lines.append(f"leave one out: each point is predicted by the others within {1e3 * max(left):.3f} mm")
    for i, name in zip(values["outliers"], values["outlier_names"], strict=True):
        lines.append(f"wrong marker: {name}, {1e3 * values['residuals'][i]:.2f} mm from its place; not used")
    return lines
