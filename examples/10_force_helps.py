"""Does a policy find a hard lump in soft tissue better if it feels the force? Trained twice, with and without.

You learn how to use the environments of Palpate (`palpate.gym`) with a task of your own, and how to train a small
network by an evolution strategy, without a learning library. Needs the extra `learning`; takes minutes. Everything is
simulated. The tool starts up to 12 mm beside a lump that it cannot see, pressed in by 4 mm.

    python examples/10_force_helps.py --figure force_helps.png
"""

from __future__ import annotations

import argparse

import matplotlib.pyplot as plt
import numpy as np
from scipy import stats

from palpate.gym import Motion, PalpateVectorEnv

AREA, NEAR, PRESS = 0.016, 0.005, 0.004  # half width of the searched area, found within, depth of the stroke [m]
LUMP = {"name": "lump", "at": [0, 0, 0.015], "radius": 0.002, "blend": 0.009, "stiffness": 1200}
TISSUE = {"name": "tissue", "box": {"size": [0.1, 0.1, 0.04]}, "pose": {"xyz": [0, 0, -0.02]}, "stiffness": 250}
SCENE = {
    "objects": [TISSUE | {"damping": 2, "regions": [LUMP]}],
    "operator": {"palpate": {"at": [0, 0, 0], "hover": 0.004}},
}
STEPS, SUB = 60, 40  # actions of an episode, ticks of 1 ms for each
CIRCLE = np.array([1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0], dtype=float)  # both begin with it, and with an open gate
WEIGHTS, PAIRS, EACH, FRESH = 12, 10, 6, 40  # of the network; of a generation


class Search:
    """A task of one's own: start beside the lump; the reward is minus the distance from it, which nobody observes."""

    def begin(self, n, dt, world) -> None:
        self.goals, self.starts, self.radius = np.zeros((n, 3)), np.zeros((n, 2)), world.scene.contact.radius

    def reset(self, i, rig, rng):
        X_WT = rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
        X_WT[:3, 3] = [*self.starts[i], self.radius]
        return X_WT

    def evaluate(self, ticks, felt):
        away = np.linalg.norm(ticks["p_WT"][:, :2], axis=1)
        return -away, np.zeros(len(away), dtype=bool)


def rollouts(many: PalpateVectorEnv, weights: np.ndarray, starts: np.ndarray, feels: bool) -> np.ndarray:
    """Distances (n,) from the lump at the end, for a network (n, 12) and a start (n, 2) of each environment [m]."""
    many.task.starts[:] = starts
    seen, _ = many.reset()
    W, gate, away = weights[:, :10].reshape(-1, 2, 5), weights[:, 10:], []
    for k in range(STEPS):
        force = seen["force"][:, 2] - 1.0 if feels else np.zeros(len(weights))  # beside the lump, it is 1 N
        time = [np.sin(0.35 * k), np.cos(0.35 * k), 1.0]
        x = np.column_stack([np.tile(time, (len(weights), 1)), many.instruments.goals[:, :2] / AREA])
        wide = 1.0 / (1.0 + np.exp(-4.0 * (gate[:, 0] + gate[:, 1] * force)))
        actions = np.zeros((len(weights), 6))
        actions[:, :2] = 0.05 * wide[:, None] * np.tanh(np.einsum("nij,nj->ni", W, x))
        actions[:, 2] = -0.05 if k * SUB * 5e-5 < PRESS else 0.0
        seen, reward, *_ = many.step(actions)
        away.append(-reward)
    return np.mean(away[-5:], axis=0)


def train(many: PalpateVectorEnv, feels: bool, seed: int, generations: int) -> list[float]:
    """Move a mean network along random directions by the ranks of their scores; its share of finds by generation."""
    rng = np.random.default_rng(seed)
    mean, step, found = CIRCLE + 0.1 * rng.normal(size=WEIGHTS), np.zeros(WEIGHTS), []
    for _ in range(generations):
        noise = rng.normal(size=(PAIRS, WEIGHTS))
        tried = np.concatenate([mean + 0.25 * noise, mean - 0.25 * noise])
        starts, fresh = (rng.uniform(-0.75 * AREA, 0.75 * AREA, (m, 2)) for m in (EACH, FRESH))
        networks = np.concatenate([np.repeat(tried, EACH, axis=0), np.tile(mean, (FRESH, 1))])
        away = rollouts(many, networks, np.concatenate([np.tile(starts, (2 * PAIRS, 1)), fresh]), feels)
        score = np.exp(-((away[:-FRESH] / 0.006) ** 2)).reshape(2 * PAIRS, EACH).mean(axis=1)
        rank = np.argsort(np.argsort(score)) / (2 * PAIRS - 1) - 0.5
        mean = mean + (step := 0.6 * step + 0.5 * (rank[:PAIRS] - rank[PAIRS:]) @ noise / PAIRS)
        found.append(float(np.mean(away[-FRESH:] < NEAR)))
    return found


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in (("--generations", 20), ("--seeds", 3)):
        options.add_argument(name, type=int, default=default)
    options.add_argument("--figure")
    o = options.parse_args()
    given = {"substeps": SUB, "duration": 1e6, "observe": ("force",), "motion": Motion(speed=0.05, reach=AREA)}
    many = PalpateVectorEnv(2 * PAIRS * EACH + FRESH, SCENE, Search(), **given)
    last, factor = max(1, o.generations // 4), stats.t.ppf(0.975, o.seeds - 1) / np.sqrt(o.seeds)
    curves, wide = {}, {}
    for name, feels in (("with force", True), ("without", False)):
        found = 100 * np.array([train(many, feels, seed, o.generations) for seed in range(o.seeds)])
        ends = found[:, -last:].mean(axis=1)
        print(f"{name:10}: finds {ends.mean():.0f} +- {factor * ends.std(ddof=o.seeds > 1):.0f} % of the lumps")
        curves[name], wide[name] = found.mean(axis=0), factor * found.std(axis=0, ddof=o.seeds > 1)
    print("lumps found [%], mean over seeds and half of its 95 % interval\ngeneration      with force         without")
    for k in range(o.generations):
        print(f"{k + 1:10}" + "".join(f"{curves[name][k]:9.0f} +-{wide[name][k]:4.0f}" for name in curves))
    if o.figure:
        for name, mean in curves.items():
            plt.errorbar(range(len(mean)), mean, wide[name], label=name, capsize=2)
        plt.gca().set(xlabel="generation", ylabel="lumps found [%], mean and 95 % interval", ylim=(0, 100))
        plt.gcf().legend()
        plt.savefig(o.figure)


if __name__ == "__main__":
    main()
