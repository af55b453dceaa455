"""Phrases of the pages on point clouds, scans, and the radius of the tool."""

from __future__ import annotations

import math

from phrases.values import Result, Tie, control, percent, rows_by


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


def scan_time(found: Result) -> list[str]:
    return [f"| the same: time on two cores ({control('scan_times')}) | {found['seconds']:.1f} s |"]


def room(found: Result) -> list[str]:
    return [f"distance of {found['points']:,} points from the surface | {1e3 * found['rms_m']:.1f} mm rms |"]


def features(found: Result) -> list[str]:
    """Ridges as wide as the radius, and half as wide."""
    rows = found["rows"]
    wide, narrow = (sorted({round(100.0 * r["kept"]) for r in rows if r["feature_mm"] * times == r["radius_mm"]})
                    for times in (1.0, 2.0))  # fmt: skip
    assert len(wide) == 1
    return [f"at the full width {wide[0]} % of the height is felt, at twice the width {narrow[0]} to {narrow[-1]} %"]


def noisy(found: Result) -> list[str]:
    """On the widest ridge: a small sphere follows every vertex, on many peaks a sphere turns by sqrt(2 noise / r)."""
    widest = max(row["feature_mm"] for row in found["rows"])
    rows = rows_by((r for r in found["rows"] if r["feature_mm"] == widest), "radius_mm", "noise_mm")
    spacing = 0.5  # of the vertices [mm]
    (times,) = {f"{math.radians(rows[r, 0.05]['direction_deg']) * spacing / 0.05:.1f}" for r in (0.5, 1.0)}
    for (radius, noise), row in rows.items():
        if noise >= 0.2:
            turn = math.degrees(math.sqrt(2.0 * noise / radius))
            assert turn > 45.0 or abs(row["direction_deg"] / turn - 1.0) < 0.2, (radius, noise)
    return [f"{times} times the noise over the spacing", "(95 %, measured within a fifth of it up to 45 deg)"]


def smoothed(found: Result) -> list[str]:
    little, much = found["meshes"]
    words = f"(sphere of {found['sphere_mm']:g} mm, tool of {little['radius_mm']:g} mm"
    return [
        f"At {little['spacing_mm']:.2f} mm of spacing and {little['noise_mm']:g} mm of noise, 95 % of the directions "
        f"are then within {little['smoothed_deg']:.1f} instead of {little['direction_deg']:.1f} deg {words}; "
        f"{much['noise_mm']:g} mm of noise: {much['smoothed_deg']:.1f} instead of {much['direction_deg']:.1f}"
    ]


def of_clouds(found: Result) -> list[str]:
    rows = found["clouds"]
    radii, (spacing,), (little, much) = (
        sorted({row[key] for row in rows}) for key in ("radius_mm", "spacing_mm", "noise_mm")
    )
    off = {noise: [r["direction_deg"] for r in rows if r["noise_mm"] == noise] for noise in (little, much)}
    return [
        f"on a sphere of {found['sphere_mm']:g} mm with points every {spacing:g} mm, with radii from {min(radii):g} to "
        f"{max(radii):g} mm, it is off by {min(off[little]):.1f} to {max(off[little]):.1f} deg at {little:g} mm of "
        f"noise and by {min(off[much]):.1f} to {max(off[much]):.1f} deg at {much:g} mm (95 %"
    ]


def filtered(found: Result) -> list[str]:
    """Caps of 5 and 10 N/s on the widest ridge; with each, radii of 1, 2 and 4 mm leave the smallest errors."""
    rows = rows_by(found["rows"], "radius_mm")
    less = {r: [percent(1.0 - row["filtered_mN"][cap] / row["error_mN"]) for cap in ("10", "5")]
            for r, row in rows.items()}  # fmt: skip
    for cap in ("5", "10"):
        assert sorted(sorted(rows, key=lambda r: rows[r]["filtered_mN"][cap])[:3]) == [1.0, 2.0, 4.0]
    middle = sorted((*less[1.0], *less[2.0]), key=int)
    return [
        f"5 to 10 N/s reduces the error of a sphere of 0.5 mm by {less[0.5][0]} to {less[0.5][1]} %, and of 1 or 2 mm "
        f"by {middle[0]} to {middle[-1]} %",
        f"at 8 mm and 5 N/s the error grows by {-int(less[8.0][1])} %",
    ]


def turned(found: Result) -> list[str]:
    (degrees,) = {f"{row['direction_deg']:.0f}" for row in found["rows"]
                  if (row["radius_mm"], row["noise_mm"]) == (2.0, 0.05) and row["feature_mm"] > 8.0}  # fmt: skip
    return [f"turn the force of a 2 mm sphere by {degrees} degrees (95 %, `palpate study radius`)"]


TIES = [
    Tie("contact.md", "radius", (turned,)),
    Tie("sensing.md", "cloud", (cases, organ)),
    Tie("sensing.md", "cloud_times", (delays,)),
    Tie("scan.md", "scan", (scanned,)),
    Tie("scan.md", "scan_times", (scan_time,)),
    Tie("scan.md", "scan_room", (room,)),
    Tie("meshes.md", "radius", (features, noisy)),
    Tie("meshes.md", "radius_filter", (filtered,)),
    Tie("meshes.md", "spheres", (smoothed, of_clouds)),
]
