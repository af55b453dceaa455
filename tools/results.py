"""Keeps results of documented runs: `python tools/results.py wall` runs the command and writes docs/results/wall.json.

A file holds the command, the commit of the code, the seed, a control of the machine's speed, and the numbers. The test
tests/docs/test_results.py compares the figures on the pages with them.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from string import Template
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
DATA = "$PALPATE_DATA"  # folder of recordings and clouds that are not part of the repository
OUT = "$OUT"  # a folder that is removed after the run


@dataclass(frozen=True)
class Run:
    """A documented run."""

    command: str
    """Arguments of `palpate`."""
    without: tuple[str, ...] = ()
    """Keys of its JSON that no page needs: at any depth, or with a dot in front at the top alone."""
    rows: Callable[[dict[str, Any]], bool] = lambda row: True
    """Rows to keep, of a list of rows at any depth."""


def _gravity(arm: str, number: str, poses: int = 160, model: str = "potential") -> Run:
    files = f"{DATA}/mtm_static/{arm.upper()}_{number}__random"
    command = f"calibrate gravity {files}_N{poses}.csv --arm {arm} --model {model} --out {OUT}/m.yaml"
    command += f" --test {files}_N400.csv"
    return Run(command, ("advice", "base_parameters", "not_identifiable", "weak_parameters", "outliers", "stops"))


def _dynamics(arm: str) -> Run:
    one, two = (f"{DATA}/{arm}_moving/{arm}__{name}_results.csv" for name in ("one", "two"))
    return Run(f"calibrate dynamics {one} --arm {arm} --out {OUT}/m.yaml --test {two}",
               ("terms", "consistency", "unknown"))  # fmt: skip


_BOUNDS = (
    *("change_low", "change_high", "hedges_g_low", "hedges_g_high", "expected_change", "expected_hedges_g", "source"),
    *(f"than_{other}_{end}_mm" for other in ("right", "none") for end in ("low", "high")),
    *(f"{key}_more_{end}" for key in ("path_error_mm", "mean_force_N", "peak_force_N", "time_s")
      for end in ("low", "high")),
)  # fmt: skip
_TIMES = ("p50_us", "p99_us", "load_s", "again_s", "memory_MB", "bytes_per_triangle")

RUNS: dict[str, Run] = {
    "wall": Run("study wall --hands 1000", (), lambda row: row.get("kd") not in (2.5, 7.5, 30.0)),
    "paper": Run(f"reproduce all --out {OUT}/paper"),
    "wall_fit": Run("study wall --hands 2 --fit", ("curve", "sensitivity", "other_rates", "passive_rows", "rows")),
    "certificate": Run("study certificate --devices 500", ("devices",)),
    "swings": Run("study certificate --swings 500"),
    "passivity": Run("study passivity"),
    "network": Run("study network --runs 200 --hours 4"),
    "network_runs": Run(
        "study network --conditions none --modes model --worlds known --runs 10000", ("conditions", "moving", "alarms")
    ),
    "network_unknown": Run(
        "study network --conditions none --modes model --worlds unknown --runs 200", ("conditions", "moving", "alarms")
    ),
    "extract": Run("study passivity --extract"),
    "registration": Run("study registration", ("layouts",)),
    "loops": Run("fuzz loops --runs 500 --faults 1000000 --resume runs/loops.jsonl", ("faults",)),
    "session": Run(
        f"register session scenes/registration.yaml --out {OUT}/liver.yaml",  # on an idle machine
        ("date", "X", "covariance", "targets", "sources", "trusted"),
    ),
    "guidance": Run("study guidance", _BOUNDS, lambda row: row.get("condition") != "control_wrong"),
    "guidance_entry": Run("study guidance --entry"),
    "guidance_assumptions": Run("study guidance --assumptions", _BOUNDS),
    "conformance": Run(
        "study guidance --conformance", ("hard_entry", "soft_entry"), lambda row: row.get("rejected_share", 1.0) > 0.6
    ),
    "conformance_seeds": Run("study guidance --conformance --seeds 10", ("pairs", "hard_entry", "soft_entry")),
    "guidance_times": Run("bench guidance"),  # on an idle machine
    "planning": Run("bench planning"),
    "planning_hooks": Run("bench planning --hooks --queries 20"),
    "collisions": Run("study collisions", ("pairs",)),
    "planning_study": Run("study planning", (".trials",)),
    "planning_stiffness": Run("study planning --stiffness --routes 8 --operators 8", (".trials",)),
    "execution": Run("bench execution --stops 50"),
    "execution_ros": Run("bench execution --ros --stops 20"),
    "contact": Run(
        "study contact", ("planes", *_TIMES), lambda row: row.get("path") == "shallow" and row["triangles"] > 50_000
    ),
    "contact_bench": Run("bench contact", _TIMES, lambda row: row.get("path") != "tool"),
    "record": Run("bench record --hours 1"),  # on an idle machine
    "growth": Run("bench growth"),  # on an idle machine
    "contact_times": Run("bench contact", (), lambda row: row.get("path") == "deep"),  # on an idle machine
    "organs": Run("bench contact --organs"),  # with the organ meshes of the test data
    "laws": Run(
        "study laws",
        ("force_error", "force_rms_N", "motion_mm", "peak_speed_m_s", "neglected_N", "too_fast"),
        lambda row: row["model_scale"] == 1.0 and (row["K_N_per_m"] == 400.0 or row["law"] == "stiffness"),
    ),
    "coverage": Run("coverage"),
    "force": Run(f"study force --data {DATA}"),
    "drift": Run("study drift", ("drift_mm",)),
    "dynamics_mtm": _dynamics("mtm"),
    "dynamics_psm": _dynamics("psm"),
    "gravity_34863": _gravity("mtml", "34863"),
    "gravity_31519": _gravity("mtmr", "31519"),
    "gravity_28247": _gravity("mtmr", "28247"),
    "gravity_34863_few": _gravity("mtml", "34863", 40),
    "gravity_28247_few": _gravity("mtmr", "28247", 40),
    "gravity_34863_dvrk": _gravity("mtml", "34863", model="dvrk"),
    "gravity_31519_dvrk": _gravity("mtmr", "31519", model="dvrk"),
    "gravity_28247_dvrk": _gravity("mtmr", "28247", model="dvrk"),
    "cloud": Run(
        "bench cloud",
        ("frame_to_force_ms", "frame_cpu_ms", "missed", "control_missed", "frames", "ticks", ".force_error_rms"),
    ),
    "cloud_times": Run("bench cloud", ("cases",)),  # on an idle machine
    "scan": Run(f"scan scenes/liver.yaml --views 12 --noise 1 --out {OUT}/organ.ply", ("poses", "holes", "seconds")),
    "scan_times": Run(  # on an idle machine
        f"scan scenes/liver.yaml --views 12 --noise 1 --out {OUT}/organ.ply", ("poses", "holes", "error_m")
    ),
    "scan_room": Run(
        f"scan {DATA}/clouds/capture0001.pcd {DATA}/clouds/capture0002.pcd --unit m --out {OUT}/room.ply",
        ("poses", "holes", "seconds"),
    ),
    "radius": Run("study radius", ("filtered_mN", "bias_mN", "step_deg", "step_mN", "error_mN")),
    "radius_filter": Run(
        "study radius",
        ("kept", "direction_deg", "force_mN", "bias_mN", "step_deg", "step_mN"),
        lambda row: row["feature_mm"] == 16.0 and row["noise_mm"] == 0.2,
    ),
    "spheres": Run("study radius --spheres"),
    "geometry": Run("study geometry", ("point_contact", "deflection", "slopes")),
    "tissue": Run(
        "bench tissue",
        ("tick_ms", "control_ms", "real_time", "viscosity", "theories", "polynomial", "finding"),
        lambda row: not str(row.get("name", "")).startswith("operators who"),
    ),
    "tissue_finding": Run("bench tissue --only finding"),
    "tissue_loops": Run("bench tissue --only realtime"),  # on an idle machine
    "theories": Run("bench tissue --only theories"),
    "soak_tissue": Run("soak tissue --pokes 1000"),
    "soak_haply": Run("soak haply --repeats 10"),
    "ros": Run("bench ros --duration 60 --sim"),  # on an idle machine
    "ros_discovery": Run("bench ros --discovery"),  # on an idle machine
    "ros_faults": Run("bench ros --faults"),
    "viewer": Run("bench viewer"),  # on an idle machine
    "grid": Run(f"grid {DATA}/meshes/Liver.stl --spacing 0.38 --out {OUT}/liver.npz", ("mesh", "grid")),
    "tissue_times": Run("bench tissue --only ticks --only mujoco"),  # on an idle machine
}


def control() -> float:
    """Processor time of an import of numpy in a process of its own: the speed of the machine at this moment [s]."""
    code = "import resource, numpy; r = resource.getrusage(resource.RUSAGE_SELF); print(r.ru_utime + r.ru_stime)"
    return min(float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(3))


def commit() -> str:
    """The commit of the code; with a + when files of the core or of the packages differ from it."""

    def git(*words: str) -> str:
        return subprocess.check_output(["git", *words], cwd=ROOT, text=True).strip()

    folders = ("palpate", "lab", "core", "simulators", "models", "scenes")
    changed = git("status", "--porcelain", "--untracked-files=no", *folders)
    return git("rev-parse", "--short=12", "HEAD") + ("+" if changed else "")


def rounded(value: Any) -> Any:
    """The value with numbers of six significant digits."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return [rounded(one) for one in value] if isinstance(value, list) else value


