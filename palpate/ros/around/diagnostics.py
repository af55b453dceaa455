"""Diagnostics for rqt_robot_monitor: rates, latency, energy, caps, and what forbids or withholds a force."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.record import withheld
from palpate.record.ticks import STATUS
from palpate.ros import causes
from palpate.ros.around.convert import latched

if TYPE_CHECKING:
    from palpate.ros.plant import CrtkPlant
    from palpate.scene.rig import Rig
    from palpate.session import Session

_CAPS = ("force_capped", "rate_capped", "passivity")
_WAITING = ("not_following", "clutched")  # not faults: no force is requested


class Diagnostics:
    """Publishes /diagnostics, ~/message (events) and ~/scene (YAML)."""

    def __init__(self, node: Any, session: Session, plant: CrtkPlant) -> None:
        from diagnostic_msgs.msg import DiagnosticArray
        from std_msgs.msg import String

        from palpate.ros.plant import News

        self._node, self._session, self._plant = node, session, plant
        self._news = News(session)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._message = node.create_publisher(String, "~/message", 10)
        self._scene = node.create_publisher(String, "~/scene", latched())
        self._shown: Rig | None = None

    def publish(self) -> None:
        """Publish new events, a changed scene and the diagnostics; called once a second."""
        from diagnostic_msgs.msg import DiagnosticArray
        from std_msgs.msg import String

        for words in self._news.take():
            self._message.publish(String(data=words))
        rig = self._session.rig
        if rig is not self._shown:
            self._scene.publish(String(data=rig.resolved_yaml(absolute=True)))
            self._shown = rig
        array = DiagnosticArray(status=[self._status()])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    def _status(self) -> Any:
        from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

        session, tick = self._session, self._session.latest()
        bits, timing = int(np.nan_to_num(tick["status"])), session.timing
        on = [name for name, (bit, _) in STATUS.items() if bits & bit]
        faults = [name for name in on if name not in (*_CAPS, *_WAITING)]
        words = [*causes.conditions(bits), *withheld.in_words(tick)] or ["free to push"]
        asked, less = np.nan_to_num(tick["F_asked"]), np.nan_to_num(tick["F_withheld"])
        values = {
            "leader rate [Hz]": f"{timing['leader_rate']:.1f}",
            "age of its state when it came [us]": f"{timing['leader_age_us']:.0f}",
            "clock of the leader": causes.offset(timing["leader_clock_s"]),
            "answer p50 / p99 / longest [us]": " / ".join(f"{timing['answer_us'][k]:.0f}" for k in _PERCENTILES),
            "cycle p50 / p99 / longest [us]": " / ".join(f"{timing['cycle_us'][k]:.1f}" for k in _PERCENTILES),
            "messages taken / left out": f"{timing['leader_messages']} / {timing['leader_left_out']}",
            "wrenches sent": f"{timing['published']}",
            "guardian took over": f"{timing['guardian_took_over']}",
            "force [N]": f"{np.linalg.norm(tick['F_H_L']):.3f}",
            "force asked, of contacts, of guidance [N]": " / ".join(f"{F:.3f}" for F in asked),
            **{f"force withheld by {name} [N]": f"{F:.3f}" for name, F in zip(withheld.NAMES, less, strict=True)},
            "shift of the tool against the hand [mm]": f"{1e3 * float(np.linalg.norm(tick['p_shift_W'])):.2f}",
            "force cap [N]": f"{self._plant.loop.force_cap:g}",
            "penetration [mm]": f"{1e3 * float(tick['depth']):.2f}",
            "energy taken from the hand [mJ]": f"{1e3 * float(tick['energy_port']):.3f}",
            "energy withheld by the caps [mJ]": f"{1e3 * float(tick['energy_cut']):.3f}",
            "energy withheld by passivity [mJ]": f"{1e3 * float(tick['energy_passivity']):.3f}",
            "status": ", ".join(on) or "none",
            "nearest": session.nearest(tick) or "none",
            "scheduler": str(timing["scheduler"]),
        }
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if faults else DiagnosticStatus.OK,
            name=f"palpate: {self._plant.loop.names.leader}",
            message="; ".join(words),
            hardware_id=self._plant.loop.names.leader,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )


_PERCENTILES = ("p50", "p99", "max")
