"""`palpate bench planning`: random queries in three scenes, each plan checked densely by other means."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate import _guidance
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.planning.checker import Checker
from palpate.planning.kinematics import pose_of
from palpate.planning.lead import Lead
from palpate.planning.planners import PLANNERS, RETRACT, STRAIGHT, levers
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.planning.robot import Robot
from palpate.planning.timing import Limits
from palpate.planning.verify import verify
from palpate.planning.world import World, instrument, obstacle
from palpate.scene.guidance.fixture import Fixture
from palpate.world import surfaces
from palpate.world.mesh import Mesh
from palpate_lab.verify.bench import planning_hooks

if TYPE_CHECKING:
    from rich.table import Table

CLEARANCE = 3e-3
TIMEOUT = 5.0
_BASE = pose_of(np.array([-0.100, -0.090, 0.120]), np.radians([0.0, 0.0, 270.0]))
_WINDOW = 0.012  # width of the cage's window [m]
_CAGE = (0.06, 0.05, 0.003)  # width, height and thickness of its walls [m]
_TOP = np.array([-0.07, -0.07, 0.01])  # middle of its window [m]
_CAGE_CLEARANCE = 5e-4  # the shaft of 8.4 mm leaves 1.8 mm on each side of the window [m]


def organs() -> tuple[Problem, Array, Array]:
    """Liver, gallbladder and duodenum; goals lie around them."""
    from palpate.world import shapes

    parts = (
        ("liver", shapes.organ(), (0.0, 0.0, 0.0)),
        ("gallbladder", shapes.gallbladder(), (-0.012, -0.085, -0.022)),
        ("duodenum", shapes.duodenum(), (0.045, -0.140, -0.058)),
    )
    found = [obstacle(name, Mesh(*made, name=name), _at(place)) for name, made, place in parts]
    return _problem(World(tuple(found)), CLEARANCE), np.array([-0.10, -0.17, -0.05]), np.array([0.06, 0.03, 0.08])


def cage() -> tuple[Problem, Array, Array]:
    """A closed cage of thin walls; its only window, 12 mm wide, lies on top. Half of the queries pass the window."""
    w, h, t = _CAGE
    side = 0.5 * (w - _WINDOW)
    plates = {
        "bottom": ([w, w, t], (0, 0, -h)), "left": ([t, w, h], (-0.5 * w, 0, -0.5 * h)),
        "right": ([t, w, h], (0.5 * w, 0, -0.5 * h)), "foot": ([w, t, h], (0, -0.5 * w, -0.5 * h)),
        "head": ([w, t, h], (0, 0.5 * w, -0.5 * h)), "top left": ([side, w, t], (-0.5 * (side + _WINDOW), 0, 0)),
        "top right": ([side, w, t], (0.5 * (side + _WINDOW), 0, 0)),
        "top foot": ([_WINDOW, side, t], (0, -0.5 * (side + _WINDOW), 0)),
        "top head": ([_WINDOW, side, t], (0, 0.5 * (side + _WINDOW), 0)),
    }  # fmt: skip
    walls = [obstacle(name, surfaces.Box(size), _at(tuple(_TOP + place))) for name, (size, place) in plates.items()]
    return _problem(World(tuple(walls)), _CAGE_CLEARANCE), _TOP - [0.06, 0.06, 0.0], _TOP + 0.06


def _in_cage(problem: Problem, rng: np.random.Generator) -> Array:
    """Joint positions whose shaft passes the window and whose tip lies in the cage; they may touch its walls."""
    arm, q = problem.robot.arm, problem.robot.arm.home.copy()
    aim = _TOP + rng.uniform(-3e-4, 3e-4, 3) * [1.0, 1.0, 0.0]
    inverse = np.linalg.inv(problem.robot.X_WB)
    for _ in range(30):
        away = inverse[:3, :3] @ aim + inverse[:3, 3] - arm.fk(q)[:3, 3]
        q[:3] += np.linalg.solve(arm.jacobian(q)[:3, :3], away)
    q[2] += rng.uniform(0.015, _CAGE[1] - 0.012)
    q[3:] = rng.uniform([-1.5, -0.6, -0.6], [1.5, 0.6, 0.6])
    return q


def crossing() -> tuple[Problem, Array, Array]:
    """A second instrument whose shaft crosses the workspace of the first."""
    other = Robot("PSM2", Arm.psm(), pose_of(np.array([0.080, -0.090, 0.120]), np.radians([0.0, 0.0, 90.0])))
    world = World(tuple(instrument(other, np.array([0.0, -0.75, 0.20, 0.0, 0.0, 0.0]))))
    return _problem(world, CLEARANCE), np.array([-0.12, -0.17, -0.06]), np.array([0.04, 0.01, 0.07])


SCENES: dict[str, Callable[[], tuple[Problem, Array, Array]]] = {
    "liver-gallbladder-duodenum": organs, "cage-window": cage, "crossing": crossing,
}  # fmt: skip


def _problem(world: World, clearance: float) -> Problem:
    robot = Robot("PSM1", Arm.psm(), _BASE)
    home = np.array([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
    return Problem(robot, world, {"home": home, "current": home}, Limits.of(robot.arm, 0.2), clearance)


def _at(place: tuple[float, float, float]) -> Array:
    return pose_of(np.array(place), np.zeros(3))


def queries(problem: Problem, low: Array, high: Array, count: int, seed: int = 0) -> Iterator[tuple[Array, Array]]:
    """Random pairs of free joint positions whose tips lie in a box of W, at least 40 mm apart."""
    rng, checker, arm = np.random.default_rng(seed), Checker(problem.robot, problem.world), problem.robot.arm
    caged = any(one.name == "top left" for one in problem.world.obstacles)

    def free(inside: bool) -> Array:
        while True:
            q = rng.uniform(np.maximum(arm.q_min, -1.2), np.minimum(arm.q_max, 1.2))
            q = _in_cage(problem, rng) if inside else q
            tip = (problem.robot.X_WB @ arm.fk(q))[:3, 3]
            placed = inside or ((tip > low) & (tip < high)).all()
            if placed and checker.refusal(q, problem.clearance + 3e-4) is None:
                return q

    while count > 0:
        one, two = free(caged and count % 2 == 0), free(caged)
        tips = [(problem.robot.X_WB @ arm.fk(q))[:3, 3] for q in (one, two)]
        if caged or np.linalg.norm(tips[0] - tips[1]) > 0.04:
            yield (one, two) if count % 3 else (two, one)
            count -= 1


def run(
    count: int = 100,
    planner: str = PLANNERS[0],
    check: bool = True,
    on_progress: Callable[[str], None] = lambda _: None,
) -> list[dict[str, Any]]:
    """A row per scene: how often and how fast a plan was found, and what the dense check found."""
    rows = []
    for name, make in SCENES.items():
        problem, low, high = make()
        rows.append(_row(name, problem, queries(problem, low, high, count), planner, check))
        on_progress(f"{name}: {_found(rows[-1])}")
    return rows


def hooks(count: int = 100, check: bool = True, on_progress: Callable[[str], None] = lambda _: None,
          names: Sequence[str] = PLANNERS) -> list[dict[str, Any]]:  # fmt: skip
    """A row per planner for queries that need a search (`planning_hooks`)."""
    problem = _problem(planning_hooks.world(), planning_hooks.CLEARANCE)
    drawn = list(planning_hooks.queries(problem, count))
    rows = []
    for name in names:
        rows.append(_row("hooks", problem, drawn, name, check))
        on_progress(f"{name}: {_found(rows[-1])}")
    return rows


def _found(row: dict[str, Any]) -> str:
    return f"{100 * row['success_rate']:.0f} % of {row['queries']} found, median {row['median_s']:.3f} s"


def _row(
    name: str, problem: Problem, asked: Iterable[tuple[Array, Array]], planner: str, check: bool
) -> dict[str, Any]:
    """The plans of one scene, and what the dense check found."""
    begin = time.perf_counter()
    checker = Checker(problem.robot, problem.world)
    setup = time.perf_counter() - begin
    plans, wall, cpu = [], [], []
    for k, (start, goal) in enumerate(asked):
        used = time.process_time()
        plan = problem.plan(start, goal, seed=k, timeout=TIMEOUT, planner=planner, checker=checker)
        plans.append(plan)
        wall.append(plan.time_s)
        cpu.append(time.process_time() - used)
    good = [plan for plan in plans if plan.success]
    verdicts = [verify(problem, plan) for plan in good] if check else []
    return {
        "scene": name, "planner": planner, "queries": len(plans), "success_rate": len(good) / max(len(plans), 1),
        "median_s": float(np.median(wall)), "p95_s": float(np.percentile(wall, 95)),
        "median_cpu_s": float(np.median(cpu)), "setup_s": setup, "clearance_asked_m": problem.clearance,
        "straight": sum(plan.planner == STRAIGHT for plan in good),
        "retracted": sum(plan.planner == RETRACT for plan in good),
        "median_duration_s": float(np.median([plan.duration_s for plan in good])) if good else None,
        "violations": sum(v.violations for v in verdicts) if check else None,
        "own_contacts": sum(v.own_contacts for v in verdicts) if check else None,
        "checked_samples": sum(v.samples for v in verdicts),
        "largest_step_m": max((v.largest_step for v in verdicts), default=0.0),
        "worst_rate": max((v.worst_rate for v in verdicts), default=0.0),
        **_replans(problem, good),
        "smallest_clearance_m": min((p.clearance_m for p in good if p.clearance_m is not None), default=None),
    }  # fmt: skip


class _Nobody:
    """A session without a loop, which makes the fixtures that it is given."""

    @property
    def fixtures(self) -> tuple[Fixture, ...]:
        """No other fixtures."""
        return ()

    @fixtures.setter
    def fixtures(self, value: Iterable[Fixture]) -> None:
        _guidance.Fixtures([fixture.make() for fixture in value])

    def latest(self) -> Any:
        """No tick."""
        raise NotImplementedError


def _replans(problem: Problem, plans: list[Plan]) -> dict[str, Any]:
    """Times [s] of new searches, with their fixtures, from up to 15 mm beside each plan, and the share in time."""
    rng, arm, wall, cpu, found = np.random.default_rng(0), problem.robot.arm, [], [], []
    checker = Checker(problem.robot, problem.world)
    for plan in plans:
        lead = Lead(_Nobody(), problem, plan)
        q = plan.joints[rng.integers(len(plan.joints))]
        for _ in range(50):
            beside = np.clip(q + rng.normal(size=arm.n) * 0.01 / levers(arm), arm.q_min, arm.q_max)
            away = np.linalg.norm(lead.path - (problem.robot.X_WB @ arm.fk(beside))[:3, 3], axis=1).min()
            if plan.clearance_asked < away < 0.015 and checker.refusal(beside, 5e-4) is None:
                break
        else:
            continue
        begin, used = time.perf_counter(), time.process_time()
        found.append(lead.renew(beside))
        wall.append(time.perf_counter() - begin)
        cpu.append(time.process_time() - used)
    times = {f"replan_{name}_p{p}_s": float(np.percentile(values, p)) if values else None
             for name, values in (("wall", wall), ("cpu", cpu)) for p in (50, 95)}  # fmt: skip
    return {**times, "replans": len(found), "replan_success_rate": float(np.mean(found)) if found else None}


def table(rows: list[dict[str, Any]]) -> Table:
    """The rows as a table."""
    from rich.table import Table

    made = Table("scene", "planner", "found", "median [s]", "p95 [s]", "CPU [s]", "violations", "in itself", "samples",
                 "of limits", "again: p50, p95 [ms]")  # fmt: skip
    for row in rows:
        found, times = f"{100 * row['success_rate']:.0f} %", (row["median_s"], row["p95_s"], row["median_cpu_s"])
        checked = (
            str(row["violations"]),
            str(row.get("own_contacts", "-")),
            f"{row['checked_samples']:,}",
            f"{row['worst_rate']:.3f}",
        )
        again = (row.get(f"replan_wall_{p}_s") for p in ("p50", "p95"))
        words = ", ".join("-" if x is None else f"{1e3 * x:.0f}" for x in again)
        made.add_row(row["scene"], row["planner"], found, *(f"{x:.3f}" for x in times), *checked, words)
    return made
