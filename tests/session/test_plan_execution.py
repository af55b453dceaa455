"""Plans executed in a session: path, pace and stop, guards, a world that changes, and the hand-over with the hand."""

import numpy as np
import pytest

pytest.importorskip("ompl", reason="motion planning needs the extra planning")
pytest.importorskip("coal", reason="motion planning needs the extra planning")
pytest.importorskip("ruckig", reason="motion planning needs the extra planning")

import palpate
from palpate import _core
from palpate.base.errors import PalpateError, PlanningError, StateError
from palpate.planning import Problem
from palpate.planning.world import World
from palpate.sensing.source import CloudFrame
from palpate.session import machine
from palpate.session.execution import HORIZON, PERIOD, PHASES

SCENE = """
objects:
  - {name: block, box: {size: [0.01, 0.05, 0.05]}, pose: {xyz: [0, 0, 0]}}
  - {name: %s}
arms:
  leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
  follower: {base: {xyz: [0, 0, 0.12]}}
planning: {arm: PSM1, clearance: 3 mm, speed: 0.4}
operator: {path: [{t: 0, xyz: [-0.04, 0, 0.005]}, {t: 90, xyz: [-0.04, 0, 0.005]}]}
stability: {force_cap: 6}
"""
FAR = "far, sphere: {radius: 0.01}, pose: {xyz: [0, 0.2, 0]}"
GOAL = np.array([0.4, 0.1, 0.13, 0.2, 0.1, 0.0])
EXECUTING, FOLLOWING = machine.NAMES.index("executing"), machine.NAMES.index("following")
RATE_CAP = _core.StabilityOptions().rate_cap


def scene_with(what: str = FAR) -> palpate.Scene:
    return palpate.Scene.parse(SCENE % what)


@pytest.fixture(scope="module")
def world():
    """The scene, its problem and a plan around the block; a session is made from them in a few milliseconds."""
    scene = scene_with()
    problem = Problem.of(scene)
    plan = problem.plan("current", GOAL, timeout=60.0)
    assert plan.success
    assert plan.planner != "straight line"
    return scene, problem, plan


@pytest.fixture
def session(world):
    return palpate.Session(world[0])


def awkward_durations(count):
    """Durations [s] whose product of period and number of periods, dt (n - 1), is larger by rounding."""
    rng = np.random.default_rng(7)
    while count:
        duration = rng.uniform(0.05, 0.4)
        periods = int(np.ceil(duration / 2e-3))
        if duration / periods * periods > duration:
            count -= 1
            yield duration


def ticks_of(session, n=20_000, until=lambda tick: False):
    rows = [session.latest() if session.latest()["t"] > 0.0 else session.step().tick]
    for _ in range(n):
        rows.append(session.step().tick)
        if until(rows[-1]):
            break
    return np.array(rows)


def ended(tick):
    return int(tick["session_state"]) != EXECUTING and int(tick["execution"]) > 1


def begun(session, world, ticks=400, **more):
    execution = session.execute(world[2], problem=world[1], **more)
    session.step(ticks)
    assert session.state.session == "executing"
    return execution


def worst_step(ticks, arm):
    """Largest step of the joints' goal over that of the fastest joint, and of the force over its cap, in one tick.

    A hand that is connected to the tool: falls are free, since the hand's motion or spent energy may cause them.
    """
    q = np.abs(np.diff(ticks["q_follower_goal"][:, : arm.n], axis=0)) / (arm.v_max * 1e-3)
    F, size = ticks["F_H_L"], np.linalg.norm(ticks["F_H_L"], axis=1)
    fall = np.minimum(size[1:] / np.maximum(size[:-1], 1e-30), 1.0)
    fall[ticks["session_state"][1:] != FOLLOWING] = 1.0
    step = np.linalg.norm(F[1:] - fall[:, None] * F[:-1], axis=1) / (RATE_CAP * 1e-3)
    return float(q.max()), float(step.max())


def rest_after(ticks):
    """Ticks after the first one until the goal of the joints rests for good."""
    moves = np.abs(np.diff(ticks["q_follower_goal"], axis=0)).max(axis=1) > 0.0
    return int(np.nonzero(moves)[0].max()) + 1 if moves.any() else 0


