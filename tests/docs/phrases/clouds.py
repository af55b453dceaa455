"""Phrases of the pages on point clouds, scans, and the radius of the tool."""

from __future__ import annotations

from phrases.values import Result, Tie, percent, rows_by


def cases(found: Result) -> list[str]:
    def row(name: str, digits: int) -> str:
        r = found["cases"][name]
        return (
            f"| {name if name != 'breathing' else 'breathing, 4 mm in 4 s'} | {100 * r['force_error_rms']:.1f} % | "
            f"{100 * r['resting_error_rms']:.{digits}f} % | {100 * r['whole_error_rms']:.1f} % |"
        )

    return [row(name, 0 if name.endswith("m/s") else 1) for name in found["cases"]]


def organ(found: Result) -> list[str]:
    by = rows_by(found["organ"], "noise_m")
    none, little, large = by[0.0], by[3e-4], by[1e-3]
    return [
        f"differs from that of the mesh by {percent(none['difference_rms'])} % (rms) without noise, by "
        f"{percent(little['difference_rms'])} % and {little['difference_deg']:.1f} deg at 0.3 mm, and by "
        f"{percent(large['difference_rms'])} % and {large['difference_deg']:.1f} deg at 1 mm"
    ]


def delays(found: Result) -> list[str]:
    late = found["frame_to_force_ms"]
    return [
        f"| from the frame's arrival to the force, p50 / p99 | {late['p50']:.0f} / {late['p99']:.0f} ms |",
        f"| processor time of a frame | {found['frame_cpu_ms']:.0f} ms |",
        f"| missed ticks of 10,000, and of the bare loop | {found['missed']}, {found['control_missed']} |",
        f"| rms error of the force on a breathing surface | {100 * found['force_error_rms']:.1f} % |",
    ]


def scanned(found: Result) -> list[str]:
    error = found["error_m"]
    return [f"error of the surface | {1e3 * error['rms']:.2f} mm rms, {1e3 * error['max']:.1f} mm at most |"]


def room(found: Result) -> list[str]:
    return [f"distance of {found['points']:,} points from the surface | {1e3 * found['rms_m']:.1f} mm rms |"]


def features(found: Result) -> list[str]:
    """Ridges as wide as the radius, and half as wide."""
    rows = found["rows"]
    wide, narrow = ({f"{percent(r['kept'])} %" for r in rows if r["feature_mm"] * times == r["radius_mm"]}
                    for times in (1.0, 2.0))  # fmt: skip
    (same,), (half,) = wide, narrow
    return [f"at the full width {same} of the height is felt, at twice the width {half}"]


TIES = [
    Tie("sensing.md", "cloud", (cases, organ)),
    Tie("sensing.md", "cloud_times", (delays,)),
    Tie("scan.md", "scan", (scanned,)),
    Tie("scan.md", "scan_room", (room,)),
    Tie("meshes.md", "radius", (features,)),
]
