"""A block of the core's elements under prescribed homogeneous strains, and the moduli that it shows."""

from __future__ import annotations

import numpy as np
import soft_bodies

YOUNG, CELL = 5000.0, 0.01
SHEAR = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
HYDROSTATIC, OEDOMETRIC = np.eye(3), np.diag([1.0, 0.0, 0.0])


class Strained:
    """A block under prescribed homogeneous strain. Its stress is read from the speeds that the forces cause in a step,
    and the virial of the forces."""

    def __init__(self, nu, prony, step, cells=2, young=YOUNG, **values):
        self.mesh = soft_bodies.box((cells,) * 3, (cells * CELL,) * 3)
        self.soft = soft_bodies.body(self.mesh, young, nu, prony=prony, step=step, damping=0.0, **values)
        self.zero = np.zeros_like(self.mesh[0])
        self.volume = (cells * CELL) ** 3

    def stress(self, F):
        """First Piola-Kirchhoff stress (3, 3) [Pa]; advances by a step."""
        self.soft.set_state(self.mesh[0] @ F.T, self.zero)
        self.soft.step(1)
        force = self.soft.velocities() * self.soft.masses()[:, None] / self.soft.time_step
        return -force.T @ self.mesh[0] / self.volume


def cycle_moduli(nu, prony, pattern, omega, step, size=2e-4, young=YOUNG):
    """Storage + i loss [Pa] of the stress along the pattern, in a steady cycle of strain."""
    block = Strained(nu, prony, step, cells=1, young=young)
    per = round(2 * np.pi / (omega * step))
    step_of = np.exp(1j * 2 * np.pi * np.arange(per) / per)
    first = 1 + int(np.ceil(5.0 * max((tau for _, tau in prony), default=0.0) / (per * step)))
    found = 0j
    for cycle in range(first + 1):
        for e in step_of:
            P = block.stress(np.eye(3) + size * e.imag * pattern)
            if cycle == first:
                found += 2.0 / per * P.ravel() @ pattern.ravel() / (pattern**2).sum() / size * np.conj(e) * 1j
    return found


def once(nu, prony, pattern, step=1e-6, young=YOUNG):
    """Modulus at once [Pa], from the energy of a sudden strain."""
    size = 1e-3
    block = Strained(nu, prony, step, young=young)
    block.stress(np.eye(3) + size * pattern)
    return 2.0 * block.soft.energies()[0] / block.volume / (size**2 * (pattern**2).sum())
