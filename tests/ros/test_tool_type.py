"""The follower's messages about its instrument: hold, words, resume. The node and the session are stand-ins."""

from types import SimpleNamespace

import pytest

from palpate.base.errors import StateError
from palpate.scene import Scene

pytest.importorskip("rclpy", reason="ROS 2 is not installed (extra ros)")


class Session:
    def __init__(self, follower="PSM1", can_hold=True):
        self.plant = SimpleNamespace(loop=SimpleNamespace(names=SimpleNamespace(follower=follower)), events=[])
        self.scene = Scene.parse("objects: [{shape: organ, stiffness: 300}]")
        self.holds, self._can_hold = False, can_hold

    def request(self, request):
        if not self._can_hold:
            raise StateError("no effect")
        self.holds = request == "hold"

    def change(self, hold_all):
        self.holds = hold_all


@pytest.fixture
def make():
    from palpate.ros.around.tool import Tool

    def made(session):
        calls = {}
        node = SimpleNamespace(
            get_fully_qualified_name=lambda: "/palpate",
            create_service=lambda kind, name, call: calls.setdefault(name, call),
            create_subscription=lambda kind, topic, call, qos: calls.setdefault(topic, call),
        )
        return Tool(node, session, session.plant), calls

    return made


def resume(calls):
    return calls["~/resume"](None, SimpleNamespace(success=None, message=""))


@pytest.mark.parametrize("can_hold", [True, False])
def test_another_instrument_holds_until_the_first_is_mounted_again(make, can_hold):
    session = Session(can_hold=can_hold)
    tool, calls = make(session)
    typed = calls["/PSM1/tool_type"]
    for _ in range(2):  # a latched and a plain subscription
        typed(SimpleNamespace(data="LARGE_NEEDLE_DRIVER_400006"))
    assert not session.holds
    assert not session.plant.events
    typed(SimpleNamespace(data="PROGRASP_FORCEPS_400093"))
    assert session.holds
    assert "PROGRASP_FORCEPS_400093 instead of LARGE_NEEDLE_DRIVER_400006" in session.plant.events[-1]
    assert "arms.follower.model" in session.plant.events[-1]
    assert not resume(calls).success
    assert session.holds
    typed(SimpleNamespace(data="LARGE_NEEDLE_DRIVER_400006"))
    assert session.holds, "a person ends the hold"
    assert "/palpate/resume" in session.plant.events[-1]
    assert resume(calls).success
    assert not session.holds
    assert tool.mounted == tool.known


def test_a_question_for_the_type_holds_and_says_where_to_answer(make):
    session = Session()
    _, calls = make(session)
    calls["/PSM1/tool_type_request"](None)
    assert session.holds
    assert "/PSM1/set_tool_type" in session.plant.events[-1]
    assert resume(calls).success


def test_a_session_without_a_follower_reads_no_types(make):
    _, calls = make(Session(follower=""))
    assert list(calls) == ["~/resume"]
