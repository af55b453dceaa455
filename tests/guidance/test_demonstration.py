"""Paths from demonstrations and grids from meshes: synthetic motions with a known path, and the commands."""

import json

import json_contract
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from palpate.base.errors import GuidanceError, PalpateWarning, SurfaceError
from palpate.cli import main
from palpate.scene.guidance import Fixture, FixtureContext
from palpate.scene.guidance.curve import path
from palpate.scene.guidance.demonstration import Shown, deviation, simplified
from palpate.scene.guidance.files import read_rows, write_rows
from palpate.scene.guidance.plot import query
from palpate.world.mesh import Mesh
from palpate.world.surfaces import DistanceGrid
from palpate.world.surfaces import grid as grids
from palpate.world.surfaces.grid import error_of


def arc(t):
    return 0.03 * np.c_[np.cos(t), np.sin(t), 0.3 * t]


def demonstration(noise=0.0, seed=0):
    """A demonstration along a helix, with a pause in the middle and tremor of `noise` [m]."""
    s = np.r_[np.linspace(0, 1.5, 1500), np.full(500, 1.5), np.linspace(1.5, 3.0, 1500)]
    p = arc(s) + noise * np.random.default_rng(seed).normal(size=(len(s), 3))
    return Shown(np.arange(len(s)) * 1e-3, p, Rotation.from_rotvec(s[:, None] * [0, 0, 1.0]).as_matrix())


def test_demonstration_without_noise_is_reproduced():
    places, R = simplified(demonstration(), spacing=2e-3, smooth=1e-3)
    length = 3.0 * 0.03 * np.hypot(1.0, 0.3)
    assert len(places) == round(length / 2e-3) + 1
    found = path(places, R)
    assert found.length == pytest.approx(length, rel=2e-3)
    assert deviation(found, demonstration()).worst < 5e-5
    np.testing.assert_allclose(places[[0, -1]], arc(np.array([0.0, 3.0])), atol=1e-9)
    turned = query(found, arc(np.array([1.0])))["attitude"][0]
    np.testing.assert_allclose(turned, Rotation.from_rotvec([0, 0, 1.0]).as_matrix(), atol=2e-2)


def test_tremor_is_smoothed():
    rough = demonstration(noise=5e-5)
    found = path(*simplified(rough, spacing=2e-3, smooth=2e-3), crossing=0.0)
    assert deviation(found, demonstration()).rms < 1.2e-4
    assert deviation(found, demonstration()).rms < 2.0 * deviation(found, rough).rms


def test_tool_that_hardly_moved_gives_no_path():
    still = Shown(np.arange(9.0), np.zeros((9, 3)), np.tile(np.eye(3), (9, 1, 1)))
    with pytest.raises(GuidanceError, match="the tool moved 0 mm in all"):
        simplified(still)


def test_rows_survive_a_round_trip(tmp_path):
    places, R = simplified(demonstration(), spacing=4e-3)
    write_rows(tmp_path / "p.csv", places, R)
    again, turned = read_rows(tmp_path / "p.csv", "in")
    np.testing.assert_allclose(again, places, atol=1e-10)
    np.testing.assert_allclose(turned, R, atol=1e-8)


def test_path_command_makes_a_path_from_a_run(tmp_path, capsys):
    scene = tmp_path / "s.yaml"
    scene.write_text("objects: [{sphere: {radius: 0.05}, stiffness: 200}]\nrecord: {report: false}\n")
    assert main(["run", str(scene), "--headless", "--duration", "1.5", "--out", str(tmp_path / "runs")]) == 0
    record = next((tmp_path / "runs").glob("*/record.mcap"))
    out, report = tmp_path / "course.csv", tmp_path / "path.json"
    assert main(["path", str(record.parent), "--out", str(out), "--json", str(report)]) == 0
    figures = json.loads(report.read_text())
    assert set(figures) == json_contract.keys("path")
    assert figures["places"] > 3
    assert 0.0 < figures["deviation_rms_m"] <= figures["deviation_max_m"] < 1e-3
    core = Fixture("follow: course.csv").make(FixtureContext(lambda name: tmp_path / name))
    assert core.role == "guide"
    assert "smoothed over 1 mm, a point every 2 mm" in capsys.readouterr().out
    assert main(["path", str(record), "--start", "90", "--out", str(out)]) == 2
    assert "no tick from 90 to inf s" in capsys.readouterr().err


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    file = tmp_path_factory.mktemp("grid") / "ball.stl"
    trimesh.creation.icosphere(4, 20.0).export(file)
    return file


