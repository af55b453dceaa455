"""Every command of the table of requirements runs, in its shortest form.

The tier of `make test` takes the commands whose shortest form costs less than about a second; the others run in
`make test-long`. The items of `palpate reproduce` are made by tests/reproduce/test_items.py, so here the command makes
one of them.
"""

import json
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import paper_items
import pytest
import trimesh
import yaml

import palpate.report
from palpate.arm import Arm
from palpate.arm.coupling import coupling
from palpate.cli import main
from palpate.devices.wrist import COLUMNS
from palpate.record import Record

TABLE = Path(__file__).resolve().parents[2] / "docs" / "requirements.yaml"
COMMANDS = {row[2] for row in yaml.safe_load(TABLE.read_text(encoding="utf-8")).values() if len(row) > 2}

_RUN = "--headless --duration {seconds} --out o --json r.json"
_STUDY = "--workers 1 --figures f --out data.nc --json r.json"
QUICK = {
    **{f"run {scene}": _RUN.format(seconds=0.05)
       for scene in ("palpation", "wall", "paper", "guided", "two_hands", "my.yaml")},
    "certify wall": "--json r.json",
    "experiment experiment_haptics.yaml": "--out o --json r.json",
    "check liver.stl": "--json r.json",
    "device list": "--json r.json",
    "device wrist wrist.csv": "--json r.json",
    "calibrate hand grip.csv": "--json r.json",
    "plan planning": "--json r.json",
    "soak contact": "--passes 3 --json r.json",
    "export run.mcap --to csv --out set": "--signals F_H_L --json r.json",
}  # fmt: skip
"""Further words of commands that run in `make test`."""
LONG = {
    **{
        f"run {scene}": _RUN.format(seconds=0.1)
        for scene in ("breathing", "camera", "peg_transfer", "remote", "soft_liver")
    },
    "bench contact": "--quick --json r.json",
    "calibrate dynamics moving.csv --arm mtm --out m.yaml": "--json r.json",
    "export moveit planning": "--out folder",
    "scan liver": "--views 8 --out s.ply --json r.json",
    "study contact": _STUDY,
    **{f"experiment experiment_{name}.yaml": "--out o --json r.json" for name in ("moments", "preference", "radius")},
    "study guidance": f"--operators 5 {_STUDY}",
    "study guidance --conformance": f"--seeds 1 {_STUDY}",
    "study laws": _STUDY,
    "study passivity": f"--runs 2 {_STUDY}",
    "study radius": _STUDY,
    "study registration": f"--layouts 1 --trials 2 --clouds 1 --touched 1 --chains 1 --sessions 1 {_STUDY}",
    "study wall": f"--hands 2 {_STUDY}",
    "study zwidth": f"--rates 1000 --delays 0 {_STUDY}",
    "study zwidth --executor dask": f"--rates 1000 --delays 0 {_STUDY}",
}  # fmt: skip
"""Further words of commands that run in `make test-long` alone."""
ROS = ("ros sim", "ros graph")
"""Commands that need each other: the graph shows the nodes of the simulation."""


def test_every_command_of_the_table_has_a_form_that_runs():
    items = {command for command in COMMANDS if command.startswith("reproduce ")}
    assert COMMANDS - items == QUICK.keys() | LONG.keys() | {*ROS}
    assert not QUICK.keys() & LONG.keys()
    assert {command.removeprefix("reproduce ") for command in items} <= {*paper_items.JUDGED, *paper_items.LONG}


@pytest.fixture
def place(tmp_path, monkeypatch, sweeps_in_process):
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def prepare(command):
    """Write the files that a command names."""
    if "liver.stl" in command:
        trimesh.creation.icosphere(5, 0.04).export("liver.stl")
    if "my.yaml" in command:
        Path("my.yaml").write_text("arms: {leader: {model: delta}}\nobjects: [{sphere: {radius: 0.02}}]\n")
    if command.startswith("experiment "):
        shutil.copy(TABLE.parents[1] / "examples" / command.split()[-1], ".")
    if "grip.csv" in command:
        np.savetxt("grip.csv", grip(), "%.9g", ",", header="t_s,x_m,F_N,u", comments="")
    if "moving.csv" in command:
        np.savetxt("moving.csv", moving(), delimiter=",")
    if "wrist.csv" in command:
        np.savetxt("wrist.csv", wrist(), "%.9g", ",", header=",".join(COLUMNS), comments="")
    if "run.mcap" in command:
        assert main(["run", "wall", "--headless", "--duration", "0.5", "--out", "o", "--json", "-"]) == 0
        next(Path("o").rglob("*.mcap")).rename("run.mcap")


