"""The summary of a run that arrives in parts, against numbers written down by hand."""

import numpy as np
import pytest

from palpate.record.ticks import TICK_DOUBLES, Ticks, as_ticks
from palpate.session.summary import Totals, summarise

NO_CYCLES = {"cycle_p50_us": 0.0, "cycle_p99_us": 0.0, "cycle_p999_us": 0.0, "cycle_max_us": 0.0}


def ticks(n: int, **columns) -> Ticks:
    out = as_ticks(np.zeros((n, TICK_DOUBLES)))
    for name, values in columns.items():
        out[name] = values
    return out


def parts() -> list[Ticks]:
    """Two parts and an empty one between them, each with the extremes of other columns."""
    first = ticks(
        3,
        F_H_L=[[3.0, 4.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        contacts=[2, 0, 0],
        F_touch_W=[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -0.5]],
        depth=[0.001, 0.0, 0.0],
        energy_port=[0.5, -2.0, 1.0],
        energy_lent=[0.1, 0.2, 0.3],
        v_LH=[[0.0, 0.3, 0.4], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]],
        cycle_us=[4.0, np.nan, 8.0],
    )
    second = ticks(
        2,
        F_H_L=[[0.0, 0.0, 2.0], [0.0, 0.0, 9.0]],
        contacts=[1, 0],
        depth=[0.004, 0.0],
        energy_port=[3.0, 2.5],
        energy_lent=[0.3, 0.7],
        v_LH=[[0.2, 0.0, 0.0], [0.0, 0.0, 0.0]],
        cycle_us=[6.0, np.inf],
    )
    return [first, ticks(0), second]


def test_parts_add_up_to_the_run():
    totals = Totals(500.0)
    for part in parts():
        totals.add(part)
    found = totals.summary()
    assert totals.ticks == found.ticks == 5
    assert found.duration_s == 0.01
    assert found.peak_force_N == 9.0
    assert found.mean_force_N == pytest.approx((5.0 + 1.0 + 2.0) / 3.0), (
        "touching: by contacts, or by a driven follower"
    )
    assert found.contact_s == 0.006
    assert found.max_penetration_m == 0.004
    assert (found.energy_J, found.energy_min_J, found.energy_lent_J) == (2.5, -2.0, 0.7)
    assert found.peak_speed_m_s == pytest.approx(0.5)
    assert (found.cycle_p50_us, found.cycle_max_us) == (6.0, 8.0), "ticks without a time are left out"
    assert found.cycle_p99_us == pytest.approx(6.0 + 0.98 * 2.0)
    assert found.cycle_p999_us == pytest.approx(6.0 + 0.998 * 2.0)
    assert summarise(np.concatenate(parts()), 500.0) == found


def test_nothing_recorded_is_zero_and_not_an_error():
    found = Totals(1000.0).summary()
    assert (found.ticks, found.duration_s, found.mean_force_N, found.contact_s) == (0, 0.0, 0.0, 0.0)
    assert {key: getattr(found, key) for key in NO_CYCLES} == NO_CYCLES
    assert not found.realtime
    assert not found.interrupted
    assert (found.realtime_factor, found.missed_ticks, found.scheduler) == (0.0, 0, "")


def test_a_positive_energy_has_its_lowest_value_at_the_start():
    found = summarise(ticks(2, energy_port=[0.25, 0.5]), 1000.0)
    assert (found.energy_J, found.energy_min_J) == (0.5, 0.0)
    assert found.mean_force_N == 0.0


@pytest.mark.parametrize(("realtime", "scheduler"), [(True, "SCHED_FIFO 80"), (False, "")])
def test_scheduler_is_that_of_a_real_time_run(realtime, scheduler):
    timing = {"missed_ticks": 7, "scheduler": "SCHED_FIFO 80"}
    found = summarise(ticks(1), 1000.0, timing=timing, realtime=realtime, faults=("stale",))
    assert (found.missed_ticks, found.scheduler, found.realtime, found.faults) == (7, scheduler, realtime, ("stale",))


def test_beyond_the_bound_every_second_time_is_kept_and_the_longest_is_known(monkeypatch):
    """Three parts of 4, of which 8 may be kept: 1 to 12 become 1, 3, 5 ... 11, and then every second of 13 to 16."""
    monkeypatch.setattr("palpate.session.samples.MOST", 8)
    totals = Totals(1000.0)
    for start in (1.0, 5.0, 9.0, 13.0):
        totals.add(ticks(4, cycle_us=np.arange(start, start + 4.0)))
    found, kept = totals.summary(), [1.0, 3.0, 5.0, 7.0, 9.0, 11.0, 13.0, 15.0]
    assert (found.cycle_p50_us, found.cycle_max_us) == (np.median(kept), 16.0)
    assert found.cycle_p99_us == pytest.approx(np.percentile(kept, 99))
    totals.add(ticks(4, cycle_us=np.arange(17.0, 21.0)))  # 17 and 19 are the ninth and tenth: now every fourth
    assert totals.summary().cycle_p50_us == np.median([1.0, 5.0, 9.0, 13.0, 17.0])
    totals.add(ticks(4, cycle_us=np.arange(21.0, 25.0)))
    assert totals.summary().cycle_p50_us == np.median([1.0, 5.0, 9.0, 13.0, 17.0, 21.0])