def test_grid_command_makes_a_grid_and_states_its_error(ball, tmp_path, capsys):
    out, report = tmp_path / "ball.npz", tmp_path / "grid.json"
    assert main(["grid", str(ball), "--spacing", "1", "--out", str(out), "--json", str(report)]) == 0
    figures = json.loads(report.read_text())
    assert set(figures) == json_contract.keys("grid")
    assert figures["spacing_m"] == 1e-3
    assert 0.0 < figures["error_near_p99_m"] <= figures["error_near_max_m"] < 2e-4
    assert "error near the surface" in capsys.readouterr().out
    grid = DistanceGrid.load(out)
    found = error_of(grid, Mesh.load(ball), 2000, seed=3)
    assert found.near_p99 == pytest.approx(figures["error_near_p99_m"], rel=0.5)
    exact = np.linalg.norm(np.array([[0.022, 0, 0.003]]), axis=1) - 0.02
    np.testing.assert_allclose(grid.nearest([[0.022, 0, 0.003]])[0], exact, atol=1e-4)


def test_grid_error_decreases_with_the_spacing(tmp_path):
    """The largest errors are at the edges of a box, which a grid rounds."""
    trimesh.creation.box((40, 30, 20)).export(tmp_path / "box.stl")
    mesh = Mesh.load(tmp_path / "box.stl")
    coarse, fine = (error_of(DistanceGrid.from_mesh(mesh, s), mesh, 4000).near_p99 for s in (3e-3, 1e-3))
    assert fine < 0.6 * coarse


def test_too_many_grid_nodes_are_rejected(ball, capsys):
    assert grids.MAX_NODES == 512**3
    assert main(["grid", str(ball), "--spacing", "0.05"]) == 2
    output = capsys.readouterr().err
    assert "nodes are more than 134,217,728" in output
    assert "mend: use a spacing of 0.0" in output


@pytest.mark.parametrize("existing", [False, True])
@pytest.mark.parametrize("where", ["sampling", "writing"])
def test_interrupted_grid_leaves_the_folder_unchanged(ball, tmp_path, monkeypatch, existing, where):
    out = tmp_path / "ball.npz"
    if existing:
        out.write_bytes(b"old content")

    def stop(file, *_, **__):
        if where == "writing":
            file.write(b"half")
        raise KeyboardInterrupt

    if where == "writing":
        monkeypatch.setattr(np, "savez", stop)
    else:
        monkeypatch.setattr(grids._core, "sample_distance", stop)
    before = sorted(tmp_path.iterdir())
    assert main(["grid", str(ball), "--spacing", "1", "--out", str(out)]) == 130
    assert sorted(tmp_path.iterdir()) == before
    assert not existing or out.read_bytes() == b"old content"


def test_open_mesh_is_rejected_as_a_grid(ball, tmp_path):
    half = trimesh.load(ball)
    half.update_faces(np.arange(len(half.faces)) > 5)
    half.export(tmp_path / "open.stl")
    with pytest.warns(PalpateWarning, match="the surface is open"):
        mesh = Mesh.load(tmp_path / "open.stl")
    with pytest.raises(SurfaceError, match=r"(?s)the mesh is open.*a signed distance needs a closed surface"):
        DistanceGrid.from_mesh(mesh, 1e-3)
