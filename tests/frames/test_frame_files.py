"""Poses in all forms of a file give the same matrix; every wrong file is refused with its cause."""

import math

import numpy as np
import pytest
import yaml

from palpate.base.errors import FrameError
from palpate.world.frames import FrameSection, files

# Turn by +90 deg about z, then 0.1, 0.2, 0.3 m: written by hand in every form.
X = np.array([[0.0, -1.0, 0.0, 0.1], [1.0, 0.0, 0.0, 0.2], [0.0, 0.0, 1.0, 0.3], [0.0, 0.0, 0.0, 1.0]])
MM = X.copy()
MM[:3, 3] *= 1e3
S = math.sqrt(0.5)
FORMS = {
    "angles": {"xyz": [0.1, 0.2, 0.3], "rpy_deg": [0, 0, 90]},
    "scalar first": {"xyz": [0.1, 0.2, 0.3], "quat_wxyz": [S, 0, 0, S]},
    "scalar last": {"xyz": [0.1, 0.2, 0.3], "quat_xyzw": [0, 0, S, S]},
    "matrix": {"matrix": X.tolist()},
    "matrix in mm": {"matrix": MM.tolist(), "unit": "mm"},
    "position in mm": {"xyz": [100, 200, 300], "rpy_deg": [0, 0, 90], "unit": "mm"},
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_gives_the_same_pose(form):
    section = FrameSection.model_validate({"child": "camera", "pose": FORMS[form]})
    assert pytest.approx(X, abs=1e-12) == files.edge(section).X


def with_block(change) -> list[list[float]]:
    Y = X.copy()
    change(Y)
    return Y.tolist()


def mirrored(Y):
    Y[:3, 0] *= -1


def scaled(Y):
    Y[:3, :3] *= 1e3


def sheared(Y):
    Y[0, 0] += 0.01


def transposed(Y):
    Y[:] = Y.T.copy()


def in_mm(Y):
    Y[:3, 3] *= 1e3


def not_finite(Y):
    Y[0, 3] = math.nan


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (mirrored, "left-handed"),
        (scaled, "scaled by 1000"),
        (sheared, "not rigid"),
        (transposed, "translation into the last column"),
        (in_mm, "give unit: mm"),
    ],
)
def test_a_matrix_that_is_no_pose_is_refused_with_its_cause(change, message):
    section = FrameSection.model_validate({"child": "camera", "pose": {"matrix": with_block(change)}})
    with pytest.raises(FrameError, match=message):
        files.edge(section)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"pose": {"quat_wxyz": [0, 0, 0, 0.7]}}, "norm 0.7"),
        ({"pose": {"quat": [1, 0, 0, 0]}}, "unknown key .pose.quat."),
        ({"pose": {"quat_wxyz": [1, 0, 0, 0], "rpy_deg": [0, 0, 0]}}, "keep one of them"),
        ({"pose": {"matrix": X.tolist(), "xyz": [0, 0, 0.1]}}, "remove xyz"),
        ({"pose": {"matrix": with_block(not_finite)}}, "finite"),
        ({}, "neither pose nor file"),
        ({"pose": {}, "file": "x.yaml"}, "pose and file are given"),
        ({"pose": {}, "sigma_mm": 1, "covariance": np.eye(6).tolist()}, "covariance and sigma"),
        ({"pose": {}, "covariance": np.diag([1, 1, 1, 1, 1, -1.0]).tolist()}, "no negative eigenvalue"),
        ({"pose": {}, "covariance": (np.eye(6) + np.eye(6, k=1)).tolist()}, "not symmetric"),
        ({"pose": {}, "stamp": "yesterday"}, "is not a date"),
    ],
)
def test_contradictions_and_impossible_values_are_refused(entry, message):
    with pytest.raises(ValueError, match=message):
        files.edge(FrameSection.model_validate({"child": "camera", **entry}))


def test_rounded_matrices_become_rotations():
    """A file with four decimals: the nearest rotation differs by at most the rounding."""
    R = np.round(np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0], 4)
    R *= np.linalg.det(R) / abs(np.linalg.det(R))
    M = np.eye(4)
    M[:3, :3] = R
    found = files.edge(FrameSection.model_validate({"child": "a", "pose": {"matrix": M.tolist()}})).X[:3, :3]
    assert found.T @ found == pytest.approx(np.eye(3), abs=1e-15)
    assert np.abs(found - R).max() < 1e-4


def write(path, content):
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    return path


def test_a_registration_result_gives_pose_covariance_source_and_date(tmp_path):
    C = np.diag([1e-8, 1e-8, 4e-8, 1e-6, 1e-6, 1e-6])
    result = {"method": "points", "sources": ["a/seen.csv", "model.csv"], "X": X.tolist(), "covariance": C.tolist()}
    write(
        tmp_path / "r.yaml",
        {**result, "date": "2026-11-22T10:00:00+00:00", "fre": 3e-4, "tre": [2e-4, 5e-4], "fle": 1e-4},
    )
    second = "{parent: camera, child: a, pose: {}, sigma_mm: 1e-1, sigma_deg: 1}"
    write(tmp_path / "all.yaml", f"frames:\n- {{child: camera, file: r.yaml}}\n- {second}\n")
    graph = files.load(tmp_path / "all.yaml")
    edge = graph.edge("camera")
    assert pytest.approx(X) == edge.X
    assert edge.covariance == pytest.approx(C)
    assert (edge.source, edge.kind, edge.fre_m, edge.tre_m) == ("points of seen.csv, model.csv", "measured", 3e-4, 5e-4)
    assert edge.age(1795341600.0 + 60.0) == pytest.approx(60.0)
    assert np.sqrt(np.diag(graph.edge("a").covariance)) == pytest.approx([1e-4] * 3 + [math.radians(1)] * 3)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("X: [", "not valid YAML"),
        ("- 1", "holds a list"),
        ("source: none", "neither X nor pose"),
        ({"X": X.tolist(), "pose": {}}, "both X and pose"),
        ({"X": with_block(mirrored)}, "left-handed"),
        ({"X": [[1, 0, 0, 0]]}, "at least 4"),
        ({"X": X.tolist(), "trusted": False}, "not trusted"),
        ({"X": X.tolist(), "date": "soon"}, "is not a date"),
        ("X: nonsense", "X"),
    ],
)
def test_a_wrong_result_file_is_refused_by_name(tmp_path, content, message):
    path = write(tmp_path / "r.yaml", content)
    with pytest.raises(FrameError, match=message) as error:
        files.edge(FrameSection(child="a", file=str(path)))
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("section", "content"),
    [({"accept": "a phantom, A. M."}, {}), ({}, {"accepted": "a phantom, A. M."})],
)
def test_a_result_that_is_not_trusted_is_used_by_a_written_reason_which_is_told(tmp_path, section, content):
    path = write(tmp_path / "r.yaml", {"X": X.tolist(), "trusted": False, "method": "surface", **content})
    edge = files.edge(FrameSection(child="a", file=str(path), **section))
    assert pytest.approx(X) == edge.X
    assert edge.source == "surface; not trusted, accepted: a phantom, A. M."


def test_a_missing_result_file_is_refused():
    with pytest.raises(FrameError, match="not found"):
        files.edge(FrameSection(child="a", file="nowhere.yaml"))
