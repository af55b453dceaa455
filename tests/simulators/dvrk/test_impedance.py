"""servo_ci: half planes against the formula in numpy, and a hand that pushes into a wall."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from palpate import _dvrk

vectors = st.lists(st.floats(-2, 2), min_size=3, max_size=3).map(np.array)
gains = st.fixed_dictionaries({"p": vectors, "d": vectors, "bias": vectors, "deadband": vectors})
turns = st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3).map(lambda v: Rotation.from_rotvec(v).as_matrix())


def reference_force(goal, X, V):
    """The same law, computed per axis."""

    def side(positive, negative, error, v):
        f = np.zeros(3)
        for k in range(3):
            g = positive if error[k] > 0 else negative
            e = np.sign(error[k]) * max(abs(error[k]) - abs(g["deadband"][k]), 0)
            f[k] = g["p"][k] * e + g["d"][k] * v[k] + g["bias"][k]
        return f

    A, B = goal["force_orientation"], goal["torque_orientation"]
    turn = Rotation.from_matrix(B.T @ X[:3, :3]).as_rotvec()
    f = side(
        goal["position_positive"], goal["position_negative"], A.T @ (X[:3, 3] - goal["force_position"]), A.T @ V[:3]
    )
    t = side(goal["orientation_positive"], goal["orientation_negative"], turn, B.T @ V[3:])
    return np.concatenate([A @ f, B @ t])


@given(gains, gains, gains, gains, turns, turns, turns, vectors, vectors, vectors, vectors)
def test_law_agrees_with_that_of_the_real_controller(a, b, c, d, A, B, R, at, p, v, w):
    goal = {"position_positive": a, "position_negative": b, "orientation_positive": c, "orientation_negative": d}
    goal |= {"force_orientation": A, "torque_orientation": B, "force_position": at}
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, p
    V = np.concatenate([v, w])
    assert np.allclose(_dvrk.impedance_wrench(goal, X, V), reference_force(goal, X, V), atol=1e-9)


def test_wall_pushes_with_k_err_on_one_side_only(robot):
    """A hand pushes the handle 20 mm into a floor of 300 N/m: the force is k err minus friction, and zero above."""
    r = robot("MTMR").home()
    X = r.state("MTMR")["measured_cp"]
    floor = X[2, 3]
    r.send("MTMR", "servo_ci", {"force_position": X[:3, 3],
                                "position_negative": {"p": [0, 0, -300.0], "d": [0, 0, -5.0]}})  # fmt: skip
    X[2, 3] = floor - 0.03
    r.send("MTMR", "hand/servo_cp", X)
    r.run(2.0)
    s = r.state("MTMR")
    depth = floor - s["measured_cp"][2, 3]
    assert depth > 0.01
    assert abs(s["F_hand"][2] - 300 * depth) < 0.6  # friction of joints 2 and 3: 0.3 N at the tip
    X[2, 3] = floor + 0.03
    r.send("MTMR", "hand/servo_cp", X)
    r.run(2.0)
    assert abs(r.state("MTMR")["F_hand"][2]) < 0.6


def test_servo_ci_sets_the_absolute_frame_and_leaves_it(robot):
    r = robot("MTMR").home()
    r.send("MTMR", "servo_ci", {})
    r.run(0.01)
    r.send("MTMR", "body/servo_cf", [0, 0, 1.0, 0, 0, 0])
    r.run(0.002)
    s = r.state("MTMR")
    R = s["measured_cp"][:3, :3].T
    F_tip = np.concatenate([R @ [0, 0, 1.0], np.zeros(3)])
    tau = s["measured_js"]["effort"] - s["gravity_compensation/setpoint_js"]
    assert np.abs(np.delete(tau - s["body/jacobian"].T @ F_tip, 3)).max() < 2e-3
