"""Faults of a run on a device: which conditions removed its force, when first and for how many ticks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.record.ticks import STATUS, Ticks

NO_FAULTS = frozenset({
    "not_following", "clutched", "force_capped", "rate_capped", "passivity", "ik_failed", "guided", "goal_corrected",
})  # fmt: skip
"""Status bits of ordinary operation."""

HOW_TO_LEAVE = {
    "guarded": "restart the node: its guardian has taken over the arm, or ended",
    "second_writer": "end the other program that commands this arm (ros2 topic info -v .../servo_cf names it)",
    "other_teleop": "end or disable the other teleoperation",
    "frame_unsure": "set body/set_cf_orientation_absolute and use_gravity_compensation again, or restart the node",
    "jumped": "wait: a steady pose ends it; if it returns, look for a second source of poses or a loose encoder",
    "clock_jumped": "wait for the clock to settle; synchronise both machines with chrony or NTP",
    "bad_stamp": "let the device stamp its messages with valid times",
    "two_sources": "end one of the programs that publish this topic; its name is in the messages of the node",
    "no_listener": "start the arm, or look for the name of its topic; the force then begins at zero",
    "base_moved": "restart the node with the scene's base for this frame, or let the arm report in its first frame",
    "clock_offset": "synchronise both machines with chrony or NTP; a delay as long counts as an offset",
    "not_rotation": "let the device report unit quaternions; the next valid state ends it",
    "too_far": "let the device report metres; the next valid state ends it",
    "streams_disagree": "let measured_cv be the velocity of measured_cp, in its frame, or do not publish it",
    "alternating": "look for a second source of poses; a steady pose ends it",
    "stalled": "wait; if it returns, relieve this machine, or allow real-time priority (docs/platforms.md)",
    "not_finite": "let the device report finite numbers; the next valid state ends it",
    "leader_stale": "look for the leader: power, cable, its program; its next state ends it",
    "follower_stale": "look for the follower: power, cable, its program; its next state ends it",
    "lagging": "free the instrument, or move the hand slower; the tool is then engaged where it is",
    "slow": "raise the rate at which the leader reports its state, or lower rates.haptic",
    "not_enabled": "enable and home both arms",
    "no_operator": "take place at the console: operator pedal pressed, head in the viewer",
    "settling": "wait a tenth of a second",
    "torque_limited": "press less, or move the arm's base so that the load is smaller",
    "no_load_cell": "use torque.law: stiffness, or an arm with a force sensor in its handle",
    "no_torques": "let the follower report its drive torques, or use force.source: contact",
    "singular": "fold the leader: clutch, and bring the handle back to the middle",
    "too_fast": "move slower",
    "guidance_conflict": "switch one of the contradicting fixtures off",
    "frame_lost": "bring the tracked body back into view of its tracker",
    "energy_deficit": "press slowly: the hand's work covers it; if it returns, keep the loop's rate, or raise "
    "stability.acceleration",
    "soft_frozen": "wait: the soft body rests, then the force returns; if that repeats, press less",
    "soft_late": "wait; if it returns, relieve this machine, or give the soft object fewer elements",
    "hand_slipped": "lower the stiffness or the force cap, or raise operator.grip_force_max",
}
"""How an operator leaves each fault; the force returns by a ramp when its cause is gone."""


def how_to_leave(status: int) -> str:
    """Sentences on the faults in the bits of a status and on how to leave them; empty without a fault."""
    present = [name for name, (bit, _) in STATUS.items() if status & bit and name in HOW_TO_LEAVE]
    return "; ".join(f"{STATUS[name][1]}. To leave it: {HOW_TO_LEAVE[name]}" for name in present)


@dataclass
class Seen:
    """Time of the first tick with a fault [s], and the number of such ticks."""

    first: float
    ticks: int = 0


class SeenFaults:
    """The faults in the status of ticks.

    Args:
        ordinary: names of status bits that are no faults.
    """

    def __init__(self, ordinary: frozenset[str] = NO_FAULTS) -> None:
        self._bits = {name: (bit, words) for name, (bit, words) in STATUS.items() if name not in ordinary}
        self.seen: dict[str, Seen] = {}  #: by the name of the status bit

    def take(self, ticks: Ticks) -> None:
        """Count the faults of ticks."""
        status, t = ticks["status"].astype(np.int64), ticks["t"]
        for name, (bit, _) in self._bits.items():
            hits = np.flatnonzero(status & bit)
            if len(hits):
                self.seen.setdefault(name, Seen(float(t[hits[0]]))).ticks += len(hits)

    def words(self) -> list[str]:
        """A sentence for each fault."""
        return [
            f"{self._bits[name][1]} (first at t = {one.first:.3f} s, {one.ticks} ticks)"
            for name, one in self.seen.items()
        ]
