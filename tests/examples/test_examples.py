"""The examples run, print the documented results, and are at most a page long."""

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("[0-9][0-9]_*.py"))


@pytest.fixture
def run(monkeypatch, capsys, unarranged_figures):
    """A function that runs an example as its command line would, in this process, and returns what it prints."""
    monkeypatch.setenv("MPLBACKEND", "Agg")

    def example(name: str, *options: str | Path) -> str:
        monkeypatch.setattr(sys, "argv", [name, *map(str, options)])
        runpy.run_path(str(ROOT / "examples" / name), run_name="__main__")
        return capsys.readouterr().out

    return example


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.name)
def test_example_is_at_most_a_page_long(path):
    lines = path.read_text().splitlines()
    assert 50 <= len(lines) <= 110
    assert lines[0].startswith('"""')
    assert "You learn" in "\n".join(lines[:15])


def test_virtual_wall(run, tmp_path):
    out = run("01_virtual_wall.py", "--duration", "3", "--figure", tmp_path / "wall.png")
    rows = [[float(x) if x.strip() != "never" else None for x in line.split("|")] for line in out.splitlines()[2:8]]
    peak = {(row[0], row[1]): row[2] for row in rows}
    given = {(row[0], row[1]): row[6] for row in rows}
    for delay in (0.0, 10.0):
        assert peak[delay, 0.0] > peak[delay, 5.0] > peak[delay, 10.0], "damping lowers the overshoot"
        assert given[delay, 0.0] > 0.01 > given[delay, 10.0], "damping absorbs the energy that sampling adds"
    assert all(peak[10.0, b] > peak[0.0, b] for b in (0.0, 5.0, 10.0)), "delay raises the overshoot"
    assert (tmp_path / "wall.png").stat().st_size > 10_000


def test_feel_an_organ(run, tmp_path):
    out = run("02_feel_an_organ.py", "--duration", "3", "--out", tmp_path, "--figure", tmp_path / "organ.png")
    assert "half as stiff" in out
    assert "in contact" in out
    assert list(tmp_path.glob("*/record.mcap"))
    assert (tmp_path / "organ.png").is_file()


def test_own_mesh(run, tmp_path):
    out = run("03_own_mesh.py", "--sections", "64", "--figure", tmp_path / "normals.png")
    rows = {(line.split("|")[0].strip(), line.split("|")[1].strip()): line for line in out.splitlines() if "|" in line}
    median = {
        key: float(line.split("|")[2].split("/")[0])
        for key, line in rows.items()
        if "deg" in line and "no contact" not in line
    }
    assert all(median[h, "proxy"] < 0.5 for h in ("+1 mm", "-1 mm", "-3 mm"))
    assert 1 < median["+1 mm", "paper-alg1"] < 45
    assert median["-1 mm", "paper-alg1"] > 90
    assert "100%" in rows["-3 mm", "paper-alg1"]


