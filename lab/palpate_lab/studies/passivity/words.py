"""Terminal output of ``palpate study passivity``."""

from __future__ import annotations

from rich.console import RenderableType
from rich.table import Table

from palpate_lab.studies.passivity.result import StudyResult


def tables(result: StudyResult) -> list[RenderableType]:
    """Tables for a terminal."""
    energy = Table(
        box=None, pad_edge=False, title=f"{result['runs']} runs: the port's true energy", title_justify="left"
    )
    for column in ("layer", "lowest, with device", "below -1 mJ", "lowest, wall alone", "below -1 mJ", "diverged",
                   "oscillates"):  # fmt: skip
        energy.add_column(column, justify="left" if column == "layer" else "right")
    for m in result["modes"]:
        energy.add_row(m["mode"], f"{1e3 * m['lowest_port_J']:.3g} mJ", str(m["below_bound"]),
                       f"{1e3 * m['lowest_rendered_J']:.3g} mJ",
                       *(str(m[key]) for key in ("rendered_below_bound", "diverged", "oscillates")))  # fmt: skip
    felt = Table(box=None, pad_edge=False, title="force changed by 1 % and more", title_justify="left")
    for column in ("of the runs that are", "runs", "changed", "largest change"):
        felt.add_column(column, justify="left" if column.startswith("of") else "right")
    for c in result["changes"]:
        felt.add_row(c["of"], str(c["runs"]), str(c["changed"]), f"{100 * c['largest_change']:.2g} %")
    for d in result["by_delay"]:
        to = f"to {1e3 * d['to_s']:g} ms" if d["to_s"] else "and more"
        felt.add_row(f"certified and calm, delay of {1e3 * d['from_s']:g} ms {to}", str(d["runs"]), str(d["changed"]),
                     f"{100 * d['largest_change']:.2g} %")  # fmt: skip
    return [energy, felt]
