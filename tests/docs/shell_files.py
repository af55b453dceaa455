"""Files that a reader of a page has before its commands run: recordings, meshes, scenes, records."""

import shutil
import sys
from pathlib import Path

import numpy as np
import trimesh

import palpate
from palpate import Scene
from palpate.base.arrays import rigid, so3
from palpate.cli import main
from palpate.devices.certificate.device import DeviceModel
from palpate.world.tissue import indentation, viscosity

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "identify"))
BALL = "objects: [{name: ball, sphere: {radius: 0.03}}]\nrecord: {report: false, every: 10}\n"
X = rigid.rigid(so3.about([0.0, 0.6, 0.8], 1.0), [0.1, -0.05, 0.2])


def record(name, seconds=0.3):
    """A record of a tool that touches a ball."""
    summary = palpate.Session(Scene.parse(BALL), out="made").run(seconds)
    Path(name).parent.mkdir(exist_ok=True, parents=True)
    shutil.copy(summary.record, name)


def sphere(name):
    trimesh.creation.icosphere(4, 0.03).export(name)


def gravity():
    """Holding torques of an MTM, and the dVRK's own calibration of one."""
    import synthetic_arm

    synthetic_arm.write("poses.csv", synthetic_arm.recording(60, 1))
    synthetic_arm.write("others.csv", synthetic_arm.recording(40, 2))
    fit = "calibrate gravity poses.csv --arm mtmr --model dvrk --out other.yaml"
    for command in (fit, "calibrate export other.yaml --out gc-MTMR-28247.json"):
        assert main(command.split()) == 0


def dynamics():
    from test_requirement_commands import moving

    for name in ("one.csv", "two.csv"):
        np.savetxt(name, moving(), delimiter=",")


def device(name):
    DeviceModel(mass=0.3, damping=1.0, rate=1000.0, quantum=1e-5, friction=0.05).save(name)


def certificate():
    Path("my.yaml").write_text(BALL)
    device("device.yaml")


def driver():
    device("omega.yaml")
    shutil.copy(ROOT / "tests" / "devices" / "c_driver.c", "my_device.c")


def demonstrations():
    record("record.mcap")
    record("runs/one/record.mcap")


def learning():
    Path("my_policy.py").write_text("def act(seen):\n    return [0, 0, -0.01, 0, 0, 0]\n")


def records():
    """A record of a minute and a half, and its end as one of its own."""
    record("record.mcap", 91.0)
    assert main(["record", "cut", "record.mcap", "--start", "90", "--end", "91", "--out", "later.mcap"]) == 0


def points(name, places):
    Path(name).write_text("".join(["x,y,z\n", *(f"{x},{y},{z}\n" for x, y, z in places)]))


def poses(name, X):
    rows = np.column_stack([np.arange(len(X)), X[:, :3, 3], so3.quaternions(X[:, :3, :3])])
    np.savetxt(name, rows, "%.12g", ",", header="t,x,y,z,qw,qx,qy,qz", comments="")


def registration():
    """Markers in two frames, a camera that sees an organ, a board and the tool's tip, a pointer that turns."""
    random = np.random.default_rng(0)
    markers = random.uniform(-0.1, 0.1, (8, 3))
    seen = rigid.transform(X, markers) + random.normal(scale=1e-4, size=markers.shape)
    for moving, fixed, order in (("scan", "tracker", np.arange(8)), ("psm1", "psm2", random.permutation(8))):
        points(f"{moving}.csv", markers)
        points(f"{fixed}.csv", seen[order])
    organ = palpate.Mesh(*palpate.shapes.organ())
    trimesh.Trimesh(1e3 * organ.vertices, organ.triangles).export("liver.stl")
    view = organ.vertices[organ.vertices[:, 2] > np.median(organ.vertices[:, 2])]
    palpate.PointCloud(rigid.transform(np.linalg.inv(X), view[::3])).save(Path("camera.pcd"))
    arm = np.array([rigid.rigid(so3.about(so3.unit(turn), np.linalg.norm(turn)), place) for turn, place in zip(
        random.normal(scale=0.5, size=(12, 3)), random.uniform(-0.1, 0.1, (12, 3)), strict=True)])  # fmt: skip
    poses("arm.csv", arm)
    poses("psm.csv", arm)
    poses("board.csv", np.linalg.inv(X) @ np.linalg.inv(arm) @ rigid.rigid(np.eye(3), [0.3, 0.0, 0.1]))
    tips = arm[:, :3, 3] + arm[:, :3, :3] @ [0.0, 0.0, 0.01]
    points("tip_in_cloud.csv", rigid.transform(np.linalg.inv(X), tips))
    arm[:, :3, 3] = [0.1, 0.0, 0.0] - arm[:, :3, :3] @ [0.0, 0.0, 0.15]
    poses("poses.csv", arm)


def press():
    """A sphere of 6 mm pressed twice into tissue of 6 kPa that relaxes."""
    t = np.arange(0.0, 6.0, 0.01)
    depth = 3e-3 * np.interp(t, [0.2, 0.3, 3.0, 3.1], [0.0, 0.5, 0.5, 1.0])
    force = viscosity.hereditary_force([(0.4, 0.3)], t, indentation.sneddon(6e-3, depth, 6e3, 0.45))
    header = "time_s,depth_m,force_N"
    np.savetxt("press.csv", np.stack([t, depth, force], axis=1), "%.9g", ",", header=header, comments="")


#: What makes the files of a page.
MEANT = {
    "README.md": lambda: record("runs/one/record.mcap"),
    "docs/calibrate.md": gravity,
    "docs/certificate.md": certificate,
    "docs/contact-organs.md": lambda: sphere("liver.stl"),
    "docs/demonstrations.md": demonstrations,
    "docs/device.md": driver,
    "docs/dynamics.md": dynamics,
    "docs/learning.md": learning,
    "docs/meshes.md": lambda: sphere("organ.stl"),
    "docs/record.md": records,
    "docs/registration.md": registration,
    "docs/tissue.md": press,
}
