"""`palpate register`: files in, pose and JSON out, and mistakes in files explained."""

import json

import numpy as np
import pytest
import yaml
from json_contract import keys

from palpate.base.arrays import rigid, so3

M = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.08, 0], [0, 0, 0.06], [0.07, 0.05, 0.02], [0.02, 0.09, 0.05]])
X = rigid.rigid(so3.about([0.0, 0.6, 0.8], 1.0), [0.1, -0.05, 0.2])
NAMES = "abcdef"


def rows(points, header="name,x,y,z"):
    return "\n".join([header, *(f"{n},{p[0]},{p[1]},{p[2]}" for n, p in zip(NAMES, points, strict=False))])


def poses(X, t=None):
    q = so3.quaternions(X[:, :3, :3])
    stamps = np.arange(len(X)) if t is None else t
    return "\n".join(
        [
            "t,x,y,z,qw,qx,qy,qz",
            *(",".join(map(repr, map(float, [k, *x[:3, 3], *one]))) for k, x, one in zip(stamps, X, q, strict=True)),
        ]
    )


@pytest.fixture
def pair(tmp_path):
    noise = np.random.default_rng(0).normal(scale=1e-4, size=M.shape)
    (tmp_path / "m.csv").write_text(rows(M))
    (tmp_path / "f.csv").write_text(rows(rigid.transform(X, M) + noise))
    return "m.csv", "f.csv"


def test_points_prints_writes_and_has_the_documented_keys(palpate, pair, tmp_path):
    done = palpate("register", "points", *pair, "--target", "tumour=-0.02,0.05,0.1", "--json", "-", "--out", "x.yaml")
    assert done.code == 0
    values = json.loads(done.out)
    assert set(values) == keys("register points")
    assert values["X"] == pytest.approx(X, abs=1e-3)
    assert values["targets"][0]["name"] == "tumour"
    assert "TRE at tumour" in done.err
    written = yaml.safe_load((tmp_path / "x.yaml").read_text())
    assert written["X"] == values["X"]
    assert written["sources"] == ["m.csv", "f.csv"]
    again = palpate("register", "points", *pair, "--out", "x.yaml")
    assert again.code == 2
    assert "exists already" in again.err


def test_limit_that_is_not_kept_names_a_place(palpate, pair):
    done = palpate("register", "points", *pair, "--target", "0.1,0.1,0.1", "--limit", "1e-6")
    assert done.code == 1
    assert "not enough for 0.001 mm: add a point at (" in done.out


def test_rows_correspond_by_name_and_unknown_order_is_found(palpate, pair, tmp_path):
    text = (tmp_path / "f.csv").read_text().splitlines()
    (tmp_path / "f.csv").write_text("\n".join([text[0], *text[:0:-1]]))
    named = json.loads(palpate("register", "points", *pair, "--json", "-").out)
    found = json.loads(palpate("register", "points", *pair, "--unknown", "--json", "-").out)
    assert named["X"] == pytest.approx(X, abs=1e-3)
    assert found["correspondence"] == [5, 4, 3, 2, 1, 0]


def test_a_marker_with_a_wrong_place_is_named(palpate, pair, tmp_path):
    (tmp_path / "m.csv").write_text(rows(M + (np.arange(6) == 3)[:, None] * [0.0, 0.0, 5e-3]))
    values = json.loads(palpate("register", "points", *pair, "--fle", "2e-4", "--json", "-").out)
    assert values["outlier_names"] == ["d"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (rows(M * [1, 1, -1]), "mirror image"),
        (rows(1e3 * M), "ratio near 1000"),
        (rows(M).replace("b,", "a,", 1), "'a' appears 2 times"),
        (rows(M).replace("0.08", "eight"), "is no number"),
        (rows(M[:2]), "at least 3"),
        (rows(M, "name,x,y,w"), "columns z are missing"),
        (rows(np.where(np.arange(6)[:, None] == 3, M[2], M)), "at the same place"),
        ("", "empty"),
    ],
)
def test_mistakes_in_a_file_of_points_are_explained(palpate, pair, tmp_path, text, message):
    (tmp_path / "m.csv").write_text(text)
    done = palpate("register", "points", *pair, "--out", "x.yaml", "--json", "x.json")
    assert done.code == 2
    assert message in done.err
    assert not (tmp_path / "x.yaml").exists()
    assert not (tmp_path / "x.json").exists()


