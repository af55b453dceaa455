"""`palpate frames`: the tree of a scene with sources, ages and uncertainties, and disagreeing paths."""

import json

import json_contract
import pytest

SCENE = """\
frames:
  - {child: camera, pose: {xyz: [0, 0, 0.5]}, sigma_mm: 0.3, sigma_deg: 0.1, source: by hand, stamp: 0}
  - {parent: camera, child: anatomy, pose: {xyz: [0, 0, -0.5]}, sigma_mm: 0.4}
  - {child: anatomy, pose: {xyz: [0.01, 0, 0]}, sigma_mm: 0.5, sigma_deg: 0.1, check: true, source: touched points}
objects:
  - {name: ball, sphere: {radius: 0.03}, frame: anatomy}
"""


def test_the_tree_is_printed_and_written(palpate, tmp_path):
    (tmp_path / "s.yaml").write_text(SCENE)
    done = palpate(
        "frames", tmp_path / "s.yaml", "--of", "ball", "--reference", "camera", "--json", tmp_path / "f.json"
    )
    assert done.code == 0, done.err
    rows = [line.split()[0] for line in done.out.splitlines()[:6]]
    assert rows == ["world", "camera", "anatomy", "ball", "leader", "follower"]
    assert "disagreement: anatomy by world > camera > anatomy and directly in world (touched points)" in done.out
    found = json.loads((tmp_path / "f.json").read_text())
    assert set(found) == json_contract.keys("frames")
    assert set(found["frames"][0]) == json_contract.keys_of("frames", "The row of a frame") - {
        "null", "known", "measured", "live",
    }  # fmt: skip
    camera, anatomy = found["frames"][0], next(row for row in found["frames"] if row["frame"] == "anatomy")
    assert camera["age_s"] > 1e9
    # 0.1 deg over half a metre turns into 0.873 mm on two axes.
    assert anatomy["sigma_world_m"] == pytest.approx((0.3**2 + 0.4**2 + 2 / 3 * 0.8727**2) ** 0.5 * 1e-3, rel=1e-3)
    (other,) = found["disagreements"]
    assert set(other) == json_contract.keys_of("frames", "The row of a second path") - {"null"}
    assert other["distance_m"] == pytest.approx(0.01)
    assert other["probability"] < 0.01
    assert found["pose"]["sigma_m"] == pytest.approx(0.4e-3)


def test_an_unknown_frame_is_a_mistake(palpate, tmp_path):
    (tmp_path / "s.yaml").write_text(SCENE)
    done = palpate("frames", tmp_path / "s.yaml", "--of", "bal")
    assert done.code == 2
    assert "did you mean 'ball'?" in done.err
