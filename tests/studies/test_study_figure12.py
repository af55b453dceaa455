"""`palpate study figure12`: consistent forces at an instant, and the figure."""

import json_contract
import numpy as np
import pytest

from palpate.base.plotting.style import png
from palpate.world.shapes.analytic import SHAPES
from palpate_lab.studies.figure12 import work as figure12
from palpate_lab.studies.figure12.figures import draw


@pytest.fixture(scope="module")
def moment():
    (found,) = figure12.run(("torus",), seconds=2.0)
    return found


def test_spatial_and_body_force_are_one_force_in_two_frames(moment):
    row = figure12.row(moment)
    assert set(row) == json_contract.keys("study figure12")
    leader, X_WL = moment.setup.arms.leader, moment.setup.arms.X_WL
    R_LH = leader.fk(moment.tick["q"])[:3, :3]
    assert np.linalg.norm(row["F_H_L_N"]) > 0.5
    assert R_LH @ row["F_H_H_N"] == pytest.approx(np.array(row["F_H_L_N"]), abs=1e-9)
    scale = np.linalg.norm(row["F_H_L_N"]) / np.linalg.norm(row["F_T_W_N"])
    assert X_WL[:3, :3] @ row["F_H_L_N"] == pytest.approx(scale * np.array(row["F_T_W_N"]), abs=0.02)


def test_force_is_along_the_normal_of_the_exact_torus(moment):
    X_WO = moment.setup.surfaces[0].X_WO
    p_OT = X_WO[:3, :3].T @ (moment.tick["p_WT"] - X_WO[:3, 3])
    phi, n = SHAPES["torus"].distance(p_OT[None])
    force = X_WO[:3, :3].T @ moment.tick["F_T_W"]
    assert np.degrees(np.arccos(force @ n[0] / np.linalg.norm(force))) < 0.5
    assert moment.tick["depth"] == pytest.approx(0.015 - phi[0], abs=1e-5)


def test_figure_is_drawn(moment, tmp_path):
    png(lambda canvas: draw([moment, moment], canvas), tmp_path / "figure12.png")
    assert 5_000 < (tmp_path / "figure12.png").stat().st_size < 150_000
