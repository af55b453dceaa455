"""Your own mesh: load it, slide a tool over it, and compare two contact methods with the true surface.

A torus is written as STL in millimetres, like the output of a scanner, and read back. Its true surface is known, so
the error of every rendered force is known. You learn

* `palpate.Mesh.load` and `palpate.contact.render`, which runs a tool path through the contact code of the loop;
* why the default method uses a proxy: the paper's Algorithm 1 relies on collision normals, which tilt with the
  triangles at small depth, and point the wrong way once the centre of the tool is below the surface.

    python examples/03_own_mesh.py --sections 128 --figure normals.png
    python examples/03_own_mesh.py --mesh my.stl --unit mm          # forces only, without known truth
"""

import tempfile
from pathlib import Path
from typing import Literal

import numpy as np
import trimesh
import tyro

import palpate

RING, TUBE, RADIUS = 0.040, 0.015, 0.002  # radii of the torus and the spherical proxy region [m]
STIFFNESS, RATE = 500.0, 1000.0  # [N/m], [Hz]


def torus_truth(tips: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Signed distance to the true torus (n,) [m] and its outward normal (n, 3)."""
    ring = tips * [1, 1, 0]
    ring *= RING / np.linalg.norm(ring, axis=1, keepdims=True)
    out = tips - ring
    length = np.linalg.norm(out, axis=1)
    return length - TUBE, out / length[:, None]


def path(height: float, samples: int = 1500) -> np.ndarray:
    """Tool path (samples, 3): onto the tube, then along it with the tip `height` above the true surface [m]."""
    turn = np.linspace(0.0, 1.2, samples)  # around the ring [rad]
    lean = 0.6 + 0.5 * np.sin(3 * turn)  # around the tube [rad]
    reach = TUBE + height + np.maximum(0.0, 0.006 - height) * np.clip(1 - np.arange(samples) / 300, 0, 1)
    across = RING + reach * np.cos(lean)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), reach * np.sin(lean)])


def main(
    sections: int = 96,
    mesh: Path | None = None,
    unit: Literal["mm", "cm", "m", "in"] = "mm",
    figure: Path | None = None,
) -> None:
    """Slide at three depths with both methods; print the errors of the forces."""
    file = mesh or Path(tempfile.mkdtemp()) / "torus.stl"
    if mesh is None:
        trimesh.creation.torus(1e3 * RING, 1e3 * TUBE, sections, sections // 2).export(file)
    surface = palpate.Mesh.load(file, unit=unit)
    print(surface)
    if mesh is not None:
        top = surface.vertices[surface.vertices[:, 2].argmax()]
        down = top + np.outer(np.linspace(0.01, -0.002, 500), [0, 0, 1])
        felt = palpate.contact.render(surface, down, radius=RADIUS, stiffness=STIFFNESS)
        print(f"2 mm into its top: {np.linalg.norm(felt.force[-1]):.2f} N along {np.round(felt.normal[-1], 3)}")
        return

    print(
        "tip above surface | method     | direction error p50 / p95 / max | size error p95 | no force | p99 us/update"
    )
    errors = {}
    for height in (0.001, -0.001, -0.003):
        tips = path(height)
        distance, n = torus_truth(tips)
        steady = np.arange(len(tips)) >= 400
        for method in ("proxy", "paper-alg1"):
            felt = palpate.contact.render(surface, tips, radius=RADIUS, stiffness=STIFFNESS, method=method, rate=RATE)
            size = np.linalg.norm(felt.force, axis=1)
            touching = steady & (size > 0)
            cosine = np.einsum("ij,ij->i", felt.force, n)[touching] / size[touching]
            angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
            miss = 1e3 * np.abs(size - STIFFNESS * (RADIUS - distance))[steady]
            lost = float(1 - touching.sum() / steady.sum())
            angles = (
                " / ".join(f"{x:6.2f}" for x in np.percentile(angle, (50, 95, 100)))
                if len(angle)
                else "     no contact     "
            )
            print(
                f"{1e3 * height:+14.0f} mm | {method:<10} | {angles:>24} deg       | {np.percentile(miss, 95):8.0f} mN "
                f"| {lost:8.0%} | {1e6 * np.percentile(felt.latency, 99):6.1f}"
            )
            errors[f"{method}, {1e3 * height:+.0f} mm"] = angle

    if figure is not None:
        import matplotlib.pyplot as plt

        for name, angle in errors.items():
            plt.plot(angle, label=name)
        plt.xlabel("tick of the slide")
        plt.ylabel("angle between force and true normal [deg]")
        plt.yscale("symlog", linthresh=1)
        plt.legend()
        plt.savefig(figure, dpi=120)
        print(f"figure: {figure}")


if __name__ == "__main__":
    tyro.cli(main)