def test_the_tool_goes_along_the_plan_to_its_goal_and_the_hand_takes_over(session, world):
    _, problem, plan = world
    execution = session.execute(plan, problem=problem)
    ticks = ticks_of(session, until=ended)
    assert (execution.phase, execution.reason) == ("done", "")
    moving = ticks[ticks["execution"] == 1.0]
    wanted = plan.trajectory.at(moving["execution_t"])[0]
    np.testing.assert_allclose(moving["q_follower_goal"][:, :6], wanted, atol=5e-6)
    np.testing.assert_allclose(ticks[-2]["q_follower_goal"][:6], GOAL, atol=5e-6)
    assert len(moving) == pytest.approx(1e3 * plan.duration_s, abs=60)
    ticks = np.concatenate([ticks, ticks_of(session, 300)])
    assert session.state.session == "following"
    assert max(worst_step(ticks, problem.robot.arm)) <= 1.0 + 1e-9
    assert not ticks["F_H_L"].any()  # the hand is free, and nothing is touched


@pytest.mark.parametrize("speed", [1.0, 0.25])
def test_every_stop_at_full_speed_rests_within_fifty_milliseconds(world, speed):
    scene, problem, plan = world
    worst = 0
    for at in (150, 400, 555, 700, 901):
        session = palpate.Session(scene)
        execution = begun(session, world, at, speed=speed)
        execution.stop()
        ticks = ticks_of(session, 120)
        worst = max(worst, int((ticks["session_state"] == EXECUTING).sum()) - 1)
        assert worst_step(ticks, problem.robot.arm)[0] <= 1.0
        assert (execution.phase, session.state.session) == ("stopped", "following")
        ticks = ticks[:-1][ticks[1:]["session_state"] == EXECUTING]
        on_path = plan.trajectory.at(ticks["execution_t"])[0]
        np.testing.assert_allclose(ticks["q_follower_goal"][:, :6], on_path, atol=5e-6)
    assert 2 < worst <= 14


def test_a_pause_rests_and_goes_on_and_the_speed_can_change(session, world):
    execution = begun(session, world)
    execution.pause()
    ticks = ticks_of(session, 200)
    assert rest_after(ticks) <= 22
    assert execution.phase == "paused"
    execution.speed = 0.3
    execution.resume()
    session.step(200)
    before = execution.time
    session.step(500)
    assert execution.time - before == pytest.approx(0.3 * 0.5, abs=0.01)
    with pytest.raises(PlanningError, match="speed must lie in 0 to 1"):
        execution.speed = 2.0
    execution.speed = 1.0
    ticks_of(session, until=ended)
    assert execution.phase == "done"


@pytest.mark.parametrize("how", ["clutch", "camera", "operator", "hold", "power_off"])
def test_pedals_presence_hold_and_power_end_the_motion_without_a_step(session, world, how):
    execution = begun(session, world)
    if how in ("clutch", "camera"):
        session.console.press(how)
    elif how == "operator":
        session.console.release("operator", source="head sensor")
    else:
        session.request(how)
    ticks = ticks_of(session, 300)
    assert rest_after(ticks) <= 22
    assert max(worst_step(ticks, world[1].robot.arm)) <= 1.0
    assert execution.phase == "stopped"
    assert "pedal" in execution.reason
    states = {"clutch": "clutched", "operator": "homed", "power_off": "off"}
    assert session.state.session == states.get(how, how)


def test_the_hand_over_from_a_pressing_hand_makes_no_step(world):
    """A plan begins while the hand presses into a fixture's spring, and ends where another spring acts."""
    scene = palpate.Scene.parse(
        (SCENE % FAR).replace("speed: 0.4", "speed: 0.4, jaw: [0, 0.7]")  # the hand holds the jaws open
        + """
guidance:
  - {name: wall, geometry: {plane: {at: [-0.041, 0, 0], normal: [1, 0, 0]}}, role: keep-in,
     law: {stiffness: 900}}
  - {name: end, geometry: {plane: {at: [-0.01, 0, 0], normal: [1, 0, 0]}}, role: forbid, law: {stiffness: 100}}
"""
    )
    session = palpate.Session(scene)
    session.step(300)
    assert session.state.session == "following"
    assert np.linalg.norm(session.latest()["F_H_L"]) > 0.3
    problem = Problem.of(scene, rig=session.rig)
    plan = problem.plan(np.asarray(session.latest()["q_follower_goal"])[:6], GOAL, timeout=60.0)
    session.execute(plan, problem=problem)
    ticks = np.concatenate([ticks_of(session, until=ended), ticks_of(session, 800)])
    assert session.state.session == "following"
    assert np.linalg.norm(ticks[-1]["F_H_L"]) > 0.3
    resting = ticks[ticks["session_state"] == EXECUTING][400:]
    assert not resting["F_H_L"].any()
    assert max(worst_step(ticks, problem.robot.arm)) <= 1.0 + 1e-9


