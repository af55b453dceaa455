"""The list of contacts: pairs of sphere and object with forces and duration."""

import synthetic_run

from palpate.report import touches


def test_contact_pairs_are_sorted_by_force():
    ticks = synthetic_run.run(1.0)
    ticks["contacts"] = 0
    ticks["contacts"][100:300] = 2
    ticks["touch_sphere"][100:300, :2] = [3, 0]
    ticks["touch_object"][100:300, :2] = [1, 0]
    ticks["touch_force"][100:300, :2] = [0.5, 0.25]
    ticks["touch_force"][150, 1] = 2.0
    page = touches.table(ticks, ["tip"], ["liver", "<b>"], 1000.0)
    assert page.index("tip × liver") < page.index("3 × &lt;b&gt;")
    assert "2.000 N" in page
    assert page.count("0.20 s") == 2


def test_run_without_contact_is_stated():
    ticks = synthetic_run.run(0.1)
    ticks["contacts"] = 0
    assert touches.table(ticks, ["tip"], ["floor"], 1000.0) == "<p>Nothing was touched.</p>"
