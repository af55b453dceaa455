"""`palpate bench growth`: how time and memory grow with the size of a session, a scene and a study.

Each size is measured in a process of its own, whose peak memory the kernel knows. Times are processor times, except
those of a study with several workers. The exponent p of a figure is that of figure = c size^p, by least squares over
the logarithms: 1 is linear growth, 0 none.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike
from rich.table import Table

from palpate.base.errors import JournalError, PalpateError
from palpate.base.sweep.lines import Lines
from palpate.base.sweep.work import identity

MEMORY = "memory_mb"
"""Key of the peak growth of a process's memory while it works [MB]; every axis has it."""
_STEADY = 5.0  # smallest growth of memory that is taken as one [MB]
_PAIRS = (("right", 0.06, -20.0), ("left", -0.12, 20.0), ("third", 0.02, -20.0), ("fourth", -0.06, 20.0))


class Growth(TypedDict):
    """Growth along one axis."""

    axis: str
    unit: str
    sizes: list[float]
    figures: dict[str, list[float]]
    """One value for each size, by key; the end of a key is its unit."""
    exponents: dict[str, float]


class Figures(TypedDict):
    """Result of the benchmark. The keys are the documented contract of ``--json``."""

    axes: list[Growth]
    cores: int | None
    load: float


@dataclass(frozen=True)
class Axis:
    """What grows."""

    unit: str
    sizes: tuple[int, ...]
    small: tuple[int, ...]
    """Sizes that take a moment together."""
    measure: Callable[[int], dict[str, float]]
    """The figures of one size, measured in this process, by key."""


def _duration(seconds: int) -> dict[str, float]:
    from palpate.report import write_report
    from palpate.scene import shipped
    from palpate.session import Session

    with tempfile.TemporaryDirectory(prefix="palpate-bench-") as folder:
        began = time.process_time()
        summary = Session(shipped.file("palpation"), out=folder).run(float(seconds))
        ran = time.process_time()
        assert summary.record is not None
        size = Path(summary.record).stat().st_size
        write_report(summary.record)
        return {"run_s": ran - began, "report_s": time.process_time() - ran, "record_mb": 1e-6 * size}


def _triangles(count: int) -> dict[str, float]:
    from palpate import _core
    from palpate.scene.contact.judging import judge
    from palpate.world.shapes.analytic import SHAPES
    from palpate.world.shapes.paths import tool_path

    shape = SHAPES["torus"]
    made = shape.mesh(count)
    began = time.process_time()
    mesh = _core.Mesh(*made)
    built = time.process_time() - began
    found = judge(mesh, shape, tool_path(shape, -1e-3, 0.05, 2e-3), "proxy")
    return {"build_s": built, "p50_us": found["p50_us"], "p99_us": found["p99_us"]}


def _tetrahedra(count: int) -> dict[str, float]:
    from palpate_lab.verify.bench.tissue.ticks import tick_times

    n = max(1, round((count / 24.0) ** (1.0 / 3.0)))
    began = time.process_time()
    tets, times = tick_times((2 * n, 2 * n, n), 300)
    return {"tetrahedra": tets, "tick_ms": times["p50"], "whole_s": time.process_time() - began}


def _points(count: int) -> dict[str, float]:
    from palpate.devices.loop import DeviceLoop, device_scene
    from palpate.scene import Scene
    from palpate.sensing.sensing import Sensing
    from palpate_lab.verify.bench.cloud_cases import RATE, SCENE, MovingSurface

    loop = DeviceLoop(device_scene(Scene.parse(SCENE), "loop"))
    source = MovingSurface(lambda t: 0.0 * np.asarray(t), count, side=0.4, frames=1)
    sensing, spent = Sensing(loop.rig, loop, {"camera": source}), []
    for k in range(5):
        loop.step(k / RATE, np.eye(4), None, 0.0, 0)
        began = time.process_time()
        if sensing.step(k / RATE):
            spent.append(time.process_time() - began)
    return {"frame_ms": 1e3 * float(np.median(spent))}