def test_a_step_at_the_hand_over_would_be_noticed(session, world):
    ticks = ticks_of(session, 20)
    ticks["q_follower_goal"][10:, 1] += 0.01
    assert worst_step(ticks, world[1].robot.arm)[0] > 1.0
    ticks["F_H_L"][10:, 0] += 2.0
    assert worst_step(ticks, world[1].robot.arm)[1] > 1.0


def test_the_guard_stops_at_a_contact_that_the_plan_did_not_know(session, world):
    _, problem, _ = world
    empty = problem.with_world(World())
    through = empty.plan("current", GOAL)
    assert through.planner == "straight line"
    execution = session.execute(through, problem=empty)
    ticks = ticks_of(session, until=ended)
    assert execution.phase == "aborted"
    assert "touched something" in execution.reason
    felt = np.linalg.norm(ticks["F_T_W"], axis=1)
    first = int(np.argmax(felt > 1.0))
    assert rest_after(ticks[first:]) <= 22


def test_a_hard_fixture_stops_the_motion(world):
    scene = palpate.Scene.parse(
        SCENE % FAR
        + """
guidance:
  - {name: half, geometry: {plane: {at: [0.01, 0, 0], normal: [1, 0, 0]}}, role: keep-in, hard: true}
"""
    )
    session = palpate.Session(scene)
    execution = session.execute(world[2], problem=world[1])
    ticks = ticks_of(session, until=ended)
    assert execution.phase == "aborted"
    assert "fixture" in execution.reason
    assert ticks[-1]["p_WT_goal"][0] < 0.012


def test_without_new_proofs_the_tool_rests_before_the_end_of_the_last(world):
    """A scene that can change, and a watching thread that hangs: only the loop runs."""
    scene = scene_with("near, sphere: {radius: 0.01}, pose: {xyz: [0, 0.2, 0]}, motion: [{amplitude: [0, 0, 0.002]}]")
    session = palpate.Session(scene)
    execution = session.execute(world[2], problem=Problem.of(scene, rig=session.rig))
    session.step(300)
    proved = execution.time + HORIZON
    session.simulation.run(4000)
    tick = session.latest()
    assert int(tick["session_state"]) == EXECUTING
    assert proved - 0.1 < tick["execution_t"] <= proved + PERIOD
    ticks_of(session, until=ended)
    assert execution.phase == "done"


def test_an_organ_that_moves_into_the_path_aborts_before_the_tool_is_there(world):
    organ = "organ, sphere: {radius: 0.012}, pose: {xyz: [0.05, -0.013, -0.1]}, motion: [{velocity: [0, 0, 0.1]}]"
    scene = scene_with(organ)
    session = palpate.Session(scene)
    problem = Problem.of(scene, rig=session.rig)
    plan = problem.plan("current", GOAL, timeout=60.0)
    execution = session.execute(plan, problem=problem)
    ticks = ticks_of(session, 4000, until=ended)
    assert execution.phase == "aborted"
    assert "organ" in execution.reason
    assert not ticks["contacts"].any()
    assert execution.time < plan.duration_s


class Shown:
    """A camera that sees a patch of points, which appears somewhere else after a while."""

    def __init__(self, later: np.ndarray, when: float) -> None:
        grid = np.linspace(-0.012, 0.012, 25)
        x, y = (a.ravel() for a in np.meshgrid(grid, grid))
        self.patch = np.stack([x, y, np.zeros_like(x)], axis=1)
        self.later, self.when, self.last = later, when, -1.0

    def latest(self, t: float) -> CloudFrame | None:
        if t < self.last + 0.03:
            return None
        self.last = t
        centre = self.later if t >= self.when else np.array([-0.04, 0.0, -0.035])
        return CloudFrame(self.patch + centre - [0, 0, 0.3], t, _camera())

    def close(self) -> None:
        pass


