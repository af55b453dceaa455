"""Terminal output of ``palpate study drift``: drift by form of model, with published values."""

from __future__ import annotations

from rich.table import Table

from palpate_lab.studies.drift.result import StudyResult
from palpate_lab.studies.drift.work import FORMS, STAYS


def table(found: StudyResult) -> Table:
    """Table of the drift by form of model, with published values."""
    title = f"tip drift within {found['released_s']:g} s of letting go, simulated, {found['releases']} poses [mm]"
    shown = Table(title=title, title_justify="left")
    heads = ("arm", "plant", "model", "mean", "median", "95 %", "stays", "published", "wrong by [N m]")
    for head in heads:
        shown.add_column(head, justify="left" if head in heads[:3] else "right", no_wrap=True)
    for k, row in enumerate(found["rows"]):
        first = k % len(FORMS) == 0
        real = "/".join(f"{x:g}" for x in found["published_mm"].get(row["model"], ()))
        wrong = " ".join(f"{x:.3f}" for x in row["torque_error_Nm"][:3])
        shown.add_row(row["arm"] * first, row["plant"] * first, row["model"], f"{row['mean_mm']:.2f}",
                      f"{row['median_mm']:.2f}", f"{row['p95_mm']:.2f}", f"{100 * row['stays']:.0f} %", real, wrong,
                      end_section=(k + 1) % len(FORMS) == 0)  # fmt: skip
    shown.caption = (
        f"stays: moved less than {STAYS:g} mm; published: on a real arm (Lin et al. 2019), mean/median/95 %; wrong by: "
        "rms error of the holding torques of joints 1 to 3."
    )
    return shown
