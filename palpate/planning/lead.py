"""Leads the hand of a running session along a plan, and plans again from where the tool is when it leaves the tube.

    lead = Lead(session, problem, plan)
    session.start()
    while session.running:
        lead.step()          # in a thread beside the loop, e.g. every 20 ms

Path and tube are soft fixtures, which a session replaces between two ticks without a step of the force. A search that
takes too long leaves the fixtures as they are.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from palpate.base.arrays import Array
from palpate.planning import planners, shorten
from palpate.planning.checker import Checker
from palpate.planning.problem import Problem
from palpate.planning.result import Plan, tip_path
from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.one_line import LEAD, WALL

TIMEOUT = 0.1
"""Time after which a new search gives up; it is examined between the steps of the search [s]."""
REST = 0.2
"""Shortest time between two searches [s]."""
_SPACING = 2e-3  # of the points of a path [m]
_SHARE = 0.9  # of the present distance that a new path keeps, if that is less than the clearance
NAMES = ("plan", "plan-tube")
"""Names of the fixtures: spring to the path, wall of the tube."""


class Led(Protocol):
    """What a session offers: `palpate.Session`, or a session on a device."""

    @property
    def fixtures(self) -> tuple[Fixture, ...]:
        """Fixtures in use."""
        ...

    @fixtures.setter
    def fixtures(self, value: Iterable[Fixture], /) -> None: ...

    def latest(self) -> Any:
        """The newest tick."""
        ...


class Lead:
    """A plan as guidance of a session.

    Args:
        session: its fixtures named `plan` and `plan-tube` are replaced, others are kept.
        problem: the problem in its present world.
        plan: the plan to lead along.
    """

    def __init__(self, session: Led, problem: Problem, plan: Plan) -> None:
        self._session, self._problem = session, problem
        self._checker = Checker(problem.robot, problem.world)
        self._scale = planners.levers(problem.robot.arm)
        self._goal = plan.curves[-1].controls[-1]
        self.clearance = plan.clearance_asked  #: [m]
        self.path = tip_path(plan, problem.robot.arm, _SPACING)[:, :3, 3]  #: (n, 3) path of the tip in W [m]
        self.radius = self.clearance  #: of the tube [m]
        self.searches = 0  #: number of new searches
        self.failures = 0  #: those that found no path in time
        self._last = -np.inf
        self._publish()

    def step(self) -> bool:
        """Plan again if the tool has left the tube; True if the fixtures were replaced."""
        tick = self._session.latest()
        away = float(np.linalg.norm(self.path - tick["p_WT"], axis=1).min())
        if away <= self.radius + 0.5 * _SPACING or float(tick["t"]) < self._last + REST:
            return False
        self._last = float(tick["t"])
        return self.renew(np.asarray(tick["q_follower"])[: self._problem.robot.arm.n])

    def renew(self, q: Array) -> bool:
        """Plan again from joints q (n,) and replace the fixtures; False if no path was found in time."""
        self.searches += 1
        found = self.replanned(q)
        if found is None:
            self.failures += 1
            return False
        self.path, self.radius = found
        self._publish()
        return True

    def replanned(self, q: Array, timeout: float = TIMEOUT) -> tuple[Array, float] | None:
        """Path (n, 3) of the tip in W [m] from joints q (n,) to the goal, and its clearance [m]; None if none is found.

        Where the instrument is already nearer to something than the clearance, the path keeps nine tenths of the
        distance that it has.
        """
        deadline = time.monotonic() + timeout
        near = self._checker.nearest(q, self.clearance)
        clearance = min([self.clearance, *(_SHARE * one.distance for one in near)])
        if clearance <= 0.0:
            return None
        found = planners.search(self._checker, q, [self._goal], clearance, self.searches, deadline)
        if found.waypoints is None:
            return None
        rows = found.waypoints
        if found.planner != planners.STRAIGHT:
            rows = shorten.shortened(self._checker, rows, self._scale, clearance, self.searches, deadline)
        return self._tips(rows), clearance

    def _tips(self, waypoints: Array) -> Array:
        """Positions (n, 3) of the tip in W [m] along straight lines of the joints."""
        robot, q = self._problem.robot, [waypoints[:1]]
        for a, b in pairwise(waypoints):
            count = max(2, int(np.linalg.norm(self._scale * (b - a)) / _SPACING))
            q.append(a + np.linspace(0.0, 1.0, count)[1:, None] * (b - a))
        return np.array([(robot.X_WB @ robot.arm.fk(row))[:3, 3] for row in np.concatenate(q)])

    def _publish(self) -> None:
        """Replace the fixtures of the session."""
        points = [[float(x) for x in p] for p in self.path]
        line = {"waypoints": points, "crossing": 0.0}
        made = (
            Fixture(name=NAMES[0], geometry={"path": line}, role="guide", law={"stiffness": LEAD}),
            Fixture(name=NAMES[1], geometry={"tube": line | {"radius": self.radius}}, role="keep-in",
                    law={"stiffness": WALL}),
        )  # fmt: skip
        self._session.fixtures = (*(one for one in self._session.fixtures if one.name not in NAMES), *made)