def grip():
    """Time, position, force and drive (n, 4) of a hand of 0.2 kg, 6 N s/m and 250 N/m on an arm of 0.5 kg, 4 N s/m."""
    t, s = np.arange(0.0, 20.0, 2e-3), 2j * np.pi * np.array([0.5, 1.25, 2.5, 5.0, 9.0, 15.0])
    u = 0.3 * np.exp(np.outer(t, s))
    x = u / (0.7 * s**2 + 10.0 * s + 250.0)
    noise = np.random.default_rng(0).normal(0.0, [2e-6, 1e-3], (len(t), 2))
    force = (u - (0.5 * s**2 + 4.0 * s) * x).real.sum(axis=1)
    return np.column_stack([t, x.real.sum(axis=1) + noise[:, 0], force + noise[:, 1], u.real.sum(axis=1)])


def moving():
    """Positions, velocities and torques (n, 21) of an MTM's drives, with the dry friction of its model file."""
    arm, t = Arm.mtm("right"), np.arange(0.0, 15.0, 5e-3)[:, None]
    middle, swing = 0.5 * (arm.q_min + arm.q_max), np.minimum(0.3 * (arm.q_max - arm.q_min), 0.5)
    w = 2.0 * np.pi * np.array([0.21, 0.34, 0.55, 0.47, 0.62, 0.81, 0.7])
    q, v, a = middle + swing * np.sin(w * t), swing * w * np.cos(w * t), -swing * w**2 * np.sin(w * t)
    o = arm.leader_options()
    links = np.array([arm.inverse_dynamics(*row) for row in zip(q, v, a, strict=True)])
    tau = links + o.rotor_inertia * a + o.viscous * v + o.coulomb * np.tanh(v / 0.02)
    tau += 0.01 * tau.std(axis=0) * np.random.default_rng(0).normal(size=tau.shape)
    to_drives = np.linalg.inv(coupling(arm)).T
    return np.hstack([q @ to_drives, v @ to_drives, tau @ coupling(arm)])


def wrist():
    """Time, angle and torque (n, 3) of a roll axis with friction."""
    t, angle, speed, rows = 0.0, 0.0, 0.0, []
    for n in range(8000):
        torque = 0.02 * (-1.0) ** (n // 90)
        rows.append((t, 2e-5 * round(angle / 2e-5), torque))
        free = (speed + 1e-3 * torque / 1.2e-4) / (1.0 + 1e-3 * 4e-4 / 1.2e-4)
        speed = np.sign(free) * max(0.0, abs(free) - 1e-3 * 4e-3 / 1.2e-4)
        t, angle = t + 1e-3, angle + 1e-3 * speed
    return np.array(rows)


def run(command, words):
    prepare(command)
    assert main([*command.split(), *words.split()]) == 0
    if "r.json" in words:
        assert json.loads(Path("r.json").read_text())


@pytest.mark.parametrize("command", QUICK)
def test_the_command_runs(command, place, monkeypatch, capsys):
    if command.startswith("run "):  # the page of a run is written by the command `report`, below

        def opened(file):
            assert len(Record.open(file).ticks)
            return file

        monkeypatch.setattr(palpate.report, "write_report", opened)
        monkeypatch.setattr("palpate.report.pairs.write_pairs_report", lambda folder, each: folder)
    run(command, QUICK[command])


@pytest.mark.long
@pytest.mark.parametrize("command", LONG)
def test_the_longer_command_runs(command, place, capsys):
    run(command, LONG[command])


@pytest.mark.long
@pytest.mark.parametrize("item", paper_items.LONG)
def test_the_item_is_made(item, place, capsys):
    run("reproduce", f"{item} --out o --json r.json --workers 2")
    assert json.loads(Path("r.json").read_text())["items"][item]["verdict"] != "not made"


@pytest.mark.long
def test_the_commands_of_ros_run(place, capsys):
    words = [sys.executable, "-m", "palpate", "ros", "sim", "--arms", "PSM1"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as sim:
        try:
            assert sim.stdout.readline()
            run("ros graph", "--seconds 1 --json r.json")
        finally:
            sim.send_signal(signal.SIGINT)
            sim.communicate(timeout=60)
    assert sim.returncode in (0, 130)
    assert "PSM1" in Path("r.json").read_text()


def test_the_command_makes_an_item(place, capsys):
    run("reproduce", "eq10 --out o --json r.json")
