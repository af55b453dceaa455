"""Random commands in random order: states stay finite and valid, torques within limits, disabled arms undriven."""

from functools import cache

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

import palpate
from palpate import _dvrk
from palpate.simulators import dvrk

ARMS = ("MTMR", "MTML", "PSM1", "ECM")
KINDS = {"MTMR": 1, "MTML": 1, "PSM1": 2, "ECM": 4}
JOINTS = {"MTMR": 7, "MTML": 7, "PSM1": 6, "ECM": 4, "SUJ/PSM1": 6, "SUJ/ECM": 6}
#: payloads of messages.hpp
NONE, FLAG, VALUE, TEXT, BUTTON, NUMBERS, JOINT, POSE, ROTATION, WRENCH, CARTESIAN, IMPEDANCE = range(12)
VERBS = {
    "system": [v for v in _dvrk.verbs() if v[0] == 0],
    "console": [v for v in _dvrk.verbs() if v[0] == 1],
    "footpedals": [v for v in _dvrk.verbs() if v[0] == 2],
    "MTMR_PSM1": [v for v in _dvrk.verbs() if v[0] == 4],
    "MTML_MTMR_ECM": [v for v in _dvrk.verbs() if v[0] == 5],
    "SUJ/PSM1": [v for v in _dvrk.verbs() if v[0] == 6],
    "SUJ/ECM": [v for v in _dvrk.verbs() if v[0] == 6],
    "SUJ": [v for v in _dvrk.verbs() if v[0] == 7],
    "endoscope_focus": [v for v in _dvrk.verbs() if v[0] == 8],
} | {arm: [v for v in _dvrk.verbs() if v[0] == 3 and v[1] & KINDS[arm]] for arm in ARMS}

odd = st.sampled_from([0.0, -0.0, np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324])
number = st.one_of(st.floats(-1, 1), st.floats(-1, 1), odd)
TEXTS = st.sampled_from(
    ["home", "enable", "disable", "pause", "resume", "unhome", "align_MTM", "x" * 500, "", "MTMR_PSM1", "ECM", "PSM1"]
)


def arrays(n):
    return st.lists(number, min_size=n, max_size=n).map(np.array)


rotations = st.one_of(
    st.just(np.eye(3)),
    st.just(np.diag([1.0, -1, -1])),
    st.just(np.zeros((3, 3))),
    arrays(9).map(lambda a: a.reshape(3, 3)),
)


@st.composite
def poses(draw):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = draw(rotations), draw(arrays(3))
    return X


half_planes = st.fixed_dictionaries({}, optional={k: arrays(3) for k in ("p", "d", "bias", "deadband")})
SIDES = ("position_positive", "position_negative", "orientation_positive", "orientation_negative")
impedances = st.fixed_dictionaries(
    {},
    optional={"force_position": arrays(3), "force_orientation": rotations, "torque_orientation": rotations}
    | dict.fromkeys(
        ("position_positive", "position_negative", "orientation_positive", "orientation_negative"), half_planes
    ),
)
cartesian = st.fixed_dictionaries({}, optional={"pose": poses(), "twist": arrays(6), "wrench": arrays(6)})
PAYLOADS = {
    NONE: st.none(),
    FLAG: st.booleans(),
    VALUE: number,
    TEXT: TEXTS,
    NUMBERS: st.integers(0, 9).flatmap(arrays),
    BUTTON: st.sampled_from([0, 1, 2, -1, 99]),
    POSE: poses(),
    ROTATION: rotations,
    WRENCH: arrays(6),
    CARTESIAN: cartesian,
    IMPEDANCE: impedances,
}


@cache
def models():
    return (
        palpate.Arm.mtm("right"),
        palpate.Arm.mtm("left"),
        palpate.Arm.psm("lnd"),
        palpate.Arm.load(palpate.arm.models_folder() / "ecm.yaml"),
    )


class AnyClient(RuleBasedStateMachine):
    @initialize(homed=st.booleans())
    def build(self, homed):
        self.system = dvrk.system(ARMS)
        self.limits = {a: np.asarray(m.tau_max) for a, m in zip(ARMS, models(), strict=True)}
        if homed:
            self.system.send("system", "home")
            self.system.step(20_000)

    @rule(data=st.data(), component=st.sampled_from([*VERBS, *ARMS, *ARMS]))
    def send(self, data, component):
        _, _, name, payload = data.draw(st.sampled_from(VERBS[component]))
        velocity = None
        if payload == JOINT:
            n = 1 if name.startswith("jaw") else JOINTS.get(component, 1)
            value = data.draw(arrays(n) if data.draw(st.integers(0, 3)) else st.integers(0, 12).flatmap(arrays))
            velocity = data.draw(st.none() | arrays(n))
        else:
            value = data.draw(PAYLOADS[payload])
        assert self.system.send(component, name, value, velocity)

    @rule(n=st.sampled_from([1, 2, 30, 900]))
    def wait(self, n):
        self.system.step(n)

    @rule()
    def recover(self):
        """Recover from faults, so that further commands have an effect."""
        for command in ("disable", "home"):
            self.system.send("MTMR", "state_command", command)
        self.system.step(3000)

    @invariant()
    def all_is_finite_and_known(self):
        if not hasattr(self, "system"):
            return
        self.system.step(2)
        for arm in ARMS:
            state, truth = self.system.state(arm), self.system.truth(arm)
            assert state["state"] in ("DISABLED", "ENABLED", "PAUSED", "FAULT")
            for values in (*truth.values(), *state["measured_js"].values(), *state["setpoint_js"].values()):
                assert np.isfinite(values).all()
            for key in ("measured_cp", "setpoint_cp", "measured_cv", "body/measured_cf", "body/jacobian"):
                assert np.isfinite(state[key]).all(), (arm, key)
            for key in ("SUJ/measured_cp", "SUJ/local/measured_cp") if "SUJ/measured_cp" in state else ():
                assert np.isfinite(state[key]).all(), (arm, key)
                R = state[key][:3, :3]
                assert np.allclose(R @ R.T, np.eye(3), atol=1e-2), (arm, key)
            assert (np.abs(truth["effort"]) <= self.limits[arm] + 1e-12).all()
            if state["state"] in ("DISABLED", "FAULT"):
                assert np.all(truth["effort"] == 0), "a disabled arm is driven"
        for event in self.system.events():
            assert isinstance(event[3], bool | int | float | str | tuple | None.__class__)
        assert self.system.dropped_events == 0


AnyClient.TestCase.settings = settings(
    max_examples=25, stateful_step_count=25, deadline=None, suppress_health_check=list(HealthCheck)
)
TestAnyClient = AnyClient.TestCase