def test_header_may_name_millimetres(palpate, pair, tmp_path):
    (tmp_path / "m.csv").write_text(rows(1e3 * M, "name,x_mm,y_mm,z_mm"))
    assert json.loads(palpate("register", "points", *pair, "--json", "-").out)["X"] == pytest.approx(X, abs=1e-3)


@pytest.fixture
def arm(tmp_path):
    rng = np.random.default_rng(1)
    X_BT = rigid.rigid(rigid.exp(rng.uniform(-0.8, 0.8, (12, 3))), rng.uniform(-0.1, 0.1, (12, 3)))
    (tmp_path / "arm.csv").write_text(poses(X_BT))
    return X_BT


def test_handeye_camera_and_pivot(palpate, arm, tmp_path):
    Z = rigid.rigid(np.eye(3), [0.0, 0.3, 0.1])
    (tmp_path / "board.csv").write_text(poses(np.linalg.inv(X) @ np.linalg.inv(arm) @ Z))
    hand_eye = json.loads(palpate("register", "handeye", "arm.csv", "board.csv", "--json", "-").out)
    assert hand_eye["X"] == pytest.approx(X, abs=1e-6)
    assert set(hand_eye) == keys("register handeye")

    seen = rigid.transform(np.linalg.inv(X), (arm @ [0.0, 0.01, 0.02, 1.0])[:, :3])
    seen += np.random.default_rng(2).normal(scale=1e-5, size=seen.shape)
    (tmp_path / "seen.csv").write_text("x,y,z\n" + "\n".join(f"{a},{b},{c}" for a, b, c in seen))
    camera = json.loads(palpate("register", "camera", "arm.csv", "seen.csv", "--json", "-").out)
    assert camera["X"] == pytest.approx(X, abs=1e-3)
    assert set(camera) == keys("register camera")

    arm[:, :3, 3] = [0.1, 0.2, 0.3] - arm[:, :3, :3] @ [0.0, 0.01, 0.15]
    (tmp_path / "turns.csv").write_text(poses(arm))
    pivot = json.loads(palpate("register", "pivot", "turns.csv", "--json", "-").out)
    assert pivot["p_TQ"] == pytest.approx([0.0, 0.01, 0.15], abs=1e-9)
    assert set(pivot) == keys("register pivot")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (lambda X: poses(X, np.arange(12)[::-1]), "not later than"),
        (lambda X: poses(X).replace("qw,qx", "x,qx"), "appears twice"),
        (lambda X: poses(X).replace("t,x,y,z,qw,qx,qy,qz", "t,qw,qx,qy,qz,x,y,z"), "has the norm"),
        (lambda X: "1,2,3\n4,5,6", "16 numbers"),
        (lambda X: "\n".join(",".join(map(str, (x * [1, 1, -1, 1]).ravel())) for x in X), "left-handed"),
        (lambda X: "\n".join(",".join(map(str, (x * [2, 2, 2, 1]).ravel())) for x in X), "not rigid"),
    ],
)
def test_mistakes_in_a_file_of_poses_are_explained(palpate, arm, tmp_path, text, message):
    (tmp_path / "arm.csv").write_text(text(arm))
    done = palpate("register", "pivot", "arm.csv")
    assert done.code == 2
    assert message in done.err


def test_a_surface_that_is_not_trusted_is_written_by_a_reason_alone(palpate, tmp_path):
    """A patch of a plane slides on the plane; whoever takes its pose all the same signs for it."""
    rng = np.random.default_rng(2)
    plane = np.column_stack([rng.uniform(-0.1, 0.1, (6000, 2)), np.zeros(6000)])
    np.save(tmp_path / "plane.npy", plane + rng.normal(scale=3e-4, size=plane.shape))
    patch = np.column_stack([rng.uniform(-0.04, 0.04, (900, 2)), np.zeros(900)])
    np.save(tmp_path / "patch.npy", patch + rng.normal(scale=3e-4, size=patch.shape))
    command = ("register", "surface", "patch.npy", "plane.npy", "--start-identity", "--out", "X.yaml")
    refused = palpate(*command)
    assert refused.code == 1
    assert "not trusted" in refused.out
    assert not (tmp_path / "X.yaml").exists()
    taken = palpate(*command, "--accept", "a test of the plane, A. M.")
    assert taken.code == 0, taken.err
    assert "in spite of this: a test of the plane, A. M." in " ".join(taken.out.split())
    kept = yaml.safe_load((tmp_path / "X.yaml").read_text())
    assert (kept["trusted"], kept["accepted"]) == (False, "a test of the plane, A. M.")
    assert kept["doubts"]
