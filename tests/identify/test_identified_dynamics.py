"""Identified dynamics, on arms with known parameters and on recordings of real arms."""

import os
from json import loads
from pathlib import Path

import json_contract
import moving
import numpy as np
import pinocchio
import pytest
import yaml

from palpate.arm import Arm
from palpate.arm.drives import dahl, drive_train
from palpate.arm.dynamics import Dynamics, from_data
from palpate.arm.identify import dynamics
from palpate.arm.identify.inertia import pseudo_inertia
from palpate.arm.identify.motion import motion
from palpate.base.errors import RecordingError
from palpate.cli import main

DATA = Path(os.environ.get("PALPATE_DATA", "../shared/data"))
RECORDED = {
    "mtm": (Arm.mtm("right"), DATA / "mtm_moving/mtm__one_results.csv", DATA / "mtm_moving/mtm__two_results.csv"),
    "psm": (Arm.psm(), DATA / "psm_moving/psm__one_results.csv", DATA / "psm_moving/psm__two_results.csv"),
}


@pytest.fixture(scope="module")
def found():
    arm, recording = moving.six_axis(1, noise=0.02)
    return dynamics.identify([motion(recording)], arm)


def test_another_motion_of_a_known_arm_is_predicted(found):
    q, v, a = moving.excitation(2, np.array([0.3, 0.1, 1.3, 0.2, 1.0, 0.1]), np.array([0.8, 0.4, 0.4, 0.8, 0.5, 0.8]))
    error = found.torque(q, v, a) - moving.torques(found.arm, q, v, a)
    assert (np.sqrt((error**2).mean(axis=0)) < 0.03 * moving.torques(found.arm, q, v, a).std(axis=0)).all()


def test_friction_and_rotor_inertia_are_identified(found):
    theta = dict(zip((t.name for t in found.train.terms), found.theta, strict=True))
    o = found.arm.leader_options()
    for j in range(3):
        assert theta[f"coulomb_{j + 1}"] == pytest.approx(o.coulomb[j], rel=0.15)
        assert theta[f"viscous_{j + 1}"] == pytest.approx(o.viscous[j], rel=0.15)


def test_intervals_of_the_terms_hold_the_truth_and_collinear_terms_are_named():
    """Six recordings. The rotor of the first drive turns with the first link, so torques cannot tell them apart."""
    held, errors = [], []
    for seed in range(11, 17):
        arm, recording = moving.six_axis(seed, noise=0.02)
        model = dynamics.identify([motion(recording)], arm)
        o, names = arm.leader_options(), [term.name for term in model.train.terms]
        true = np.zeros(len(names))
        for kind, values in (("coulomb", o.coulomb), ("viscous", o.viscous), ("rotor", o.rotor_inertia)):
            for j in range(arm.n):
                true[names.index(f"{kind}_{j + 1}")] = values[j]
        low, high = model.intervals().T
        held += [(low <= true) & (true <= high)]
        errors.append(abs(model.theta[names.index("rotor_1")] / o.rotor_inertia[0] - 1.0))
        assert "rotor_1" in model.unknown
        assert not {f"{kind}_{j}" for kind in ("coulomb", "viscous") for j in range(1, 7)} & set(model.unknown)
    assert 0.90 < np.mean(held) <= 1.0
    assert np.mean(errors) > 0.2


def test_every_link_has_physical_inertial_parameters(found):
    assert (dynamics.consistency(found) > 0).all()
    assert (found.masses() > 0).all()
    for pi in found.pi.reshape(-1, 10):
        assert np.linalg.eigvalsh(pseudo_inertia(pi))[0] > 0


def test_pseudo_inertia_agrees_with_pinocchio():
    pi = pinocchio.Inertia.Random().toDynamicParameters()
    np.testing.assert_allclose(
        pseudo_inertia(pi), pinocchio.PseudoInertia.FromDynamicParameters(pi).toMatrix(), atol=1e-12
    )


@pytest.mark.parametrize("arm", [Arm.mtm("left"), Arm.psm()], ids=["mtm", "psm"])
def test_regressor_prediction_is_inverse_dynamics_of_the_identified_arm(arm):
    """Two computations of one torque agree to 1e-9: W x at the drives, and the arm with the identified terms."""
    rng = np.random.default_rng(0)
    train = drive_train(arm)
    d = Dynamics(arm, arm.inertial_parameters, rng.uniform(0, 0.1, len(train.terms)))
    m = train.coupling.shape[1]
    q, v, a = moving.excitation(3, np.zeros(m), np.full(m, 0.1), 1.0)
    s = train.state(q, v, a)
    links = np.array([train.coupling.T @ arm.torque_regressor(*row) for row in zip(s.q, s.v, s.a, strict=True)])
    terms = np.stack([t.column(s) for t in train.terms], axis=2)
    np.testing.assert_allclose(d.torque(q, v, a), links @ d.pi + terms @ d.theta, atol=1e-9)


