"""Phrases of the pages on ROS 2, the viewer and grids."""

from __future__ import annotations

from phrases.values import Result, Tie


def latency(found: Result) -> list[str]:
    assert found["lost"] == 0
    rows = (("from state to wrench", "latency"), ("bare echo, round trip", "echo"))
    return [
        *(f"| {words} | {found[f'{key}_p50_us']:.0f} us | {found[f'{key}_p99_us']:.0f} us |" for words, key in rows),
        f"Four simulated arms at 1 kHz took {found['sim_cores']:.2f} cores",
    ]


def discovery(found: Result) -> list[str]:
    pose, command = found["pose_p95_s"], found["command_p95_s"]
    slow = max(found["control_pose_p95_s"], found["control_command_p95_s"])
    return [
        f"Of {found['starts']} clients 95 % had the first `measured_cp` within {pose:.2f} s and the answer to their "
        f"first command within {command:.2f} s, beside the bare node within {slow:.2f} s"
    ]


def freed(found: Result) -> list[str]:
    assert not any(row["late"] for row in found["faults"])
    return [
        f"| {row['fault']} | {1e3 * row['median_s']:.1f} ms | {1e3 * row['worst_s']:.1f} ms |"
        for row in found["faults"]
    ]  # fmt: skip


def pictures(found: Result) -> list[str]:
    one, other = found["rows"]
    rates = [f"{row['fps']:.1f} ({row['fps_p50']:.1f}), {row['control']['fps']:.0f}" for row in (one, other)]
    drawing = [f"{r['processor_ms_per_frame']['GPU']:.0f} ms, {r['control']['processor_ms_per_frame']:.0f} ms"
               for r in (one, other)]  # fmt: skip
    page = [f"{row['processor_ms_per_frame']['renderer']:.0f} ms" for row in (one, other)]
    size = [f"{row['drawn'][0]} x {row['drawn'][1]}, {row['quality']}" for row in (one, other)]
    return [
        f"of 1200 x 700 pixels | {size[0]} | {size[1]} |",
        f"| triangles, draw calls | {one['triangles']:,}, {one['draw_calls']} | "
        f"{other['triangles']:,}, {other['draw_calls']} |",
        f"| frames/s (their median), and of an empty page | {rates[0]} | {rates[1]} |",
        f"| processor time to draw a frame, and of an empty page | {drawing[0]} | {drawing[1]} |",
        f"| processor time of the page a frame | {page[0]} | {page[1]} |",
    ]  # fmt: skip


def growing(found: Result) -> list[str]:
    rows = []
    for one in found["axes"]:
        for key, values in one["figures"].items():
            name, _, unit = key.rpartition("_")
            if not name.endswith("p99"):  # of a machine with other work
                figures = ", ".join(f"{value:.3g}" for value in values)
                words = f"{name.replace('_', ' ')} [{unit.replace('mb', 'MB')}]"
                rows.append(f"| `{one['axis']}` | {words} | {figures} | {one['exponents'][key]:.2f} |")
    return rows


def silences(found: Result) -> list[str]:
    """The rows of the page on Haply: times until zero, at the motors only while the service takes messages."""
    assert all(one["named"] == one["cases"] for one in found["faults"])
    rows, words = [], {
        "hang": "hangs", "late": "answers 20 ms late, and a message acts when it arrives", "malformed": "nonsense",
        "slow": "takes 20 ms for each message, one after the other", "ebrake": "emergency brake",
        "uncalibrated": "not calibrated", "unplug": "unplugged", "disconnect": "connection broken",
    }  # fmt: skip
    for one in found["faults"]:
        name = words.get(one["fault"], one["fault"])
        times = [f"{one[f'rendered_{key}_ms']:.1f}" for key in ("p50", "max")]
        if one["motors_p50_ms"] is not None:
            motors = [f"{one[f'motors_{key}_ms']:.1f}" for key in ("p50", "max")]
            rows.append(f"| {name} | {', '.join(times)} | {', '.join(motors)} | {one['bound_ms']:.1f} |")
        else:
            rows.append(f"| {name} | {', '.join(times)} |")
    return rows


def grid(found: Result) -> list[str]:
    x, y, z = found["nodes"]
    near, box = (tuple(found[f"error_{where}_{what}_m"] for what in ("p99", "max")) for where in ("near", "box"))
    return [
        f"| {x} x {y} x {z} | {1e3 * found['spacing_m']:.2f} mm | {found['build_s']:.0f} s | "
        f"{1e-9 * found['peak_memory_bytes']:.2f} GB | {1e6 * near[0]:.1f} and {1e6 * near[1]:.0f} um | "
        f"{1e6 * box[0]:.1f} and {1e6 * box[1]:.0f} um |"
    ]  # fmt: skip


TIES = [
    Tie("ros2-network.md", "ros", (latency,)),
    Tie("ros2-network.md", "ros_discovery", (discovery,)),
    Tie("ros2-real-arm.md", "ros_faults", (freed,)),
    Tie("haply.md", "soak_haply", (silences,)),
    Tie("viewer.md", "viewer", (pictures,)),
    Tie("growth.md", "growth", (growing,)),
    Tie("guidance.md", "grid", (grid,)),
]
