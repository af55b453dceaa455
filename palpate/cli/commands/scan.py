"""`palpate scan`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from palpate.base.errors import CloudError, refuse_to_overwrite
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.table import Table

    from palpate.base.arrays import Array
    from palpate.sensing.depth_camera import Body
    from palpate.world.clouds import PointCloud
    from palpate.world.scan import Scan


@dataclass
class Command:
    """Make a surface that can be touched from the views of a depth camera: align, reconstruct, report holes.

    examples:
      palpate scan view1.pcd view2.pcd view3.pcd --unit m --out organ.ply
      palpate scan views/*.ply --frames poses.yaml --unit mm --out organ.ply
      palpate scan palpation --views 12 --noise 1 --out organ.ply

    Give the views in the order of the camera's motion. With a scene instead of clouds, a simulated camera looks at its
    first object from all around, and the error against the true surface is reported.
    """

    clouds: Positional[tuple[Path, ...]]
    """Clouds (.pcd, .ply, .npz, .xyz, .csv), each in the frame of its camera; or one scene (.yaml)."""
    out: Annotated[Path | None, arg(metavar="FILE.ply")] = None
    """The mesh to write, in metres (.ply, .stl, .obj)."""
    unit: Literal["m", "mm", "cm", "in"] | None = None
    """Unit of the clouds; not needed for files that state it."""
    frames: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Rough poses of the views: a file with frames (docs/frames.md) that have the names of the clouds' files."""
    cell: Annotated[float | None, arg(metavar="MM")] = None
    """Size of a cell; from noise and spacing of the points when left out [mm]."""
    reach: Annotated[float | None, arg(metavar="MM")] = None
    """Largest error of the rough poses; a tenth of the first view's size when left out [mm]."""
    holes: Literal["auto", "close", "open"] = "auto"
    """Holes in the surface; auto: they are closed if they are at most a fifth of the area."""
    views: Annotated[int, arg(metavar="N")] = 12
    """Of a scene: number of simulated views, 1 to 100."""
    noise: Annotated[float, arg(metavar="MM")] = 1.0
    """Of a scene: noise of the simulated camera on the visible side of the object [mm]."""
    seed: int = 0
    """Of a scene: seed of the simulated errors."""
    doubtful: bool = False
    """Write the mesh, and end with 0, even where the views do not agree."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json/scan.md); - for the standard output."""

    def __call__(self) -> int:
        """Scan, write the mesh, print the figures."""
        from palpate.world.scan import scan

        console = console_for(self.json)
        self._refuse()
        require_writable(self.out)
        require_writable(self.json)
        simulated = self.clouds[0].suffix in (".yaml", ".yml") or not self.clouds[0].suffix
        body = self._body() if simulated else None
        clouds, poses = self._read() if body is None else self._simulated(body)
        close = {"auto": None, "close": True, "open": False}[self.holes]
        cell, reach = (None if mm is None else 1e-3 * mm for mm in (self.cell, self.reach))
        found = scan(clouds, poses, spacing=cell, reach=reach, close=close)
        values = values_of(found) | ({} if body is None else {"error_m": _error(found, body)})
        wanted = self.out if not found.doubt or self.doubtful else None
        if wanted is not None:
            from palpate.world.mesh import files

            files.write(wanted, found.vertices, found.triangles)
        console.print(_table(values))
        if found.doubt:
            mend = "give the views in the order of the motion, with more overlap, or their rough poses (--frames)"
            say(console, f"{found.doubt}; {mend}", "doubt:", "red")
        if wanted is not None:
            say(console, f"wrote {wanted}; in a scene:  - {{mesh: {wanted}, unit: m}}")
        elif self.out is not None:
            say(console, f"{self.out} is not written; --doubtful writes it all the same")
        write_json(self.json, values)
        return int(bool(found.doubt) and not self.doubtful)

    def _refuse(self) -> None:
        if not self.clouds:
            raise CloudError("no cloud is given", mend="palpate scan view1.pcd view2.pcd --out organ.ply")
        if self.out is not None:
            if self.out.suffix.lower() not in (".ply", ".stl", ".obj"):
                raise CloudError(f"unknown format {self.out.suffix!r}", where=str(self.out), mend="write organ.ply")
            if self.out.exists():
                refuse_to_overwrite(self.out, False)
        for name, value, low, high in (("cell", self.cell, 0.0, 1000.0), ("reach", self.reach, 0.0, 1000.0),
                                       ("noise", self.noise, -1.0, 100.0), ("views", self.views, 0, 100)):  # fmt: skip
            if value is not None and not low < value <= high:
                raise CloudError(f"--{name} {value:g} is out of range", mend=f"give at most {high:g}")

    def _read(self) -> tuple[list[PointCloud], list[Array] | None]:
        from palpate.world.clouds import PointCloud

        clouds = [PointCloud.load(path, self.unit) for path in self.clouds]
        if self.frames is None:
            return clouds, None
        from palpate.world.frames import files

        graph = files.load(self.frames)
        for path in self.clouds:
            if path.stem not in graph.frames:
                names = ", ".join(graph.frames) or "none"
                what, mend = f"there is no frame {path.stem!r}", f"name a frame after each cloud; frames: {names}"
                raise CloudError(what, where=str(self.frames), mend=mend)
        return clouds, [graph.pose(path.stem).X for path in self.clouds]

    def _body(self) -> Body:
        from palpate.scene import Scene
        from palpate.scene.surface import placed
        from palpate.sensing.depth_camera import Body

        if len(self.clouds) > 1:
            raise CloudError("a scene stands beside clouds", where=str(self.clouds[0]), mend="give one or the other")
        found = placed(Scene.load(self.clouds[0]))[0].body
        return Body(found.name, found.vertices, found.triangles)

    def _simulated(self, body: Body) -> tuple[list[PointCloud], list[Array]]:
        from palpate.sensing.around import around

        views = around(body, self.views, 1e-3 * self.noise, self.seed)
        return list(views.clouds), list(views.stated)


def values_of(found: Scan) -> dict[str, Any]:
    """The keys of docs/json/scan.md, without the error against a true surface."""
    from palpate.base.arrays.plain import plain

    return {
        "rms_m": found.rms, "noise_m": found.noise, "triangles": len(found.triangles), "seconds": found.seconds,
        "views": len(found.poses), "points": found.points, "outliers": found.outliers, "cell_m": found.spacing,
        "in_front": found.in_front[0], "trusted": not found.doubt, "doubt": found.doubt or None,
        "closed": found.closed, "holes": [{"area_m2": h.area, "centre": plain(h.centre)} for h in found.holes],
        "poses": plain(found.poses),
    }  # fmt: skip


def _error(found: Scan, body: Body) -> dict[str, float]:
    """Rms and largest distance [m] of the scan's vertices from the true surface."""
    import numpy as np

    from palpate.world.mesh import Mesh, quiet

    with quiet():
        away = Mesh(body.vertices, body.triangles).closest(found.vertices)[0]
    return {"rms": float(np.sqrt(np.square(away).mean())), "max": float(away.max())}


def _table(values: dict[str, Any]) -> Table:
    from rich.table import Table

    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("points", f"{values['points']:,} of {values['views']} views; {values['outliers']:,} left out")
    table.add_row("surface", f"{values['triangles']:,} triangles, cells of {1e3 * values['cell_m']:.2f} mm")
    table.add_row(
        "cloud to surface", f"{1e3 * values['rms_m']:.2f} mm rms; noise of the points {1e3 * values['noise_m']:.2f} mm"
    )
    if "error_m" in values:
        error = values["error_m"]
        table.add_row("error", f"{1e3 * error['rms']:.2f} mm rms, {1e3 * error['max']:.2f} mm at most, true surface")
    table.add_row("boundary", "closed: ready to touch" if values["closed"] else "open: felt from both sides")
    for hole in values["holes"][:5]:
        x, y, z = (f"{1e3 * c:.0f}" for c in hole["centre"])
        state = "closed by a membrane" if values["closed"] else "open"
        table.add_row("hole", f"{1e6 * hole['area_m2']:,.0f} mm^2 near ({x}, {y}, {z}) mm: {state}")
    table.add_row("time", f"{values['seconds']:.1f} s")
    return table