def needed(value: Any, run: Run) -> Any:
    """The value without the keys and rows that no page needs."""
    if isinstance(value, dict):
        return {key: needed(one, run) for key, one in value.items() if key not in run.without}
    if isinstance(value, list):
        return [needed(one, run) for one in value if not isinstance(one, dict) or run.rows(one)]
    return value


def measured(name: str, folder: Path) -> dict[str, Any]:
    """Run a documented command; its result with what is needed to repeat it."""
    run = RUNS[name]
    head: dict[str, Any] = {
        "command": f"palpate {run.command}",
        "commit": commit(),
        "control_numpy_import_s": control(),
    }
    (ROOT / "runs").mkdir(exist_ok=True)  # journals of runs that continue
    file, start = folder / "result.json", time.monotonic()
    places = {"OUT": str(folder), "PALPATE_DATA": os.environ.get("PALPATE_DATA", str(ROOT.parent / "shared" / "data"))}
    arguments = [Template(word).substitute(places) for word in run.command.split()]
    if arguments[0] == "study":
        from palpate_lab.studies._command import SweepStudy

        study = import_module(f"palpate_lab.studies.{arguments[1]}.command").Command
        arguments += ["--figures", str(folder)]
        arguments += ["--out", str(folder / "data.nc")] if issubclass(study, SweepStudy) else []
    environment = {**os.environ, "PALPATE_DATA": places["PALPATE_DATA"]}
    command = [sys.executable, "-m", "palpate", *arguments, "--json", str(file)]
    code = subprocess.run(command, cwd=ROOT, env=environment).returncode
    if code not in (0, 1) or not file.exists():  # 1: the command found what must not be, and its page says so
        sys.exit(f"{' '.join(command)} ended with {code}")
    found = json.loads(file.read_text(encoding="utf-8"))
    found = {"rows": found} if isinstance(found, list) else found
    found = {key: value for key, value in found.items() if f".{key}" not in run.without}
    head["seed"] = found.get("seed", 0)  # a sweep without a seed of its own has 0
    return rounded(head | {"wall_s": time.monotonic() - start, "cores": os.cpu_count(), "result": needed(found, run)})


def main() -> None:
    """Write docs/results/NAME.json for each name."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="+", choices=list(RUNS))
    for name in parser.parse_args().names:
        with tempfile.TemporaryDirectory() as folder:
            text = json.dumps(measured(name, Path(folder)), indent=1)
        target = ROOT / "docs" / "results" / f"{name}.json"
        target.parent.mkdir(exist_ok=True)
        target.write_text(text + "\n", encoding="utf-8")
        print(f"{target.relative_to(ROOT)}: {len(text) / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
