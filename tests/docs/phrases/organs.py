"""Phrases of the page on ridges, creases and slivers of organ meshes."""

from __future__ import annotations

from phrases.values import Result, Tie


def ridges(found: Result) -> list[str]:
    rows = {(row["mesh"], row["depth_mm"]): row for row in found["rows"]}
    out = []
    for R, depth in ((0, 1.0), (1, 1.0), (1, 2.0), (2, 1.0), (2, 2.0)):
        fine, coarse = (rows[f"ridge {R} mm, facets {edge} mm", depth] for edge in (0.3, 2.6))
        out.append(
            f"| {depth:g} mm | {fine['true_step_deg']:.1f} deg | {fine['step_deg']:.1f} deg | "
            f"{coarse['step_deg']:.1f} deg | {coarse['limited_step_deg']:.1f} deg |"
        )
    return out


def slides(found: Result) -> list[str]:
    rows = [
        row for row in found["rows"] if row["true_step_deg"] is None and row["noise_mm"] == 0.0 and not row["repaired"]
    ]
    cells = {
        (row["mesh"], row["depth_mm"]): f"{row['step_deg']:.1f} deg | {row['limited_step_deg']:.1f} deg | "
        f"{100 * row['large_share']:.2f} %" for row in rows
    }  # fmt: skip
    return [f"| {mesh} | {cells[mesh, 1.0]} | {cells[mesh, 2.0]} |" for mesh in dict.fromkeys(r["mesh"] for r in rows)]


def causes(found: Result) -> list[str]:
    rows = [row for row in found["rows"] if row["noise_mm"] == 0.0 and not row["repaired"]]
    steps = {row["mesh"]: row["step_deg"] for row in rows if row["depth_mm"] == 1.0}
    largest = max(row["limited_step_N"] for row in rows)
    return [
        f"tilts the smooth surface for three ticks ({steps['Kidney_right']:.1f} degrees)",
        f"the force steps to it ({steps['Duodenum']:.1f} degrees)",
        f"The largest change after them is {largest:.2f} N",
    ]


def noise(found: Result) -> list[str]:
    raw, smooth = (r for r in found["rows"]
                   if r["mesh"] == "gallbladder_visual" and r["depth_mm"] == 1.0 and not r["repaired"])  # fmt: skip
    return [
        f"noise of {smooth['noise_mm']:.2f} mm, from {raw['step_deg']:.1f} to {smooth['step_deg']:.1f} degrees",
    ]


def repaired(found: Result) -> list[str]:
    def row(mesh: str, repaired: bool) -> Result:
        (one,) = (r for r in found["rows"] if (r["mesh"], r["depth_mm"], r["noise_mm"]) == (mesh, 1.0, 0.0)
                  and r["repaired"] == repaired)  # fmt: skip
        return one

    kidney, spleen = ([row(mesh, r) for r in (False, True)] for mesh in ("Kidney_right", "Spleen"))
    others = [mesh for mesh in dict.fromkeys(r["mesh"] for r in found["rows"] if r["true_step_deg"] is None)
              if mesh not in ("Kidney_right", "Spleen")]  # fmt: skip
    changed = max(abs(row(mesh, True)["step_deg"] - row(mesh, False)["step_deg"]) for mesh in others)
    assert changed < 1.0
    return [
        f"the kidney from {kidney[0]['step_deg']:.1f} to {kidney[1]['step_deg']:.1f} degrees (after the caps from "
        f"{kidney[0]['limited_step_deg']:.1f} to {kidney[1]['limited_step_deg']:.1f}), the spleen from "
        f"{spleen[0]['step_deg']:.1f} to {spleen[1]['step_deg']:.1f}",
    ]


TIES = [Tie("contact-organs.md", "organs", (ridges, slides, causes, noise, repaired))]
