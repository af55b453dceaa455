"""`palpate fuzz loops`: its quadratures, its verdict on laws with a planted fault, its scenes and its files."""

from types import SimpleNamespace

import numpy as np
import pytest

from palpate_lab.verify.fuzz import FaultError, loops
from palpate_lab.verify.fuzz.loops import kinds, port, reduce, slow
from palpate_lab.verify.fuzz.loops.kinds import Loop
from palpate_lab.verify.fuzz.loops.verdict import judge
from palpate_lab.verify.fuzz.loops.ways import Way

K, R, r = 800.0, 0.01, 0.002  # [N/m], [m], [m]


@pytest.fixture(autouse=True)
def _laws_settle_at_once(monkeypatch):
    monkeypatch.setattr(slow, "SETTLED", 2)


class Law:
    """A device whose wrench (6,) is a function of the handle's position (3,), or of position and rotation (3, 3)."""

    period = 0.001

    def __init__(self, wrench, state=None):
        stability, mapping = SimpleNamespace(allowance=5e-4), SimpleNamespace(scale=1.0)
        self.wrench, self.scene = wrench, SimpleNamespace(stability=stability, mapping=mapping, guidance=())

    def handle(self, p, theta):
        X = np.tile(np.eye(4), (len(p), 1, 1))
        X[:, :3, 3], X[:, :3, :3] = p, port.rotations(theta)
        return X

    def alone(self):
        return ()

    def at_rest(self):
        if self.wrench is not None:
            return lambda X: self.wrenches(X[None])[0]
        poses = []

        def wrench(X):
            poses.extend([X, X])
            return self.wrenches(np.array(poses))[-1]

        return wrench

    def wrenches(self, X, t=None):
        return np.array([np.pad(F, (0, 6 - len(F))) for F in (self.wrench(x) for x in X)])


def of_place(force):
    return Law(lambda X: force(X[:3, 3]))


def loop(*corners, theta=None, **values):
    p = np.array([*corners, corners[0]], dtype=float)
    return Loop("planted", {}, Way(p, np.zeros_like(p) if theta is None else np.array(theta)), **values)


def box(depth_x=0.01, depth_z=0.006):
    return loop((0, 0, 0.002), (0, 0, -depth_z), (depth_x, 0.003, -depth_z), (depth_x, 0.003, 0.002))


def on_ball(*polar):
    """Corners at (angle, depth) of a sphere of radius r on one of R, with chords no longer than a degree."""
    dense = np.concatenate(
        [np.linspace(a, b, 24, endpoint=False) for a, b in zip(polar, [*polar[1:], polar[0]], strict=True)]
    )
    rho = R + r - dense[:, 1]
    return loop(*np.stack([rho * np.sin(dense[:, 0]), 0 * rho, rho * np.cos(dense[:, 0])], axis=1))


def polar(p):
    rho, angle = np.hypot(p[0], p[2]), np.arctan2(p[0], p[2])
    along, out = np.array([np.cos(angle), 0, -np.sin(angle)]), np.array([np.sin(angle), 0, np.cos(angle)])
    return rho, angle, along, out


def beside_hard_fixture(projected):
    """A floor touched at the corrected place P p; the fixture's own spring acts, too."""
    n = np.array([0.342, 0.0, 0.94]) / np.hypot(0.342, 0.94)

    def force(p):
        beyond = max(-(n @ p) - 0.001, 0.0)
        F = np.array([0.0, 0.0, K * max(-(p + beyond * n)[2], 0.0)])
        P = np.eye(3) - np.outer(n, n) if beyond > 0.0 else np.eye(3)
        return (P @ F if projected else F) + 300.0 * beyond * n

    return of_place(force)


def stuck(factor):
    """A proxy that sticks at the top of a ball; without the factor, the lag at the proxy pulls the tool as it is."""

    def force(p):
        rho, angle, along, out = polar(p)
        return K * (R + r - rho) * out - K * (R + r) * angle * along * ((R + r) / rho if factor else 1.0)

    return of_place(force)


