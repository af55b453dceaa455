"""Phrases of the pages on registration."""

from __future__ import annotations

import math

from palpate.base.arrays.intervals import proportion
from phrases.values import Result, Tie, control, least, most


def of(rows: list[Result], key: str) -> str:
    return f"{sum(round(row[key] * row['trials']) for row in rows)} of {sum(row['trials'] for row in rows)}"


def registration_markers(found: Result) -> list[str]:
    both, (estimated, stated) = found["predicted"].values(), found["wrong_marker"].values()
    return [
        "isotropic; anisotropic | " + "; ".join(f"{1e3 * one['largest_p95_m']:.3f} mm" for one in both),
        "isotropic; anisotropic | " + "; ".join(f"{100 * one['largest_error']:.1f} %" for one in both),
        f"unknown correspondence found | {of(list(found['unknown'].values()), 'right')}",
        f"FLE estimated; stated | {of([estimated], 'found')}; {of([stated], 'found')}",
        f"false alarms, FLE estimated; stated | {100 * estimated['false_alarms']:.1f} %; "
        f"{100 * stated['false_alarms']:.1f} %",
    ]


def count(text: str) -> tuple[int, int]:
    """The numbers of "k of n"."""
    k, n = (int(word) for word in text.split(" of "))
    return k, n


def registration_limits(found: Result) -> list[str]:
    wrong = sum(one["wrong"] for one in found["surface"].values())
    rough, none = (found["surface"][k] for k in ("rough", "none"))
    marker = found["wrong_marker"]
    assert count(of([marker["estimated"]], "found")) == count(of([marker["stated"]], "found"))
    required = {
        "correspondence": (count(of(list(found["unknown"].values()), "right")), 0.99),
        "wrong marker": (count(of([marker["stated"]], "found")), 0.99),
        "liver": (count(of([rough], "converged")), 0.95),
        "told as wrong": ((wrong, wrong), 0.99),
    }
    proved = [name for name, ((k, n), share) in required.items() if proportion(k / n, n)[0] >= share]
    alarms = [(round(one["false_alarms"] * one["trials"]), one["trials"]) for one in marker.values()]
    assert proved == ["correspondence"]
    assert min(proportion(k / n, n)[1] for k, n in alarms) > 0.01
    felt, places = (
        round(found["chain"]["felt_within_1mm"] * 20 * found["chain"]["trials"]),
        20 * found["chain"]["trials"],
    )
    assert felt < places
    return [
        *(f"{name} {least(*trials)}" for name, (trials, _) in required.items()),
        f"without a start {least(*count(of([none], 'converged')))}",
        f"trusted {least(*count(trusted(found)))}",
        f"Of the required shares {len(proved)} is proved, {proved[0]}",
        f"{wrong} of {wrong} is not 99 %",
        f"False alarms are at most {most(*alarms[0])} and {most(*alarms[1])} ({alarms[0][1]} sets each)",
    ]


def trusted(found: Result) -> str:
    """Right answers of all kinds of views, and those of them that were trusted."""
    rows = [(round(one["converged"] * one["trials"]), one["right_trusted"])
            for one in found["surface"].values() if one["converged"]]  # fmt: skip
    return f"{sum(round(right * share) for right, share in rows)} of {sum(right for right, _ in rows)}"


def registration_surfaces(found: Result) -> list[str]:
    rough, none, arm, beside = *(found["surface"][k] for k in ("rough", "none")), *found["handeye"].values()
    wrong = sum(one["wrong"] for one in found["surface"].values())
    assert found["wrong_told"] == 1.0
    return [
        f"from +-30 deg and +-30 mm | {of([rough], 'converged')}",
        f"rms error of its points, 95 % | {1e3 * rough['p95_m']:.2f} mm",
        f"right answers trusted | {trusted(found)}",
        f"without a start | {of([none], 'converged')}",
        f"other organ) | {wrong} of {wrong}",
        f"on the arm | {1e3 * arm['position_p95_m']:.2f} mm, {math.degrees(arm['rotation_p95_rad']):.2f} deg",
        f"beside the arm | {1e3 * beside['position_p95_m']:.2f} mm, {math.degrees(beside['rotation_p95_rad']):.2f} deg",
    ]


