"""`palpate check`: checks of a scene or a mesh without a run."""

import json
import struct

import json_contract
import numpy as np
import pytest

from palpate.scene.schema import schema_text

CUBE_V = 40.0 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_T = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def write_cube(path, t=CUBE_T):
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *CUBE_V[row].ravel(), 0) for row in t)
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(t)) + facets)
    return path


def test_valid_mesh_has_no_warnings(palpate, tmp_path):
    done = palpate("check", write_cube(tmp_path / "cube.stl"), "--json", tmp_path / "check.json")
    assert done.code == 0
    assert "40.0 x 40.0 x 40.0 mm (file in mm)" in done.out
    assert "can be touched" in done.out
    result = json.loads((tmp_path / "check.json").read_text())
    assert result["ok"]
    assert result["warnings"] == []
    assert result["mesh"]["watertight"]
    assert result["mesh"]["volume_m3"] == pytest.approx(6.4e-5)
    assert set(result) == json_contract.keys("check") - {"objects", "fixtures", "start", "device", "grid"}
    report = json_contract.keys_of("check", "The report of a mesh")
    assert set(result["mesh"]) == report - {"what", "why", "mend"}


def test_each_fault_of_a_mesh_is_reported(palpate, tmp_path):
    done = palpate("check", write_cube(tmp_path / "cube.stl", np.vstack([CUBE_T[1:, ::-1], CUBE_T[3, ::-1]])))
    assert done.code == 0
    assert "warning: " in done.out
    assert "1 duplicate triangles: dropped" in done.out
    assert "the surface is open: 3 edges" in done.out
    assert "2 warnings" in done.out


def test_implausible_unit_is_reported(palpate, tmp_path):
    done = palpate("check", write_cube(tmp_path / "cube.stl"), "--unit", "m")
    assert "the largest extent is 40 m with unit m: is the unit right?" in done.out
    assert "unit: mm would make it 0.04 m" in done.out


def test_valid_scene_is_ready_to_run(palpate, scene, tmp_path):
    done = palpate("check", scene, "--json", tmp_path / "check.json")
    assert done.code == 0, done.err
    assert "ready to run" in done.out
    result = json.loads((tmp_path / "check.json").read_text())
    assert result["objects"][0]["felt_stiffness_N_per_m"] == pytest.approx(200.0)
    assert len(result["start"]["q_leader_rad"]) == 7
    assert set(result) == json_contract.keys("check") - {"mesh", "grid", "fineness", "radius", "repair"}


@pytest.mark.usefixtures("without_figures")
def test_own_stl_in_a_scene_of_five_lines(palpate, tmp_path):
    write_cube(tmp_path / "organ.stl")
    (tmp_path / "own.yaml").write_text(
        "objects:\n  - mesh: organ.stl\n    unit: mm\n    stiffness: 500\n    friction: 0.1\n"
    )
    done = palpate("check", tmp_path / "own.yaml")
    assert done.code == 0, done.err
    done = palpate("run", tmp_path / "own.yaml", "--headless", "--duration", 3, "--json", tmp_path / "run.json")
    assert done.code == 0, done.err
    assert json.loads((tmp_path / "run.json").read_text())["contact_s"] > 0.3


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("    stiffness: 4000", "soft.yaml:4: object 'organ': stiffness 4000 N/m is more than the caps allow"),
        ("    stiffness: 4000", "at 20 mm/s the force would grow by 80 N/s; stability.rate_cap is 50 N/s"),
        ("    stiffness: 4000", "mend: use at most 2500 N/m"),
        ("stability: {rate_cap: 1000}\n_: [{stiffness: 4000}]", "unknown key '_'"),
        ("arms: {follower: {base: {xyz: [0, 0, 0.6]}}}", "follower psm_lnd cannot reach its start pose"),
        ("arms: {follower: {start: {xyz: [1, 0, 0]}}}", "soft.yaml:9: follower psm_lnd cannot reach its start"),
        ("arms: {leader: {start: [3, 0, 0, 0, 0, 0, 0]}}", "rad is outside its limits, -1.134 to 0.698 rad"),
        ("mapping: {scale: 0.02}", "leader mtm_right cannot reach the operator's path"),
    ],
)  # fmt: skip
def test_infeasible_scene_is_rejected(palpate, scene, line, message):
    text = scene.read_text()
    scene.write_text(text.replace("    stiffness: 400", line) if line.startswith("    ") else text + line + "\n")
    done = palpate("check", scene)
    assert done.code == 2
    assert message in done.err


