"""Terminal output of ``palpate study contact``: the slides of each method over the finest meshes."""

from __future__ import annotations

from collections.abc import Iterable

from rich.table import Table

from palpate.scene.contact.judging import PATHS, RADIUS
from palpate.scene.contact_method import METHODS
from palpate.world.shapes.analytic import SHAPES
from palpate.world.shapes.paths import tool_path
from palpate_lab.studies.contact.result import Row


def table(rows: Iterable[Row]) -> Table:
    """Table of the slides by method, path and shape on the finest mesh, with the figures of the benchmark."""
    slides = [r for r in rows if r["path"] in PATHS]
    finest = {
        shape: max(r["triangles"] for r in slides if r["shape"] == shape) for shape in {r["shape"] for r in slides}
    }
    out = Table(title="r = 2 mm, k = 500 N/m, 50 mm/s; finest mesh of each", box=None, padding=(0, 1, 0, 0))
    columns = ("path", "method", "shape", "us\np50/p99", "direction deg\nmed/p95/max", "force mN\np95/max")
    for i, column in enumerate((*columns, "step\ndeg", "lost\n%", "flipped\n%", "arte-\nfacts", "work\nmJ")):
        out.add_column(column, justify="left" if i < 3 else "right", no_wrap=True)
    samples = _steady_samples()
    last = ""
    for r in sorted(slides, key=lambda r: (-list(PATHS).index(r["path"]), METHODS.index(r["method"]))):
        if r["triangles"] != finest[r["shape"]]:
            continue
        out.add_row(
            r["path"],
            r["method"],
            r["shape"],
            f"{r['p50_us']:.1f}/{r['p99_us']:.0f}",
            "no force"
            if r["lost"] == samples
            else f"{r['direction_median_deg']:.2f}/{r['direction_p95_deg']:.2f}/{r['direction_max_deg']:.1f}",
            f"{r['magnitude_p95_mN']:.1f}/{r['magnitude_max_mN']:.1f}",
            f"{r['step_deg']:.1f}",
            f"{100 * r['lost'] / samples:.0f}",
            f"{100 * r['flipped'] / samples:.0f}",
            f"{r['artefacts']}",
            f"{round(r['energy_mJ'], 2) + 0.0:.2f}",
            style="bold" if r["method"] == "proxy" else None,
            end_section=last not in ("", r["method"]),
        )
        last = r["method"]
    return out


def _steady_samples() -> int:
    steady = tool_path(SHAPES["box"], *PATHS["shallow"], RADIUS).steady
    return int(steady.stop - steady.start)