def _camera() -> np.ndarray:
    X = np.eye(4)
    X[2, 3] = 0.3
    return X


@pytest.mark.parametrize("comes", [True, False])
def test_a_live_cloud_ahead_aborts(comes):
    scene = scene_with("tissue, cloud: {sensor: camera, region: 0.2}")
    later = np.array([0.02, 0.0, 0.01]) if comes else np.array([-0.04, 0.0, -0.04])
    session = palpate.Session(scene, clouds={"tissue": Shown(later, 0.3)})
    problem = Problem.of(scene, rig=session.rig)
    plan = problem.plan("current", GOAL, timeout=60.0)
    execution = session.execute(plan, problem=problem)
    ticks_of(session, 6000, until=ended)
    assert (execution.phase, "tissue" in execution.reason) == (("aborted", True) if comes else ("done", False))
    assert execution.time < 1.0 or not comes


def test_a_stale_plan_a_wrong_start_a_wrong_state_and_a_second_plan_move_nothing(session, world):
    _, problem, plan = world
    session.change(following=False)
    moved = problem.with_world(problem.world.moved("block", _at(plan)))
    with pytest.raises(PlanningError, match="scene has changed"):
        session.execute(plan, problem=moved)
    with pytest.raises(PlanningError, match="from the start of the plan"):
        session.execute(problem.plan(GOAL, np.add(GOAL, 0.05)), problem=problem)
    with pytest.raises(PlanningError, match="guard must be a force"):
        session.execute(plan, problem=problem, guard=-1.0)
    session.step(10)
    session.request("follow")
    session.step(10)
    session.request("clutch")
    session.step(10)
    with pytest.raises(StateError, match="while the session is clutched"):
        session.execute(plan, problem=problem)
    session.request("stop")
    session.step(10)
    with pytest.raises(StateError, match="while the pedal clutch is down"):
        session.execute(plan, problem=problem)
    session.change(clutch=False)
    session.step(10)
    assert not session.latest()["execution_motion"]
    fresh = problem.plan(np.asarray(session.latest()["q_follower_goal"])[:6], GOAL)
    execution = session.execute(fresh, problem=problem)
    session.step(300)
    with pytest.raises(StateError, match="another plan moves the follower"):
        session.execute(plan, problem=problem)
    execution.stop()
    session.step(100)
    assert execution.over


def _at(plan):
    X = np.eye(4)
    X[:3, 3] = Problem.of(scene_with()).robot.arm.fk(plan.joints[-1])[:3, 3] + [0, 0, 0.12]
    return X


@pytest.mark.parametrize(("gap", "free"), [(0.02, True), (0.002, False)])
def test_a_plan_for_other_angles_of_the_jaws_is_proved_for_those_of_the_session(gap, free):
    """The plan is made for closed jaws, and those of the session are open, beside a ball."""
    base, jaw = "follower: {base: {xyz: [0, 0, 0.12]}", 1.0
    text = (SCENE % FAR).replace(base, f"{base}, jaw: {{start: {jaw}}}").replace("speed: 0.4", "speed: 0.4, jaw: 0")
    problem = Problem.of(palpate.Scene.parse(text))
    q = problem.states["current"]
    robot = problem.robot.with_jaws(jaw, jaw)
    (k,) = [k for k, body in enumerate(robot.bodies) if body.name == "jaw_1"]
    closed, opened = (one.placed(q[None]).ends_W[0, k] for one in (problem.robot, robot))
    opened = min(opened, opened[::-1], key=lambda ends: np.linalg.norm(ends - closed))  # ends have no order
    end = int(np.argmax(np.linalg.norm(opened - closed, axis=1)))
    outward = (opened[end] - closed[end]) / np.linalg.norm(opened[end] - closed[end])
    place = (opened[end] + (0.0045 + gap) * outward).tolist()  # radii: jaw 2.5 mm, ball 2 mm
    session = palpate.Session(
        palpate.Scene.parse(text.replace(FAR, f"far, sphere: {{radius: 0.002}}, pose: {{xyz: {place}}}"))
    )
    problem = Problem.of(session.scene)
    plan = problem.plan("current", q - [0, 0, 0.005, 0, 0, 0], timeout=60.0)
    assert plan.success
    if not free:
        with pytest.raises(
            PlanningError, match=r"(?s)the jaws are at 1.000 rad, .*jaw.*and far come nearer.*0.000 to 0.000 rad"
        ):
            session.execute(plan, problem=problem)
        return
    session.execute(plan, problem=problem)
    ticks = ticks_of(session, until=ended)
    assert int(ticks["execution"][-1]) == PHASES.index("done")
    assert np.ptp(ticks["jaw"][1:]) < 1e-9