def test_error_for_too_much_stiffness_names_the_force_cap(palpate, scene):
    scene.write_text(scene.read_text().replace("stiffness: 400", "stiffness: 4000") + "stability: {rate_cap: 1000}\n")
    done = palpate("check", scene)
    assert "3 N (stability.force_cap) is reached after 0.75 mm of depth" in done.err
    assert "at most 3000 N/m" in done.err


def test_palpation_force_above_the_cap_is_rejected(palpate, scene):
    scene.write_text(scene.read_text().replace("approach: 0.4", "force: 5.0"))
    done = palpate("check", scene)
    assert "operator.palpate.force: 5 N on the hand is not below stability.force_cap, 3 N" in done.err


def test_unstable_delay_gives_a_warning(palpate, scene):
    scene.write_text(scene.read_text().replace("stiffness: 400", "stiffness: 1600") + "loop_delay: 0.05\n")
    done = palpate("check", scene)
    assert done.code == 0
    assert "organ: unstable: 50 ms of delay at 1000 Hz, 10.6 ms of the follower's servo and" in done.out
    assert "17 ms less delay would give" in done.out


def test_schema_is_written(palpate, tmp_path):
    assert palpate("schema").out == schema_text()
    assert palpate("schema", "--out", tmp_path / "s.json").code == 0
    assert (tmp_path / "s.json").read_text() == schema_text()


def test_repaired_copy_is_written(palpate, tmp_path):
    source = write_cube(tmp_path / "cube.stl", CUBE_T[1:])
    before = source.read_bytes()
    out = tmp_path / "mended.stl"
    done = palpate("check", source, "--repair", out, "--hole", 60, "--json", tmp_path / "check.json")
    assert done.code == 0, done.err
    assert "filled holes: 1" in done.out
    result = json.loads((tmp_path / "check.json").read_text())["repair"]
    assert result["filled"] == 1
    assert result["after"]["watertight"]
    assert source.read_bytes() == before
    assert palpate("check", out).code == 0
    assert set(result) == json_contract.keys_of("check", "`repair`")


def test_repaired_copy_overwrites_a_file_only_on_request(palpate, tmp_path):
    source = write_cube(tmp_path / "cube.stl", CUBE_T[1:])
    before = source.read_bytes()
    done = palpate("check", source, "--repair", source)
    assert done.code == 2
    assert "this is the mesh itself" in done.err
    assert "--force" in done.err
    assert source.read_bytes() == before
    (tmp_path / "other.stl").write_text("mine")
    assert "the file exists" in palpate("check", source, "--repair", tmp_path / "other.stl").err
    assert palpate("check", source, "--repair", tmp_path / "other.stl", "--force").code == 0
    assert "cannot be written" in palpate("check", source, "--repair", tmp_path / "no" / "x.stl").err
    assert "cannot be written" in palpate("check", source, "--repair", tmp_path / "x.step").err


def test_unsuitable_radius_is_reported(palpate, tmp_path):
    cube = write_cube(tmp_path / "cube.stl")
    assert "radius 5 mm is too large to feel 4 mm" in palpate("check", cube, "--radius", 5, "--feature", 4).out
    assert "no radius suits" in palpate("check", cube, "--feature", 4, "--noise", 7).out
    assert "radius 2 mm is small for noise of 7 mm" in palpate("check", cube, "--noise", 7).out
    assert "--feature -4: must be above 0 mm" in palpate("check", cube, "--feature", -4).err


def test_coarse_mesh_in_a_scene_is_reported(palpate, scene):
    scene.write_text(scene.read_text().replace("triangles: 3000", "triangles: 2000"))
    done = palpate("check", scene)
    assert done.code == 0, done.err
    assert "coarse mesh" in done.out
    assert "triangles of the same object would do" in done.out
