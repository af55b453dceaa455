"""The tool of a remote site in the viewer: where it was, and what the link says."""

from unittest.mock import MagicMock

import numpy as np
from fake_session import FakeSession, stage

from palpate.viewer.gauges import _remote
from palpate.viewer.tool import ToolDrawing


def made():
    balls = {}

    def ball(name, *_, **given):
        balls[name] = MagicMock(**{"position": np.zeros(3), "visible": True, **given})
        return balls[name]

    scene = MagicMock()
    scene.add_icosphere.side_effect = ball
    return ToolDrawing(scene, stage()), balls


def test_the_remote_tool_is_drawn_where_its_newest_packet_saw_it():
    drawing, balls = made()
    tick = FakeSession().latest()
    drawing.show(tick, {}, np.zeros(3))
    assert not balls["/remote"].visible
    tick["remote_received"], tick["p_WR"] = 5.0, [0.01, 0.02, 0.03]
    drawing.show(tick, {}, np.zeros(3))
    assert balls["/remote"].visible
    np.testing.assert_allclose(balls["/remote"].position, [0.01, 0.02, 0.03])


def test_the_read_outs_have_delays_link_and_both_forces():
    tick = FakeSession().latest()
    assert _remote(tick, "") == ""
    tick["remote_link"], tick["remote_age"], tick["remote_delay"] = 2.0, 0.105, 0.135
    tick["F_remote_W"], tick["F_T_W"], tick["remote_received"] = [0.0, 0.0, 1.25], [0.0, 0.0, 1.5], 812.0
    words = _remote(tick, "")
    for part in ("stands", "105 ms ago, here in 135 ms", "812", "1.25 / 1.50 N"):
        assert part in words
    tick["remote_link"] = 1.0
    assert "down: everything holds" in _remote(tick, "")