def test_friction_reverses_over_a_displacement_independent_of_speed():
    q = np.concatenate([np.linspace(0, 1, 400), np.linspace(1, 0.9, 200)])
    z = dahl(q, 0.01)
    assert z[399] == pytest.approx(1.0)
    assert z[-1] == pytest.approx(-1.0, abs=1e-3)
    np.testing.assert_allclose(dahl(q[::10], 0.01)[30:40], z[::10][30:40], atol=1e-3)
    np.testing.assert_array_equal(dahl(np.zeros(50), 0.01), np.zeros(50))


@pytest.mark.parametrize("kind", RECORDED)
def test_errors_on_real_arms_are_at_most_the_published_ones(kind):
    arm, one, two = RECORDED[kind]
    if not two.is_file():
        pytest.skip(f"no recordings in {DATA} (set PALPATE_DATA)")
    train, test = (dynamics.read_motion(str(f), arm) for f in (one, two))
    found = dynamics.identify([train], arm)
    errors = dynamics.relative_rms(found, test, 2.0, 3.0)
    assert (errors <= dynamics.PUBLISHED[kind]).all(), errors
    np.testing.assert_allclose(errors[0], dynamics.relative_rms(found, test))
    assert (dynamics.consistency(found) > 0).all()
    assert train.repeated == (887 if kind == "mtm" else 0)


def test_repeated_rows_are_marked_and_replaced():
    _, clean = moving.six_axis(1)
    q = clean.q.copy()
    late = np.arange(10, len(q), 7)
    q[late] = q[late - 1]
    mended = motion(type(clean)(q, clean.v, clean.tau, clean.rate, "late"))
    assert mended.repeated == len(late)
    error = np.abs(mended.a - motion(clean).a)[200:-200]
    assert error.max() < 0.05 * np.abs(mended.a).max()


def damaged(fault: str, recording):
    data = np.hstack([recording.q, recording.v, recording.tau])
    if fault == "short":
        return data[:300]
    if fault == "nan":
        data[41, 8] = np.nan
    if fault == "late":
        data = np.repeat(data[: len(data) // 10], 10, axis=0)
    if fault == "still":
        data[:, 1] = 0.3
        data[:, 7] = 0.0
    if fault == "degrees":
        data[:, :12] = np.degrees(data[:, :12])
    if fault == "rate":
        data[:, 6:12] *= 2.0
    if fault == "silent":
        data[:, 15] = 0.0
    if fault == "same":
        data[:] = data[0]
    return data


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("short", "1.5 s of motion are too short"),
        ("nan", "nan|NaN"),
        ("late", "2 s of motion are too short(.|\n)*3600 of them repeated"),
        ("same", "drive 1, 2, 3, 4, 5, 6 does not move"),
        ("still", "drive 2 does not move(.|\n)*coulomb_2, viscous_2, offset_2, rotor_2, spring_2"),
        ("degrees", "all rows fit when they are read as degrees"),
        ("rate", "the velocity of drive . is 2 times that of its positions"),
        ("silent", "drive 4 has no torque"),
    ],
)
def test_invalid_recordings_are_reported(fault, message, tmp_path):
    arm, recording = moving.six_axis(1)
    file = tmp_path / "bad.csv"
    np.savetxt(file, damaged(fault, recording), delimiter=",")
    with pytest.raises(RecordingError, match=message):
        dynamics.identify([dynamics.read_motion(str(file), arm)], arm)


def test_command_writes_a_readable_model_and_does_not_overwrite_it(tmp_path, capsys):
    arm, recording = moving.six_axis(1)
    file, out, json = moving.write(recording, tmp_path / "one.csv"), tmp_path / "model.yaml", tmp_path / "fit.json"
    command = ["calibrate", "dynamics", str(file), "--arm", "six_axis", "--out", str(out), "--test", str(file)]
    assert main([*command, "--json", str(json)]) == 0
    assert "relative RMS" in capsys.readouterr().out
    figures = loads(json.read_text())
    assert set(figures) == json_contract.keys("calibrate dynamics")
    assert len(figures["test"]["relative_rms_at"]) == len(figures["test"]["cutoffs_Hz"])
    model = from_data(yaml.safe_load(out.read_text()), arm, str(out))
    q, v, a = moving.excitation(2, arm.home, np.full(6, 0.3), 1.0)
    assert (np.abs(model.torque(q, v, a) - moving.torques(arm, q, v, a)).mean(axis=0) < 0.1).all()
    before = out.read_text()
    assert main(command) == 2
    assert "--force" in capsys.readouterr().err
    assert out.read_text() == before
    assert main([*command, "--force"]) == 0
    with pytest.raises(RecordingError, match="this is the model of 'six_axis'"):
        from_data(yaml.safe_load(out.read_text()), Arm.psm(), str(out))


def test_wrong_arms_and_columns_are_reported(tmp_path, capsys):
    _, recording = moving.six_axis(1, seconds=6.0)
    file = moving.write(recording, tmp_path / "one.csv")
    out = str(tmp_path / "model.yaml")
    assert main(["calibrate", "dynamics", str(file), "--arm", "mtm", "--out", out]) == 2
    assert "21 are needed" in capsys.readouterr().err
    assert main(["calibrate", "dynamics", str(file), "--arm", "puma", "--out", out]) == 2
    assert "there is no arm 'puma'" in capsys.readouterr().err
    assert not Path(out).exists()
