"""`palpate plan`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from palpate.planning import Plan, Problem


@dataclass
class Command:
    """Plan a motion of the instrument that touches nothing: no organ, no other instrument, no endoscope.

    examples:
      palpate plan planning --to behind-gallbladder --out plan.yaml
      palpate plan scenes/planning.yaml --from home --to joints:0.2,-0.8,0.2,0.4,-0.2,0 --clearance 5mm
      palpate plan my.yaml --to goal.yaml --json plan.json --figure plan.png
      palpate plan planning --to behind-gallbladder --retreat 20mm --approach 20mm
      palpate plan my.yaml --through places.yaml --out plan.yaml

    A start or goal is a name (current, home, or one of the scene's planning.states), joints:q1,q2,... [rad, m],
    pose:x,y,z,roll,pitch,yaw of the tip in W [m, deg], or a YAML file with joints or pose. The exit code is 1 if no
    motion is found.
    """

    scene: Positional[Path]
    """Scene file (YAML), or the name of a shipped scene."""
    arm: str | None = None
    """Name of the arm; the scene's planning.arm when left out."""
    from_: Annotated[str, arg(name="from")] = "current"
    """Start of the motion."""
    to: str = "home"
    """Goal of the motion."""
    through: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Plan through all places of a file instead, from the first to the last (palpate run --record-places)."""
    retreat: str | None = None
    """Begin with a retreat along the trocar by this distance, e.g. 20mm."""
    approach: str | None = None
    """Reach the goal by an insertion along the trocar of this distance, e.g. 20mm."""
    clearance: str | None = None
    """Smallest distance from everything, e.g. 3mm; the scene's planning.clearance when left out."""
    seed: int = 0
    """Seed of the search: the same seed gives the same plan [-]."""
    timeout: float = 5.0
    """Time after which the search gives up [s]."""
    planner: str = "RRTConnect"
    """OMPL's planner: RRTConnect, LBKPIECE1, BKPIECE1, KPIECE1, RRT or BITstar."""
    trajectory: Annotated[Path | None, arg(metavar="FILE")] = None
    """Check and time a trajectory of MoveIt instead (YAML of a RobotTrajectory or JointTrajectory)."""
    out: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Write the plan, for execution and for guidance (follow: {plan: FILE.yaml})."""
    figure: Annotated[Path | None, arg(metavar="FILE.png")] = None
    """Draw the motion, and the clearance over time."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the plan as JSON (docs/json/plan.md); - for the standard output."""

    def __call__(self) -> int:
        """Plan, print the clearance, write the files; returns 1 if no motion is found."""
        from palpate.planning import Problem
        from palpate.scene import Scene

        console = console_for(self.json)
        for file in (self.out, self.figure, self.json):
            require_writable(file)
        problem = Problem.of(Scene.load(self.scene), self.arm)
        found = self._found(problem)
        for note in found.notes:
            say(console, note, "note:")
        for line in _lines(found):
            say(console, line)
        if found.success:
            if self.out is not None:
                found.save(self.out, problem.robot.arm)
                say(console, f"wrote {self.out}; in a scene: guidance: [{{follow: {{plan: {self.out}}}}}]")
            if self.figure is not None:
                from palpate.planning.figure import draw

                draw(self.figure, problem, found)
                say(console, str(self.figure), "figure:")
        write_json(self.json, found.as_json())
        return 0 if found.success else 1

    def _found(self, problem: Problem) -> Plan:
        from palpate.planning import goals

        clearance = goals.length(self.clearance, "--clearance")
        if self.trajectory is not None:
            from palpate.planning import moveit

            return moveit.checked(problem, moveit.read(self.trajectory), clearance)
        retreat, approach = goals.length(self.retreat, "--retreat"), goals.length(self.approach, "--approach")
        if self.through is None and retreat is None and approach is None:
            return problem.plan(self.from_, self.to, clearance, self.seed, self.timeout, self.planner)
        places = [self.from_, self.to] if self.through is None else goals.read_places(self.through)
        rows = problem.with_trocar_motions(places, retreat or 0.0, approach or 0.0, self.seed)
        return problem.through(rows, clearance, self.seed, self.timeout)


def _jaws(span: tuple[float, float]) -> str:
    """The angle or range of the jaws, unless they are closed."""
    low, high = span
    if low == high == 0.0:
        return ""
    return f", jaws at {low:.3g} rad" if low == high else f", jaws from {low:.3g} to {high:.3g} rad"


def _lines(found: Plan) -> list[str]:
    if not found.success:
        return [f"{found.arm}: {found.reason}"]
    lines = [
        f"{found.arm}: {found.duration_s:.2f} s of motion along {len(found.curves)} curves, "
        f"found in {found.time_s:.2f} s by {found.planner} (seed {found.seed}), checked with {found.geometry}"
        + _jaws(found.jaw)
    ]
    clearance = found.clearance
    if clearance is not None and found.clearance_m is not None:
        place = ", ".join(f"{1e3 * x:.1f}" for x in clearance.p_W)
        lines.append(
            f"smallest clearance {1e3 * clearance.minimum:.2f} mm (asked: {1e3 * found.clearance_asked:g} mm): "
            f"{clearance.nearest[0]} and {clearance.nearest[1]} at {clearance.at_t:.2f} s, at ({place}) mm in W"
        )
    return lines