def lump(factor):
    """A stiffness that changes along a ball; without the factor, its gradient is that at the deepest point."""

    def force(p):
        rho, angle, along, out = polar(p)
        depth = max(R + r - rho, 0.0)
        stiffness, slope = K * (1 + 0.8 * np.sin(4 * angle)), 3.2 * K * np.cos(4 * angle)  # per rad
        deepest = rho - r
        term = -0.5 * depth**2 * slope / deepest  # gradient by the place of the deepest point
        return stiffness * depth * out + term * along * (deepest / rho if factor else 1.0)

    return of_place(force)


def three_axes(projected):
    n, axes = np.array([0.6, 0.0, 0.8]), K * np.array([0.3, 0.5, 1.0])

    def force(p):
        depth = max(-(n @ p), 0.0)
        return n * (n @ (axes * n)) * depth if projected else axes * n * depth

    return of_place(force)


def priorities(ordered):
    """A slope, and a spring aside whose part against the slope is removed."""
    n = np.array([0.6, 0.0, 0.8])

    def force(p):
        depth = max(-(n @ p), 0.0)
        spring = np.array([-300.0 * (p[0] + 0.01), 0.0, 0.0])
        if ordered and depth > 0.0:
            spring -= min(n @ spring, 0.0) * n
        return K * depth * n + spring

    return of_place(force)


def capped(by_length):
    """The sum of a floor and a spring aside, cut to a length, which bends the field."""

    def force(p):
        F = np.array([-200.0 * (p[0] - 0.002), 0.0, K * max(-p[2], 0.0)])
        length = np.linalg.norm(F)
        return F * (2.0 / length) if by_length and length > 2.0 else F

    return of_place(force)


def facet(nearest):
    """A valley touched on both slopes: the depth of the nearer one along the mean normal, or each along its own."""
    n = [np.array([s * 0.6, 0.0, 0.8]) for s in (1, -1)]

    def force(p):
        depth = [max(-(m @ p), 0.0) for m in n]
        if nearest and min(depth) > 0.0:
            return K * max(depth) * np.array([0.0, 0.0, 1.0])
        return sum(K * d * m for d, m in zip(depth, n, strict=True))

    return of_place(force)


def jump(kept):
    """A wall that is 4 mm higher beyond x = 0: there it stores more without work, unless it keeps the energy it had."""

    def rule(F, p):
        depth = np.maximum(np.where(p[:, 0] > 0.0, 0.004, 0.0) - p[:, 2], 0.0)
        rest, last = 0.0, depth[0]  # E = K (depth - rest)^2 / 2
        for k, d in enumerate(depth):
            if kept and k > 0 and (p[k, 0] > 0.0) != (p[k - 1, 0] > 0.0):
                rest = max(d - max(last - rest, 0.0), 0.0)
            rest, last = min(rest, d), d
            F[k] = [0.0, 0.0, K * (d - rest)]
        return F

    return Felt(rule)


def lever(with_moment):
    """A floor under the end of a tool that turns; a device without torque loses the moment."""
    arm = np.array([0.02, 0.0, 0.0])

    def wrench(X):
        at = X[:3, :3] @ arm
        F = np.array([0.0, 0.0, K * max(-(X[:3, 3] + at)[2], 0.0)])
        return np.r_[F, np.cross(at, F)] if with_moment else F

    return Law(wrench)


def turning():
    return loop((0, 0, 0.01), (0, 0, -0.004), (0, 0, -0.004), (0, 0, 0.01),
                theta=[(0, 0, 0), (0, -0.3, 0), (0, 0.3, 0), (0, 0.3, 0), (0, 0, 0)])  # fmt: skip