def test_the_core_refuses_what_it_cannot_execute(session):
    loop = session.simulation
    q = np.zeros((3, 6))
    for bad in (
        {"q": q[:1], "v": q[:1]}, {"v": q[:2]}, {"dt": 0.0}, {"dt": float("nan")}, {"levers": np.zeros(6)},
        {"pace": 2.0}, {"until": -1.0}, {"q": np.full((3, 6), np.nan)},
    ):  # fmt: skip
        with pytest.raises(ValueError, match=r"planned motion|execution"):
            loop.execute(**({"q": q, "v": q, "dt": 0.1, "levers": np.ones(6)} | bad))
    number = loop.execute(np.full((3, 6), 0.3), q, 0.1, np.ones(6), until=1.0)  # begins elsewhere
    session.step(20)
    tick = session.latest()
    assert (tick["execution_motion"], tick["execution"], session.state.session) == (number, 7.0, "following")


def test_a_motion_that_cannot_begin_is_forgotten(session, world):
    """A clutch that is pressed at this moment: the motion must not begin when it is released, much later."""
    _, problem, plan = world
    session.change(following=False)
    session.step(10)
    session.execute(plan, problem=problem)
    session.console.press("clutch")
    session.step(200)
    session.console.release("clutch")
    session.step(50)
    assert session.state.session == "homed"
    assert session.execution is not None
    assert session.execution.over
    assert not session.latest()["execution_t"]


def test_the_bench_measures_stops_in_lockstep_and_in_real_time():
    from palpate_lab.verify.bench import execution

    rows = execution.run(1)
    assert [row["mode"] for row in rows] == ["lockstep", "real time"]
    assert 0.010 <= rows[0]["goal_worst_s"] <= 0.014
    assert rows[0]["goal_worst_s"] < rows[0]["tool_worst_s"] <= 0.05
    assert rows[0]["tool_worst_s"] < rows[0]["slow_worst_s"] <= 0.05
    ticks = np.zeros(200, dtype=[("t", float), ("q_follower_goal", float, 7), ("p_WT", float, 3)])
    ticks["t"] = 1.0 + 1e-3 * np.arange(200)
    ticks["p_WT"][:, 0] = 0.1 * np.minimum(ticks["t"] - 1.0, 0.08)  # a tool that rests after 80 ms
    assert execution._rested(ticks, 1.0) == pytest.approx((0.0, 0.08, 0.085), abs=2e-3)
    ticks["p_WT"][:, 0] = 2e-3 * (ticks["t"] - 1.0)  # a tool that creeps at 2 mm/s
    with pytest.raises(PalpateError, match="does not rest"):
        execution.rested(ticks["t"], ticks["q_follower_goal"], ticks["p_WT"], np.full(200, 2e-3))


@pytest.mark.parametrize("duration", tuple(awkward_durations(8)))
def test_a_motion_ends_whatever_the_rounding_of_its_duration(session, duration):
    """The cycle's end of the motion and the sender's differ by rounding; the motion is over at both."""
    loop, periods = session._loop, int(np.ceil(duration / 2e-3))
    session.step(400)
    q = np.tile(session.latest()["q_follower_goal"][:6], (periods + 1, 1))
    loop.execute(q, np.zeros_like(q), duration / periods, np.ones(6), 1.0, duration, 1.0)
    ticks = ticks_of(session, int(1e3 * duration) + 200, ended)
    assert PHASES[int(ticks["execution"][-1])] == "done"
