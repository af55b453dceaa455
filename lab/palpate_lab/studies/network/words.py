"""Tables of ``palpate study network``."""

from __future__ import annotations

from rich.console import RenderableType
from rich.table import Table

from palpate_lab.studies.network.result import StudyResult


def _number(x: float | None, digits: int = 2) -> str:
    return "-" if x is None or x != x else f"{x:.{digits}f}"


def _percent(share: float | None) -> float | None:
    return None if share is None else 100.0 * share


def _table(title: str, columns: tuple[str, ...]) -> Table:
    out = Table(box=None, pad_edge=False, title=title, title_justify="left")
    for i, column in enumerate(columns):
        out.add_column(column, justify="left" if i < 2 else "right")
    return out


def tables(found: StudyResult) -> list[RenderableType]:
    """All tables for a terminal."""
    out = _table("networks by name", ("condition", "mode", "round trip, ms", "lost, %", "energy, mJ", "felt / true",
                 "force rms, N", "on tissue, N", "drift, mm", "outage told, ms", "palpation, s",
                 "longer, %"))  # fmt: skip
    for r in found["conditions"]:
        out.add_row(r["condition"], r["mode"], _number(r["round_trip_ms"], 0), _number(100 * r["lost"], 1),
                    _number(r["energy_mJ"]), _number(r["felt_over_true"], 3), _number(r["force_rms_N"], 3),
                    _number(r["force_site_N"]), _number(r["drift_mm"], 3), _number(r["outage_told_ms"], 0),
                    _number(r["palpation_s"], 1), _number(_percent(r["palpation_longer"]), 0))  # fmt: skip
    report: list[RenderableType] = [out]
    if found["random"]:
        report.append(_random(found))
    if found["moving"]:
        report.append(_moving(found))
    if found["alarms"]:
        report.append(_alarms(found))
    return report


def _alarms(found: StudyResult) -> Table:
    out = _table("outages, by the age of the newest packet", ("network", "hours", "false alarms an hour", "p99.9, ms",
                 "told beyond it, ms", "at 1 an hour possible, ms"))  # fmt: skip
    for r in found["alarms"]:
        out.add_row(r["condition"], f"{r['hours']:g}", _number(r["false_alarms_per_hour"]), _number(r["p999_ms"], 0),
                    _number(r["told_ms"], 0), _number(r["possible_ms"], 0))  # fmt: skip
    return out


def _random(found: StudyResult) -> Table:
    out = _table("random networks, worlds, hands and motions", ("mode", "runs", "lowest energy, mJ", "both ports, mJ",
                 "felt / true, 99 % of runs", "force rms, N", "on tissue, N", "kick, N", "drift, mm"))  # fmt: skip
    for r in found["random"]:
        felt, rms = r["felt_over_true"], r["force_rms_N"]
        out.add_row(r["mode"], str(r["runs"]), _number(r["energy_lowest_mJ"]), _number(r["energy_ports_lowest_mJ"]),
                    f"{felt[0]:.3f} to {felt[2]:.3f}" if felt else "-", f"{rms[1]:.3f}, at most {rms[2]:.3f}" if rms
                    else "-", _number(r["force_site_largest_N"]), _number(r["kick_largest_N"], 3),
                    _number(r["drift_largest_mm"], 3))  # fmt: skip
    return out


def _moving(found: StudyResult) -> Table:
    out = _table("worlds that move", ("case", "round trip, ms", "force rms, N", "energy, mJ", "kick, N", "drift, mm",
                 "right again after, s"))  # fmt: skip
    for r in found["moving"]:
        out.add_row(r["case"], _number(r["round_trip_ms"], 0), _number(r["force_rms_N"], 3), _number(r["energy_mJ"]),
                    _number(r["kick_N"], 3), _number(r["drift_mm"], 3), _number(r["relearnt_s"]))  # fmt: skip
    return out