def _objects(count: int) -> dict[str, float]:
    from palpate.scene import Scene, rig

    side = int(np.ceil(count ** (1.0 / 3.0)))
    k = np.arange(count - 1)
    at = 0.06 * (np.stack([k % side, k // side % side, k // side**2], axis=1) - 0.5 * side) - [0.0, 0.0, 0.2]
    beads = [{"name": f"bead{i}", "sphere": {"radius": 0.01}, "pose": {"xyz": p.tolist()}} for i, p in enumerate(at)]
    began = time.process_time()
    simulation = rig.build(
        Scene.model_validate({"objects": [{"shape": "organ", "stiffness": 400}, *beads]})
    ).simulation()
    made = time.process_time() - began
    simulation.run(6000)
    cycle = simulation.timing()["cycle_us"]
    return {"start_s": made, "cycle_p50_us": cycle["p50"], "cycle_p99_us": cycle["p99"]}


def _fixtures(count: int) -> dict[str, float]:
    from palpate import _verify
    from palpate_lab.verify.bench.guidance import RATE, around, polytope

    spent = _verify.time_guidance(polytope(count), around(3000), 1.0 / RATE)
    p50, p99 = np.percentile(spent[200:], [50, 99])
    return {"stage_p50_us": float(p50), "stage_p99_us": float(p99)}


def _pairs(count: int) -> dict[str, float]:
    from palpate.session.pairs import PairsSession

    pairs = {
        name: {
            "arms": {
                "leader": {"base": {"xyz": [0.345 + 0.5 * i, 0.243, 0.219], "rpy_deg": [0, 0, turn]}},
                "follower": {"base": {"xyz": [x, -0.06, 0.155], "rpy_deg": [0, 0, 155 if turn < 0 else 205]}},
            },
            "operator": {"palpate": {"at": [0.5 * x, -0.012, 0.1], "length": 0.005}},
        }
        for i, (name, x, turn) in enumerate(_PAIRS[:count])
    }
    session = PairsSession({"objects": [{"shape": "organ", "stiffness": 300}], "pairs": pairs})
    began = time.process_time()
    session.run(2.0)
    return {"second_s": (time.process_time() - began) / 2.0}


def _participants(count: int) -> dict[str, float]:
    from palpate.base.sweep import Axis as SweepAxis
    from palpate.base.sweep import sweep
    from palpate_lab.verify.bench.sweep import SEED, wall_run

    wall_run({}, SEED)  # what is imported and compiled once is no growth
    found = {}
    for workers, key in ((1, "one_worker_s"), (2, "two_workers_s")):
        began = time.perf_counter()
        sweep(wall_run, {"run": SweepAxis(range(count))}, SEED, workers=workers)
        found[key] = time.perf_counter() - began
    return found


AXES: Mapping[str, Axis] = {
    "duration": Axis("s", (10, 60, 600, 3600), (2, 8), _duration),
    "triangles": Axis("", (10_000, 100_000, 1_000_000, 10_000_000), (10_000, 160_000), _triangles),
    "tetrahedra": Axis("", (1_000, 5_000, 12_000, 50_000), (600, 5_000), _tetrahedra),
    "points": Axis("", (10_000, 100_000, 1_000_000), (10_000, 160_000), _points),
    "objects": Axis("", (1, 8, 64, 512), (1, 512), _objects),
    "fixtures": Axis("", (1, 8, 32, 128), (2, 32), _fixtures),
    "pairs": Axis("", (1, 2, 3, 4), (1, 3), _pairs),
    "participants": Axis("", (100, 1_000, 10_000), (100, 800), _participants),
}
"""Everything that may grow, by name."""


def exponent(sizes: ArrayLike, values: ArrayLike) -> float:
    """The exponent p of values (n,) = c sizes^p by least squares over the logarithms; sizes (n,) above 0, n >= 2."""
    x, y = np.log(np.asarray(sizes, dtype=float)), np.log(np.maximum(np.asarray(values, dtype=float), 1e-9))
    x = x - x.mean()
    return float(x @ y / (x @ x))


def run(
    names: tuple[str, ...] = tuple(AXES),
    small: bool = False,
    resume: Path | None = None,
    on_progress: Callable[[str], None] = lambda _: None,
) -> Figures:
    """Measure; the result has the keys of `palpate bench growth` in docs/json.md.

    Args:
        names: axes to measure.
        small: True takes the small sizes, which say less and take a moment.
        resume: file that keeps the figures of each size as soon as they are measured; sizes in it are not measured
            again.
        on_progress: called before each measurement.

    Raises:
        PalpateError: there is no such axis, a measurement failed, or the file is another one or cannot be written.
    """
    for name in names:
        if name not in AXES:
            raise PalpateError(f"there is no axis {name!r}", mend=f"choose from: {', '.join(AXES)}")
    found = []
    with _measuring(resume) as measured:
        for name in names:
            axis = AXES[name]
            sizes = axis.small if small else axis.sizes
            rows = []
            for size in sizes:
                on_progress(f"{size:,} {axis.unit or name}")
                rows.append(measured(name, size))
            found.append(growth(name, axis.unit, sizes, rows))
    return {"axes": found, "cores": os.cpu_count(), "load": os.getloadavg()[0]}


@contextmanager
def _measuring(resume: Path | None) -> Iterator[Callable[[str, int], dict[str, float]]]:
    """A function that returns the figures of one size, from the file if it has them; its first line is the version."""
    if resume is None:
        yield _in_a_process
        return
    with closing(Lines(resume)) as lines:
        version = {"growth of palpate": identity()}
        if not lines.empty and lines.entries[:1] != [version]:
            what = "this is no journal of palpate bench growth by the same version"
            raise JournalError(what, where=str(resume), mend="name another file")
        lines.take_up()
        if lines.empty:
            lines.append([version])
        kept: dict[tuple[str, int], dict[str, float]] = {
            (name, size): row for name, size, row in filter(None, lines.entries[1:])
        }

        def measured(name: str, size: int) -> dict[str, float]:
            if (name, size) not in kept:
                kept[name, size] = _in_a_process(name, size)
                lines.append([[name, size, kept[name, size]]])
                lines.sync()
            return kept[name, size]

        yield measured


def growth(name: str, unit: str, sizes: tuple[int, ...], rows: list[dict[str, float]]) -> Growth:
    """The growth along one axis from the figures of each size."""
    figures = {key: [row[key] for row in rows] for key in rows[0]}
    real = figures.pop(name, None)  # where a size can only be approached
    at = [float(size) for size in (real or sizes)]
    least = {key: _STEADY if key == MEMORY else 0.0 for key in figures}
    exponents = {key: exponent(at, np.maximum(values, least[key])) for key, values in figures.items()}
    return {"axis": name, "unit": unit, "sizes": at, "figures": figures, "exponents": exponents}


def measure(name: str, size: int) -> dict[str, float]:
    """The figures of one size, in this process, which should be newly started."""
    import palpate.scene  # noqa: F401  # what every axis imports is no growth

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = AXES[name].measure(size)
    return found | {MEMORY: (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / 1e6}


def _in_a_process(name: str, size: int) -> dict[str, float]:
    with tempfile.TemporaryDirectory(prefix="palpate-bench-") as cache:  # empty: everything is built
        command = [sys.executable, "-m", "palpate_lab.verify.bench.growth", name, str(size)]
        environment = os.environ | {"XDG_CACHE_HOME": cache}
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        raise PalpateError(f"the measurement of {size:,} {name} failed", why=done.stderr.strip()[-400:])
    row: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return row


def table(result: Figures) -> Table:
    """The result as one table for a terminal."""
    out = Table(title="growth: figure at each size, and its exponent", box=None, padding=(0, 2, 0, 0))
    out.title_justify = out.caption_justify = "left"
    out.add_column("axis")
    out.add_column("figure")
    out.add_column("from the smallest size to the largest", overflow="fold")
    out.add_column("exponent", justify="right")
    for one in result["axes"]:
        sizes = ", ".join(f"{size:,.0f}" for size in one["sizes"])
        out.add_row(one["axis"], one["unit"], sizes, "", style="bold")
        for key, values in one["figures"].items():
            words, _, unit = key.rpartition("_")
            out.add_row("", f"{words.replace('_', ' ')}, {unit.replace('mb', 'MB')}",
                        ", ".join(f"{value:.3g}" for value in values), f"{one['exponents'][key]:.2f}")  # fmt: skip
    out.caption = f"load of the machine {result['load']:.1f} on {result['cores']} cores"
    return out


def draw(result: Figures, path: Path) -> None:
    """Draw the growth of all axes, times on the left and memory on the right, relative to the smallest size.

    Raises:
        OSError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import INK, JOINTS, Canvas, png

    def picture(canvas: Canvas) -> Figure:
        figure = Figure(figsize=(canvas.width, 4.6), layout="constrained")
        times, memory = figure.subplots(1, 2)
        for k, one in enumerate(result["axes"]):
            x = np.array(one["sizes"]) / one["sizes"][0]
            dash = "-" if k < len(JOINTS) else "--"
            for key, values in one["figures"].items():
                y = np.maximum(values, _STEADY) if key == MEMORY else np.asarray(values)
                axes, label = (memory, one["axis"]) if key == MEMORY else (times, f"{one['axis']}: {key}")
                axes.plot(x, y / y[0], dash, color=JOINTS[k % len(JOINTS)], marker="o", ms=3, lw=1.2, label=label)
        for axes, title in ((times, "time"), (memory, "memory")):
            top = max(one["sizes"][-1] / one["sizes"][0] for one in result["axes"])
            axes.plot([1.0, top], [1.0, top], color=INK, lw=0.8, ls=":", label="linear")
            axes.set(xscale="log", yscale="log", xlabel="size over the smallest", ylabel=f"{title} over the smallest")
            axes.legend(fontsize=5)
        return figure

    png(picture, path)


if __name__ == "__main__":
    figures: dict[str, Any] = measure(sys.argv[1], int(sys.argv[2]))
    print(json.dumps(figures))