PLANTED = {
    "hard fixture": (beside_hard_fixture, box()),
    "friction on a ball": (stuck, on_ball((0, 1e-3), (0, 3e-3), (0.06, 3e-3), (0.06, 1e-3))),
    "region": (lump, on_ball((-0.5, -1e-3), (-0.5, 0.003), (0.4, 0.003), (0.4, -1e-3))),
    "three axes": (three_axes, box()),
    "moment": (lever, turning()),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_fault_is_found_and_the_right_law_holds(name):
    law, way = PLANTED[name]
    assert not judge(way, law(True)).fails
    found = judge(way, law(False))
    assert found.fails
    assert found.resolved


def test_friction_without_the_factor_returns_the_area_of_its_loop():
    """K (R + r)(rho1 - rho2) theta^2 / 2, the closed form."""
    way = on_ball((0, 1e-3), (0, 3e-3), (0.06, 3e-3), (0.06, 1e-3))
    assert judge(way, stuck(False)).work == pytest.approx(-K * (R + r) * 2e-3 * 0.06**2 / 2, rel=1e-2)


def test_a_wall_that_jumps_and_does_not_keep_its_energy_is_found():
    """As ramps that hands re-enter did, and hard fixtures that contradict each other: 12.8 mJ in each loop."""
    way = loop((-0.003, 0, 0.006), (-0.003, 0, -0.002), (0.003, 0, -0.002), (0.003, 0, 0.006))
    assert not judge(way, jump(True)).fails
    found = judge(way, jump(False))
    assert found.recurs
    assert found.later == pytest.approx(-K * (0.006**2 - 0.002**2) / 2, rel=0.05)


@pytest.mark.parametrize(("law", "way"), [(priorities, box()), (capped, box()), (facet, box(0.004))])
def test_a_rule_that_bends_a_field_is_found(law, way):
    assert not judge(way, law(False)).fails
    assert judge(way, law(True)).fails


class Felt(Law):
    """A floor at z = 0 whose force a rule changes: rule(F (n, 3), p (n, 3)) -> (n, 3)."""

    def __init__(self, rule):
        super().__init__(None)
        self.rule = rule

    def wrenches(self, X, t=None):
        p = X[:, :3, 3]
        F = np.zeros_like(p)
        F[:, 2] = K * np.maximum(-p[:, 2], 0.0)
        return np.pad(self.rule(F, p), ((0, 0), (0, 3)))


def pressing(**values):
    return loop((0, 0, 0.004), (0, 0, -0.004), run="felt", **values)


def lent(bounded):
    """Something lends 4 mJ in each cycle, for ever or until 25 mJ."""

    def rule(F, p):
        out = np.r_[0.0, np.diff(p[:, 2])] > 0.0
        push = np.where(out, 0.5, 0.0)
        if bounded:
            push[np.cumsum(push * np.maximum(np.r_[np.diff(p[:, 2]), 0.0], 0.0)) > 0.025] = 0.0
        return F + push[:, None] * [0, 0, 1]

    return Felt(rule)


def test_a_credit_without_bound_is_found():
    values = {"cycles": 12, "credit": 0.03}
    assert not judge(pressing(**values), lent(True)).fails
    assert judge(pressing(**values), lent(False)).fails


def test_energy_that_lay_ready_at_the_start_is_told_from_a_source():
    """A pull of 2 N towards the floor on the first way down, of which a hand gets 16 mJ once, or part on each."""
    way = pressing().way

    def pull(later):
        def rule(F, p):
            step = np.diff(p[:, 2], prepend=p[0, 2])
            down = step[np.maximum.accumulate(np.where(step != 0.0, np.arange(len(p)), 0))] < 0.0  # came from above
            far = np.cumsum(np.abs(step))
            F = np.where(far[:, None] > 0.0161, F, 0.0)  # no floor in the first cycle
            size = np.where(far <= 0.0081, 2.0, later) * (down | (far == 0.0))
            return F - size[:, None] * [0, 0, 1]

        return Felt(rule)

    once, each, less = (judge(Loop("planted", {}, way), pull(later)) for later in (0.0, 2.0, 0.05))
    assert once.ready == pytest.approx(0.016, rel=0.02)
    assert once.returns
    assert not once.fails
    assert not once.recurs
    assert each.fails
    assert each.recurs
    assert each.spent < -1.5 * each.ready
    assert less.recurs, "a source of .4 mJ a cycle is not hidden by the 16 mJ of the first one"
    assert "in the last and" in once.words()


def test_credited_friction_that_is_removed_is_found():
    """The law pushes the hand along its motion by what friction would take."""
    assert judge(pressing(), Felt(lambda F, p: F + 0.1 * np.sign(np.diff(p, axis=0, prepend=p[:1])))).fails
    assert not judge(pressing(), Felt(lambda F, p: F - 0.1 * np.sign(np.diff(p, axis=0, prepend=p[:1])))).fails


@pytest.mark.parametrize("ticks", [0, 3])
def test_a_delay_that_the_layer_does_not_know_is_found(ticks):
    """A press creates K (delay + T / 2) times the integral of v^2, in and out."""
    way = pressing()
    found = judge(way, Felt(lambda F, p: np.roll(F, ticks, axis=0)))
    assert found.work < 0.0
    assert found.fails == (ticks == 3)


def test_an_allowance_that_is_renewed_is_found():
    """0.4 mJ in each of four cycles, part of it by sampling: 0.5 mJ are allowed in all."""
    rule = Felt(lambda F, p: F + 0.02 * (np.r_[0.0, np.diff(p[:, 2])] > 0.0)[:, None] * [0, 0, 1])
    assert not judge(pressing(), rule).fails
    assert judge(pressing(cycles=4), rule).fails


def test_the_port_of_a_device_without_torque_has_three_axes():
    X = np.tile(np.eye(4), (3, 1, 1))
    X[1:, :3, :3] = port.rotations(np.array([(0, 0, 0.2), (0, 0, 0.4)]))
    X[:, 0, 3] = (0.0, 0.01, 0.03)
    F = np.tile([2.0, 0, 0, 0, 0, 0.5], (3, 1))
    assert port.work_held(F, X)[-1] == pytest.approx(-2.0 * 0.03 - 0.5 * 0.4)
    assert port.work_held(F, X, 3)[-1] == pytest.approx(-2.0 * 0.03)
    assert port.work_at_rest(F, X)[-1] == pytest.approx(-2.0 * 0.03 - 0.5 * 0.4)


def test_an_error_of_sampling_is_no_fault():
    """A force that follows the motion by two ticks: its work falls with the step, and its limit is zero."""
    late = Felt(lambda F, p: np.roll(F, 2, axis=0))
    way = loop((0, 0, 0.002), (0, 0, -0.006), (0.01, 0, -0.006), (0.01, 0, 0.002))
    found = judge(way, late)
    assert not found.fails
    assert found.error > 0.0


def test_every_kind_draws_loops_that_depend_on_the_seed_alone():
    for kind in kinds.KINDS:
        one, two = (kind(np.random.default_rng(5)) for _ in range(2))
        assert [(a.scene, a.way.p.tolist()) for a in one] == [(b.scene, b.way.p.tolist()) for b in two]
        assert all(np.array_equal(a.way.p[0], a.way.p[-1]) for a in one)


def test_smooth_surfaces_hand_out_nothing(monkeypatch):
    monkeypatch.setattr(kinds, "KINDS", {kinds.surface: 1.0})
    for seed in range(12):
        assert loops.case(seed)["loops"] > 0


def test_a_fault_names_the_worst_loop_and_its_file_repeats_it(monkeypatch, tmp_path):
    """A floor whose wrench the device turns by ten degrees: reduced to three corners, written, read, judged again."""
    wrenches = loops.Device.wrenches

    def turned(self, X, t=None):
        F = wrenches(self, X, t)
        F[:, 0] += 0.2 * F[:, 2]
        return F

    monkeypatch.setattr(loops.Device, "wrenches", turned)
    monkeypatch.setattr(kinds, "KINDS", {kinds.mixed: 1.0})
    with pytest.raises(FaultError, match="put in by the hand") as raised:
        loops.case(3)
    details = raised.value.details
    (path,) = reduce.write_worst([{"seed": 3, "what": "", "details": details}], tmp_path)
    assert reduce.again(path).startswith("fails")
    small, whole = reduce.read(path), kinds.loops(3)[details["loop"]]
    assert len(small.way.p) <= len(whole.way.p)