def registration_chain(found: Result) -> list[str]:
    touched, chain = found["touched"], found["chain"]
    return [
        f"{touched['trials']} runs | {1e3 * touched['simulated_m']:.2f} mm rms, "
        f"predicted {1e3 * touched['predicted_m']:.2f} mm",
        f"median; largest | {1e3 * chain['tip_median_m']:.2f} mm; {1e3 * chain['tip_largest_m']:.1f} mm",
        f"within 1 mm of the surface | {100 * chain['felt_within_1mm']:.1f} % of {20 * chain['trials']} places",
    ]


def covariances(found: Result) -> list[str]:
    surfaces = [one["mean_nees"] for one in found["surface"].values() if one["mean_nees"]]
    handeye = [one["mean_nees"] for one in found["handeye"].values()]
    assert max(abs(nees / 6.0 - 1.0) for nees in (*surfaces, *handeye)) < 0.25
    return [
        f"the mean squared error over the covariance is {min(surfaces):.1f} to {max(surfaces):.1f} for surfaces and "
        f"{min(handeye):.1f} to {max(handeye):.1f} for hand-eye"
    ]


def registration_real(found: Result) -> list[str]:
    real = found["real"]
    assert real["trusted"]
    return [
        f"real Kinect pair, against small_gicp's GICP | {1e3 * real['from_small_gicp_m']:.1f} mm, "
        f"{math.degrees(real['from_small_gicp_rad']):.2f} deg apart",
        f"whose points move by {1e3 * real['moved_m']:.0f} mm rms; the noise of its averaged points is "
        f"{1e3 * real['noise_m']:.0f} mm",
    ]


def session_time(found: Result) -> list[str]:
    return [
        f"`palpate register session scenes/registration.yaml`, whole ({control('session')}) | "
        f"{found['processor_s']:.1f} s of processor time |"
    ]


def sessions(found: Result) -> list[str]:
    session = found["session"]
    right, wrong = session["right"], {kind: one for kind, one in session.items() if kind != "right"}
    (trials,) = {one["trials"] for one in wrong.values()}

    def told(key: str) -> str:
        return f"{round(right[key] * right['trials'])} of {right['trials']}"

    met = round((1.0 - right["told"]) * right["trials"])
    assert all(one["told"] == 1.0 for one in wrong.values())
    return [
        f"with the accuracy of 1 mm met | {met} of {right['trials']} |",
        f"every target within the error stated with 95 % | {told('right')}",
        f"rms | {1e3 * right['error_m']:.2f} mm, predicted {1e3 * right['predicted_m']:.2f} mm |",
        f"simulated time of the hand, means | {right['touches']:.1f}; {right['seconds']:.0f} s |",
        f"organ moved by 5 mm after three touches | {trials} of {trials} |",
        f"mirrored targets; scan of another organ | {trials} of {trials} each |",
        f"right registrations passed | {told('check_passed')} |",
        f"the same moved by 3 mm failed | {told('off_failed')} |",
    ]


def session_limits(found: Result) -> list[str]:
    session = found["session"]
    n = session["right"]["trials"]
    (few,) = {one["trials"] for kind, one in session.items() if kind != "right"}
    held = round(session["right"]["right"] * n)
    assert proportion(held / n, n)[0] < 0.95
    return [
        f"{held} of {n} is at least {least(held, n)}, which does not prove 95 %",
        f"{n} of {n} at least {least(n, n)}",
        f"{few} of {few} at least {least(few, few)}",
    ]


def session_small_motion(found: Result) -> list[str]:
    seen, alone = (
        next(r for r in found["rows"] if (r["estimate"], r["form"]) == ("session", form))
        for form in ("nudged", "alone")
    )
    low, high = proportion(alone["told"], alone["trials"])
    least, _ = proportion(seen["told"], seen["trials"])
    return [
        f"in {seen['told'] * seen['trials']:.0f} of {seen['trials']} sessions (at least {100 * least:.1f} %)",
        f"in {100 * alone['told']:.0f} % of {alone['trials']} sessions ({100 * low:.0f} to {100 * high:.0f} %)",
        f"would tell {100 * alone['possible']:.0f} %",
        f"then holds {100 * alone['cover']:.0f} % of the targets",
    ]


TIES = [
    Tie("registration-session.md", "registration", (sessions, session_limits)),
    Tie("registration-session.md", "session", (session_time,)),
    Tie("registration-session.md", "coverage", (session_small_motion,)),
    Tie("registration.md", "registration", (registration_markers, registration_surfaces, registration_chain)),
    Tie("registration.md", "registration", (registration_limits,)),
    Tie("registration.md", "registration", (covariances, registration_real)),
]