def test_example_is_a_program_of_its_own():
    """One of them as a process: the others run in this one."""
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "04_angle_of_a_face.py"],
        env={**os.environ, "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert "Eq 20 is right here" in done.stdout


def test_angle_of_a_face(run):
    out = run("04_angle_of_a_face.py")
    slopes = [[float(x) for x in line.split("|")[1:]] for line in out.splitlines()[3:6]]
    assert slopes[0][2:] == pytest.approx([40.0, 0.0], abs=1e-6)
    assert slopes[1][3] > 20 > 3 > slopes[2][3], "noise dominates between ticks; a baseline of 1 mm removes it"
    assert "Eq 20 is right here" in out
    assert float(out.splitlines()[-1].split()[-3]) < 0.1
    assert "wrong here: sharp concave edge" in run("04_angle_of_a_face.py", "--degrees", "120")


def test_own_mesh_of_a_user(run, tmp_path):
    import trimesh

    trimesh.creation.icosphere(radius=30).export(tmp_path / "ball.stl")
    assert "2 mm into its top: 2.0" in run("03_own_mesh.py", "--mesh", tmp_path / "ball.stl")


def test_guidance(run, tmp_path):
    out = run("05_guidance.py", "--duration", "4", "--out", tmp_path, "--figure", tmp_path / "guidance.png")
    rows = {line.split("|")[0].strip(): [float(x) for x in line.split("|")[1:]] for line in out.splitlines()
            if line.startswith(("none", "both"))}  # fmt: skip
    assert rows["none"][0] < 0.0, "without guidance the path crosses the vessel"
    assert rows["both"][0] > 2.9, "the tool stays out of the margin"
    assert rows["both"][1] < rows["none"][1], "the tool is closer to the line"
    assert rows["none"][2] == 0.0 < rows["both"][2]
    assert "the tool is 1 mm inside its margin of 3 mm" in out
    assert (tmp_path / "guidance.png").is_file()


def test_many_runs(run):
    out = run("06_many_runs.py", "--runs", "6", "--duration", "2.5")
    rows = [[float(x) for x in line.split("|")] for line in out.splitlines()[2:8]]
    assert [row[0] for row in rows] == sorted(row[0] for row in rows)
    assert rows[0][2] > rows[-1][2], "the tool sinks deeper into soft tissue"
    assert all(abs(row[3] / row[0] - 1.0) < 0.2 for row in rows), "force / depth is the stiffness"


def test_own_device(run):
    out = run("07_own_device.py", "--duration", "2")
    lines = [line for line in out.splitlines() if " N" in line]
    peaks = [float(line.split("at most ")[1].split()[0]) for line in lines]
    assert len(peaks) == 2
    assert all(0.05 < peak <= 3.0 for peak in peaks)
    assert "lateness" in out


def test_gamepad(run):
    out = run("08_gamepad.py", "--pretended", "--duration", "2")
    assert "#" in out
    assert float(out.splitlines()[-1].split()[-2]) > 0.2


def test_small_workspace(run):
    out = run("09_small_workspace.py", "--duration", "3")
    rows = {line.split()[0]: line.split() for line in out.splitlines()[1:]}
    reach = {law: float(row[2]) for law, row in rows.items()}
    away = {law: float(row[4]) for law, row in rows.items()}
    assert reach["indexed"] == 10.0, "scale 0.5 times half of 40 mm"
    assert reach["scaled"] == round(20.0 * float(rows["scaled"][1])), "the chosen scale"
    assert reach["rate"] > 5 * reach["indexed"], "the tool continues"
    assert away["drift"] < 0.6 * away["indexed"], "the hand comes back to the centre"


def test_force_helps_a_network_that_uses_it():
    """Weights by hand: move in circles, and stop where it is hard. The force finds the lump, its absence does not."""
    pytest.importorskip("gymnasium", reason="gymnasium (extra learning) is not installed")
    made = runpy.run_path(str(ROOT / "examples" / "10_force_helps.py"))
    motion = made["Motion"](speed=0.05, reach=made["AREA"])
    many = made["PalpateVectorEnv"](
        40, made["SCENE"], made["Search"](), substeps=made["SUB"], duration=1e6, motion=motion
    )
    starts = np.random.default_rng(1).uniform(-0.75 * made["AREA"], 0.75 * made["AREA"], (40, 2))
    weights = np.tile([*made["CIRCLE"][:10], 2.0, -0.7], (40, 1))
    found = {feels: np.mean(made["rollouts"](many, weights, starts, feels) < made["NEAR"]) for feels in (True, False)}
    assert found[True] > found[False] + 0.15


@pytest.mark.long
def test_force_helps_to_learn(run, tmp_path):
    out = run("10_force_helps.py", "--seeds", "2", "--figure", tmp_path / "curves.png")
    ends = [line for line in out.splitlines() if "finds " in line]
    found = {line.split(":")[0].strip(): float(line.split("finds ")[1].split()[0]) for line in ends}
    assert found["with force"] > found["without"] + 30.0
    assert len(re.findall(r"^ +\d+( +\d+ \+- *\d+){2}$", out, re.MULTILINE)) == 20  # both curves, with intervals
    assert (tmp_path / "curves.png").is_file()
