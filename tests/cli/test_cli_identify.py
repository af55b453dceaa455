"""`palpate identify tissue`: from a table of a press to the values of a scene."""

import json

import json_contract
import numpy as np
import pytest

from palpate.world.tissue import indentation, viscosity


def test_command_prints_and_writes_the_documented_keys(palpate, tmp_path):
    t = np.arange(0.0, 6.0, 0.01)
    depth = 3e-3 * np.clip(np.interp(t, [0.2, 0.3, 3.0, 3.1], [0.0, 0.5, 0.5, 1.0]), 0.0, 1.0)
    force = viscosity.hereditary_force([(0.4, 0.3)], t, indentation.sneddon(6e-3, depth, 6e3, 0.45))
    names = "time_s,depth_m,force_N"
    np.savetxt(tmp_path / "press.csv", np.stack([t, depth, force], axis=1), "%.9g", ",", header=names, comments="")
    options = ("--radius", "6", "--json", "t.json", "--figure", "t.png")
    done = palpate("identify", "tissue", "press.csv", *options)
    assert done.code == 0, done.err
    report = json.loads((tmp_path / "t.json").read_text())
    assert set(report) == json_contract.keys("identify tissue")
    assert report["young_Pa"] == pytest.approx(6e3, rel=0.03)
    assert "in a scene: tissue: {young:" in done.out
    assert (tmp_path / "t.png").stat().st_size > 10_000
    again = palpate("identify", "tissue", "press.csv", "--radius", "6", "--figure", "t.png")
    assert (again.code, "exists already" in again.err) == (2, True)
    assert palpate("identify", "tissue", "press.csv", "--radius", "6", "--poisson", "0.7").code == 2
