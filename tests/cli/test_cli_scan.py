"""`palpate scan`: its JSON, its mesh, and what it refuses."""

import json
from pathlib import Path

import json_contract
import numpy as np
import pytest

import palpate.world.scan
from palpate.cli import main
from palpate.world.clouds import PointCloud
from palpate.world.mesh import Mesh

SCENE = "objects: [{name: ball, sphere: {radius: 0.04}}]\n"


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "ball.yaml").write_text(SCENE)
    return tmp_path / "ball.yaml"


def test_a_simulated_scan_of_a_ball(scene, capsys):
    out = scene.parent / "organ.ply"
    assert (
        main(["scan", str(scene), "--views", "6", "--noise", "0.5", "--cell", "2.5", "--out", str(out), "--json", "-"])
        == 0
    )
    values = json.loads(capsys.readouterr().out)
    assert set(values) == json_contract.keys("scan")
    made = Mesh.load(out, "m")
    assert made.report.watertight == values["closed"]
    assert len(made.triangles) == values["triangles"]
    radius = np.linalg.norm(made.vertices - made.vertices.mean(axis=0), axis=1)
    assert np.abs(radius - 0.04).max() < 1.5e-3
    assert values["error_m"]["rms"] < 0.5e-3
    before = out.read_bytes()
    assert main(["scan", str(scene), "--out", str(out)]) == 2
    assert out.read_bytes() == before
    assert "exists already" in capsys.readouterr().err


def test_clouds_with_frames(tmp_path, capsys):
    rng = np.random.default_rng(0)
    top = np.c_[rng.uniform(-0.05, 0.05, (3000, 2)), 0.01 * np.ones(3000)]
    for name in ("a", "b"):
        PointCloud(top - [0, 0, 0.5], name=name).save(tmp_path / f"{name}.pcd")
    frames = tmp_path / "poses.yaml"
    frames.write_text("frames:\n  - {child: a, pose: {xyz: [0, 0, 0.5]}}\n")
    arguments = ["scan", str(tmp_path / "a.pcd"), str(tmp_path / "b.pcd"), "--frames", str(frames)]
    assert main(arguments) == 2
    assert "there is no frame 'b'" in capsys.readouterr().err
    frames.write_text("frames:\n" + "".join(f"  - {{child: {c}, pose: {{xyz: [0, 0, 0.5]}}}}\n" for c in "ab"))
    out = tmp_path / "flat.ply"
    assert main([*arguments, "--out", str(out), "--json", str(tmp_path / "v.json")]) == 0
    values = json.loads((tmp_path / "v.json").read_text())
    assert not values["closed"]
    with pytest.warns(match="the surface is open"):
        assert Mesh.load(out, "m").vertices[:, 2] == pytest.approx(0.01, abs=1e-4)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nothing.pcd"], "not found"),
        (["a.xyz"], "unit of the cloud is not known"),
        (["a.xyz", "--unit", "m"], "too few"),
        (["a.xyz", "--unit", "m", "--out", "organ.foo"], "unknown format"),
        (["a.xyz", "--cell", "-1"], "--cell -1: must be above 0 mm"),
        (["ball.yaml", "--views", "0"], "--views 0: must be a whole number from 1"),
        (["ball.yaml", "a.xyz"], "a scene stands beside clouds"),
    ],
)
def test_mistakes(scene, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(scene.parent)
    (scene.parent / "a.xyz").write_text("0 0 0\n0 1 0\n1 0 0\n")
    assert main(["scan", *arguments]) == 2
    assert words in capsys.readouterr().err
    assert not (scene.parent / "organ.foo").exists()


def test_views_that_are_far_apart_without_poses_make_no_organ(tmp_path, capsys, monkeypatch):
    """Views from all around, 30 degrees and more apart, find a wrong alignment: exit 1, and no file."""
    from palpate import Scene
    from palpate.scene.surface import placed
    from palpate.sensing.around import around
    from palpate.sensing.depth_camera import Body

    organ = placed(Scene.parse("objects: [{name: organ, shape: organ}]\n"))[0].body
    views = around(Body(organ.name, organ.vertices, organ.triangles), 6, 3e-4, 2)
    paths = [str(tmp_path / f"{k:02d}.ply") for k in range(6)]
    for path, cloud in zip(paths, views.clouds, strict=True):
        PointCloud(cloud.points[::12]).save(Path(path))  # few points: it takes seconds
    out, more = tmp_path / "organ.ply", ["--json", "-"]
    made = []  # both commands scan the same views, which takes seconds
    scan = palpate.world.scan.scan
    monkeypatch.setattr(
        "palpate.world.scan.scan", lambda *a, **k: made[0] if made else made.append(scan(*a, **k)) or made[0]
    )
    assert main(["scan", *paths, "--out", str(out), *more]) == 1
    assert not out.exists()
    told = capsys.readouterr()
    assert json.loads(told.out)["trusted"] is False
    assert "at least one view is not aligned" in " ".join(told.err.split())
    assert main(["scan", *paths, "--out", str(out), "--doubtful", *more]) == 0
    assert out.exists()
