"""Phrases of the pages on control laws, gravity, dynamics and the estimated force."""

from __future__ import annotations

from palpate_lab.studies.laws.work import Outcome, bandwidth
from phrases.values import Maker, Result, Tie, kept, percent, rows_by


def limits(found: Result) -> list[str]:
    outcomes = [Outcome(**row) for row in found["outcomes"]]

    def limit(law: str, K: float = 400.0, hand: str = "fast") -> str:
        hertz = bandwidth(outcomes, law, K, hand)
        return f"{hertz:.{1 if hertz >= 1.0 else 2}f}"

    assert limit("impedance") == limit("stiffness")
    return [
        f"so the error passes a tenth at {limit('stiffness')} Hz with a fast hand and at "
        f"{limit('stiffness', hand='slow')} Hz with a slow one",
        f"it grows with the square root of K, {limit('stiffness', 50.0)} Hz for 50 N/m and "
        f"{limit('stiffness', 2000.0)} Hz for 2000 N/m",
        f"limit is {limit('impedance-shaped')} Hz at 400 N/m, with admittance of the same virtual mass "
        f"{limit('admittance')} Hz",
    ]


def friction(found: Result) -> list[str]:
    rows = rows_by((r for r in found["outcomes"] if (r["K_N_per_m"], r["model_scale"]) == (400.0, 1.0)),
                   "law", "f_Hz", "hand")  # fmt: skip
    stiffness, admittance = (rows[law, 0.3, "fast"]["impedance_error"] for law in ("stiffness", "admittance"))
    assert rows["stiffness", 5.0, "fast"]["felt_N_per_m"] < 0.0, "at 5 Hz the arm, and no spring"
    return [
        f"The thin lines add friction: {percent(stiffness)} % of the force",
        f"Admittance removes friction as well ({percent(admittance)} % remains at 0.3 Hz)",
    ]


def simulated_force(found: Result) -> list[str]:
    one = found["simulated"]
    x, y, z = (f"{100 * error:.1f}" for error in one["nrmse_axis"])
    return [f"over the largest force, {100 * one['nrmse']:.1f} %;", f"x {x} %, y {y} %, z {z} %"]


def weight(found: Result) -> list[str]:
    one = found["weight"]
    low, high = (f"{1e3 * mass:.0f}" for mass in one["interval_kg"])
    narrow, wide = (f"{1e3 * one['mass_by_filter_kg'][cutoff]:.0f}" for cutoff in ("1", "4"))
    first, second = (f"{1e3 * mass:.0f}" for mass in one["mass_by_tare_kg"])
    return [
        f"**{1e3 * one['mass_kg']:.0f} g** ({percent(one['error'], '+')} %), standard deviation "
        f"{1e3 * one['deviation_kg']:.0f} g",
        f"recordings {one['degrees_of_freedom']:.1f} degrees of freedom, "
        f"so Student's 95 % interval is {low} to {high} g",
        f"{narrow} g and {wide} g with a filter of 1 Hz or 4 Hz instead of 2, {first} g with only the first tare, "
        f"{second} g with only the second",
    ]


def dynamics(arm: str) -> Maker:
    def table(found: Result) -> list[str]:
        test = found["test"]
        return [
            f"| {arm}, {cutoff:g} Hz | " + " | ".join(f"{value:.3f}".removeprefix("0") for value in row) + " |"
            for cutoff, row in zip(test["cutoffs_Hz"], test["relative_rms_at"], strict=True)
        ]

    return table


def repeated(found: Result) -> list[str]:
    (rows,), (none,) = found["train"]["repeated_rows"], kept("dynamics_psm")["result"]["train"]["repeated_rows"]
    assert none == 0
    return [f"({rows} in the MTM's training recording, none in the PSM's)"]


def r2(found: Result, key: str = "test") -> str:
    return " ".join(f"{value:.2f}".removeprefix("0") for value in found[key]["r2"])


PUBLISHED = {
    "mtm": (0.077, 0.149, 0.170, 0.223, 0.280, 0.234, 0.340),
    "psm": (0.093, 0.178, 0.191, 0.134, 0.239, 0.213, 0.264),
}
"""Relative RMS of the drives by Wang, Gondokaryono, Munawar and Fischer (IROS 2019)."""


def than_published(_: Result) -> list[str]:
    """The bands in which joints of either arm are worse than published."""

    def worse(arm: str, cutoff: float) -> dict[int, str]:
        test = kept(f"dynamics_{arm}")["result"]["test"]
        ours = test["relative_rms_at"][test["cutoffs_Hz"].index(cutoff)]
        pairs = enumerate(zip(ours, PUBLISHED[arm], strict=True), start=1)
        return {joint: percent(mine / theirs - 1.0) for joint, (mine, theirs) in pairs if mine > theirs}

    assert not any(worse(arm, cutoff) for arm in PUBLISHED for cutoff in (2.0, 3.0))
    ((joint, more),), psm = worse("mtm", 5.0).items(), worse("psm", 5.0)
    tables = [
        f"| {arm.upper()}, published | {' | '.join(f'{one:.3f}'.removeprefix('0') for one in values)} |"
        for arm, values in PUBLISHED.items()
    ]
    return [
        *tables,
        "At 2 and 3 Hz no joint of either arm is worse than published; at 5 Hz the MTM's joint "
        f"{joint} (by {more} %) and the PSM's joints {' and '.join(map(str, psm))} ({' and '.join(psm.values())} %)",
    ]


