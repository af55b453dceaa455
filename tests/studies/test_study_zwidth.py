"""`palpate study zwidth`: the map against the roots of the loop, and the MTM's parameters against its dynamics."""

from dataclasses import replace
from functools import partial

import json_contract
import numpy as np
import pytest

from palpate.arm import Arm
from palpate.arm.hands import PRESETS
from palpate.base.sweep import sweep
from palpate_lab.studies.laws.figures import handle_mass
from palpate_lab.studies.zwidth import work as zwidth
from palpate_lab.studies.zwidth.figures import draw
from palpate_lab.studies.zwidth.words import largest, table


@pytest.fixture(scope="module")
def found():
    device = replace(zwidth.mtm(), hand=PRESETS["relaxed"])
    return zwidth.run(device, (1000.0,), (0.0, 5e-3), partial(sweep, executor="serial"), points=(12, 4))


def test_one_axis_mtm_agrees_with_its_dynamics():
    device, arm = zwidth.mtm(), Arm.mtm("right")
    assert device.mass == pytest.approx(handle_mass(), rel=0.05)  # it has a limit at singularities
    J, step = arm.jacobian(arm.home), arm.leader_options().encoder_step
    for motor in range(arm.n):  # no motor moves the handle by more per count
        moved = arm.leader_options().coupling[:, motor] * step[motor]
        shift = arm.fk(arm.home + moved)[1, 3] - arm.fk(arm.home)[1, 3]
        assert abs(shift) <= device.quantum * (1 + 1e-3)
    assert np.linalg.matrix_rank(J) == 6
    assert 0.1 < device.friction < 1.0  # friction of an MTM at the handle: some tenths of a newton
    assert 0.1 < device.damping < 10.0


def test_simulated_walls_agree_with_the_boundary(found):
    """Walls are stable below the boundary and oscillate above; the map has steps of a factor of two."""
    checked = 0
    for panel in found["panels"]:
        line = np.array([np.inf if k is None else k for k in panel["boundary_N_per_m"]])
        boundary = np.interp(panel["B_N_s_per_m"], panel["line_B_N_s_per_m"], line)
        for row, limit in zip(panel["stable"][:3], boundary, strict=False):
            for stable, K in zip(row, panel["K_N_per_m"], strict=True):
                if not 0.9 < K / limit < 1.1:
                    assert stable == (limit > K)
                    checked += 1
    assert checked > 60


def test_delay_reduces_the_stiffness_and_passive_walls_are_stable(found):
    at_once, late = (largest(panel) for panel in found["panels"])
    assert (late[:3] < 0.3 * at_once[:3]).all()
    for panel, most in zip(found["panels"], (at_once, late), strict=True):
        assert max(panel["colgate_brown_N_per_m"]) < most.max()
        b, T = found["device"]["damping_SI"], 1e-3
        passive = (b - panel["line_B_N_s_per_m"][0]) / (T / 2 + panel["delay_s"])
        assert panel["colgate_brown_N_per_m"][0] == pytest.approx(passive)


def test_keys_table_and_figure(found, tmp_path):
    assert set(found) == json_contract.keys("study zwidth")
    documented = json_contract.keys_of("study zwidth", "A panel:") - {"null"}
    assert set(found["panels"][0]) == documented
    assert len(table(found).rows) == 2
    assert 5_000 < draw(found, tmp_path).stat().st_size < 150_000
