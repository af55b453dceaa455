"""The node `/palpate`, which runs next to the haptic node."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from palpate.ros.background import BackgroundNode

if TYPE_CHECKING:
    from palpate.ros.plant import CrtkPlant
    from palpate.session import Session

RATE = 30.0
"""Rate of frames and markers [Hz]; diagnostics are published at the usual 1 Hz."""
NAME = "palpate"


class Around(BackgroundNode):
    """Publishes a session while the context is open.

        with Session(scene, plant=CrtkPlant(scene)) as session, Around(session):
            session.run()

    Args:
        session: the session of a `CrtkPlant`, started or not.
        name: name of the node.
        pair: name of the session's pair, which is the namespace of the node: names and topics of several sessions on
            one network differ.
        draws_objects: False leaves out the frames of the objects, which another pair publishes.
    """

    def __init__(self, session: Session, name: str = NAME, pair: str = "", draws_objects: bool = True) -> None:
        from palpate.ros.plant import plant_of

        plant = plant_of(session)
        super().__init__(name, plant.loop.context.domain, pair)
        from palpate.ros.around.diagnostics import Diagnostics
        from palpate.ros.around.frames import Frames
        from palpate.ros.around.graph_file import PERIOD, GraphFile
        from palpate.ros.around.markers import Markers
        from palpate.ros.around.swap import Swap
        from palpate.ros.around.tool import Tool

        frames, markers = Frames(self.node, session, plant, pair, draws_objects), Markers(self.node, session)
        Swap(self.node, session, plant, on_swap=markers.draw_objects)
        self.tool = Tool(self.node, session, plant)
        self._offer_take_back(plant)

        def show() -> None:
            tick = session.latest()
            frames.show(tick)
            markers.show(tick)

        self.node.create_timer(1.0 / RATE, show)
        self.node.create_timer(1.0, Diagnostics(self.node, session, plant).publish)
        self.node.create_timer(PERIOD, GraphFile(self.node, session).look)
        self.spin()

    def _offer_take_back(self, plant: CrtkPlant) -> None:
        """The service ~/take_back (std_srvs/Trigger)."""
        from std_srvs.srv import Trigger

        def take_back(_: Any, answer: Any) -> Any:
            answer.success, answer.message = True, plant.take_back()
            return answer

        self.node.create_service(Trigger, "~/take_back", take_back)