def gravity(arm: str) -> Maker:
    return lambda found: [f"| {arm} | {r2(found)} | {r2(found, 'test_directed')} |"]


def dvrk_form(arm: str) -> Maker:
    return lambda found: [rf"| {arm} \|.*\| {r2(found)} |"]


def fit_times(_: Result) -> list[str]:
    every = [kept(f"gravity_{number}") for number in ("34863", "31519", "28247")]
    took, control = ([f(one) for one in every] for f in (lambda one: one["result"]["seconds"], numpy_s))
    return [
        f"A fit takes {min(took):.1f} to {max(took):.1f} s on one core "
        f"(an import of numpy: {min(control):.2f} to {max(control):.2f} s)"
    ]


def numpy_s(one: Result) -> float:
    return float(one["control_numpy_import_s"])


def few_poses(arm: str, number: str) -> Maker:
    """RMS of the joints with 40 poses over that with 160."""

    def sentence(found: Result) -> list[str]:
        many = kept(f"gravity_{number}")["result"]["test"]["rms_Nm"]
        more = [few / one - 1.0 for few, one in zip(found["test"]["rms_Nm"], many, strict=True)]
        return [f"{arm}: {', '.join(percent(one, '+') for one in more)} %"]

    return sentence


def drifted(row: Result) -> str:
    """Mean, median and 95 % in mm; to a tenth below 10 mm."""
    values = (row[f"{key}_mm"] for key in ("mean", "median", "p95"))
    return " / ".join(f"{value:.{0 if value >= 10.0 else 1}f}" for value in values)


def drift(found: Result) -> list[str]:
    by = rows_by(found["rows"], "arm", "plant", "model")
    phrases = []
    for one in found["arms"]:
        models = ("paper", "gravity+springs", "dvrk", "potential")
        cells = [drifted(by[one["arm"], "as identified", model]) for model in models]
        phrases.append(f"| {' | '.join(cells)} |")
    return phrases


def published_drift(found: Result) -> list[str]:
    published = found["published_mm"]
    shares = [row["mean_mm"] / published[row["model"]][0] for row in found["rows"]
              if row["plant"] == "as identified" and row["model"] in ("paper", "dvrk")]  # fmt: skip
    return [f"fall on average {min(shares):.1f} to {max(shares):.0f} times as far as the published arm did"]


def dry_friction(found: Result) -> list[str]:
    joints = list(zip(*(one["friction_Nm"] for one in found["arms"]), strict=True))
    first, second, third = (f"{min(joint):.3f} to {max(joint):.3f}" for joint in joints[:3])
    return [
        f"friction alone ({second} N m at joint 2) then remains",
        f"dry friction of every joint ({first}, {second} and {third} N m at joints 1 to 3)",
    ]


def rough_drift(found: Result) -> list[str]:
    by = rows_by((r for r in found["rows"] if r["model"] == "potential"), "arm", "plant")
    first, second, third = (by[one["arm"], "rough"] for one in found["arms"])
    return [
        f"There `potential` comes to {drifted(first)}, {drifted(second)} and {drifted(third)} mm",
    ]


TIES = [
    Tie("torque.md", "laws", (limits, friction)),
    Tie("dynamics.md", "force", (simulated_force, weight)),
    Tie("dynamics.md", "dynamics_mtm", (dynamics("MTM"), repeated)),
    Tie("dynamics.md", "dynamics_psm", (dynamics("PSM"), than_published)),
    Tie("calibrate.md", "gravity_34863", (gravity("MTML 34863"), fit_times)),
    Tie("calibrate.md", "gravity_31519", (gravity("MTMR 31519"),)),
    Tie("calibrate.md", "gravity_28247", (gravity("MTMR 28247"),)),
    Tie("calibrate.md", "gravity_34863_few", (few_poses("MTML 34863", "34863"),)),
    Tie("calibrate.md", "gravity_28247_few", (few_poses("MTMR 28247", "28247"),)),
    Tie("calibrate.md", "gravity_34863_dvrk", (dvrk_form("MTML 34863"),)),
    Tie("calibrate.md", "gravity_31519_dvrk", (dvrk_form("MTMR 31519"),)),
    Tie("calibrate.md", "gravity_28247_dvrk", (dvrk_form("MTMR 28247"),)),
    Tie("calibrate.md", "drift", (drift, published_drift, rough_drift, dry_friction)),
]
