"""Phrases of the page on the accuracy of contact, and of that on geometry."""

from __future__ import annotations

from palpate.scene.contact.judging import PATHS, RADIUS
from palpate.world.shapes.analytic import SHAPES
from palpate.world.shapes.paths import tool_path
from palpate_lab.verify.bench.contact import CHAI3D, SIZES
from phrases.values import Result, Tie

NAMES = {10_000: "10k", 100_000: "100k", 1_000_000: "1M"}


def size_of(row: Result) -> int:
    return min(SIZES, key=lambda size: abs(size - row["triangles"]))


def short(value: float, digits: int = 3) -> str:
    """A number below 1 without its leading zero."""
    text = f"{value + 0.0:.{digits}f}"
    return text.removeprefix("0") if digits else text


def reference(values: tuple[float, ...]) -> str:
    return "/".join("-" if value != value else f"{value:g}".removeprefix("0") for value in values)


def deep(found: Result) -> dict[tuple[str, int], Result]:
    return {(r["shape"], size_of(r)): r for r in found["rows"] if r["path"] == "deep"}


def against_chai3d(found: Result) -> list[str]:
    rows, phrases = deep(found), []
    for (shape, size), theirs in CHAI3D.items():
        r = rows[shape, size]
        direction = "/".join(short(r[f"direction_{key}_deg"]) for key in ("median", "p95", "max"))
        magnitude = "/".join(short(r[f"magnitude_{key}_mN"]) for key in ("p95", "max"))
        step = f"{short(r['step_deg'], 2)}/{short(r['step_mN'])}"
        phrases.append(
            f"| {shape} {NAMES[size]} | {reference(theirs[2:5])} | {direction} | {reference(theirs[5:7])} | "
            f"{magnitude} | {reference(theirs[7:9])} | {step} |"
        )
    true = {shape: rows[shape, 1_000_000]["true_step_deg"] for shape in ("sphere", "torus")}
    return [*phrases, f"turns by {true['sphere']:.2f} deg (sphere) and {true['torus']:.2f} deg (torus) per ms"]


def latencies(found: Result) -> list[str]:
    rows = deep(found)
    return [
        f"| {shape} {NAMES[size]} | {reference(theirs[:2])} | {short(rows[shape, size]['p50_us'], 1)}/"
        f"{rows[shape, size]['p99_us']:.0f} |"
        for (shape, size), theirs in CHAI3D.items()
    ]


def worst(found: Result) -> list[str]:
    """The worst of all paths over meshes of ten thousand and a million triangles; equal shapes share a row."""
    rows: dict[str, list[str]] = {}
    assert not any(row["lost"] or row["flipped"] for row in found["rows"])
    for shape in SHAPES:
        cells = []
        for size in (10_000, 1_000_000):
            mine = [r for r in found["rows"] if r["shape"] == shape and size_of(r) == size]
            direction = "/".join(short(max(r[f"direction_{key}_deg"] for r in mine)) for key in ("p95", "max"))
            steps = (max(max(r[f"step_{unit}"] - r[f"true_step_{unit}"], 0.0) for r in mine) for unit in ("deg", "mN"))
            cells.append((direction, short(max(r["magnitude_max_mN"] for r in mine)), "/".join(map(short, steps))))
        row = " | ".join(", ".join(column) for column in zip(*cells, strict=True))
        rows.setdefault(row, []).append(shape)
    return [f"| {', '.join(shapes)} | {row} |" for row, shapes in rows.items()]


def bound(found: Result) -> list[str]:
    """The first sentence: rounded up to half a degree and a millinewton."""
    degrees = max(row["direction_max_deg"] for row in found["rows"])
    newtons = max(row["magnitude_max_mN"] for row in found["rows"])
    assert degrees < 0.5
    assert newtons < 1.0
    return ["to within 0.5 degrees and 1 mN on every tested shape"]


def artefacts(found: Result) -> list[str]:
    slides = found["rows"]
    assert not any(row["artefacts"] for row in slides if row["method"] == "proxy")
    steady = tool_path(SHAPES["box"], *PATHS["shallow"], RADIUS).steady
    return [f"out of {round(steady.stop - steady.start, -2):,} samples"]


def depth_error(found: Result) -> list[str]:
    by = {round(1e3 * row["depth_m"], 3): row["normal_error_deg"] for row in found["depth_error"]}
    return [f"{by[1.0]:.0f} degrees after 1 mm of a 15 mm sphere, {by[5.0]:.0f} after 5 mm"]


def noise(found: Result) -> list[str]:
    first, second, third = (row["error_rms_deg"] for row in found["noise"])
    return [f"angle errors of {first:.0f}, {second:.0f} and {third:.0f} degrees (rms, simulated)"]


TIES = [
    Tie("contact-methods.md", "contact_bench", (against_chai3d, worst, bound)),
    Tie("contact-methods.md", "contact_times", (latencies,)),
    Tie("contact-methods.md", "contact", (artefacts,)),
    Tie("geometry.md", "geometry", (depth_error, noise)),
]
