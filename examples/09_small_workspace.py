"""A device with a workspace of 40 mm in front of an organ of 120 mm: the laws of the mapping, one word each.

A pretended hand first moves to the edge of the workspace and rests there; then a person draws small circles with the
tool, looking at the tool alone. You learn

* that `indexed` reaches as far as scale and workspace allow, and `scaled` chooses the scale;
* that `rate` lets the tool continue while the hand rests at the rim;
* that `drift` brings the hand back to the centre while the person only looks at the tool.

    python examples/09_small_workspace.py
"""

import numpy as np
import tyro

import palpate

SIZE = 0.04  # m


def scene(law: str) -> palpate.Scene:
    """The scene with a law of the mapping."""
    return palpate.Scene.model_validate(
        {
            "objects": [{"name": "liver", "shape": "organ", "triangles": 2000, "stiffness": 100.0, "damping": 2.0}],
            "arms": {"leader": {"driver": "loop"}},
            "mapping": {"law": law, "workspace": [SIZE] * 3, "centre": [0.0, 0.0, 0.0]},
            "operator": {"palpate": {"hover": 0.03}},
        }
    )


class Hand:
    """A hand of 1000 positions a second, which stays inside the workspace."""

    def __init__(self, law: str) -> None:
        self.haptics, self.t, self.p = palpate.Haptics(scene(law)), 0.0, np.zeros(3)
        self.first = self.to(self.p)
        self.scale = self.haptics.session.rig.scene.mapping.scale

    def to(self, p: np.ndarray) -> np.ndarray:
        """Move the hand to p; returns the position of the tool [m]."""
        X, self.p = np.eye(4), np.clip(p, -SIZE / 2, SIZE / 2)
        X[:3, 3], self.t = self.p, self.t + 0.001
        self.haptics.step(self.t, X)
        return np.array(self.haptics.session.latest()["p_WT_goal"])

    def reach(self, duration: float) -> float:
        """How far the tool has come when the hand moves to the edge in half a second, and rests there [m]."""
        for i in range(int(1000 * duration)):
            tool = self.to(np.array([min(1.0, i / 500) * SIZE / 2, 0.0, 0.0]))
        return float(np.linalg.norm(tool - self.first))

    def follow(self, duration: float) -> float:
        """Distance of the hand's middle from the centre after following small circles with the tool [m]."""
        begin, radius, hands = self.to(self.p), 0.1 * SIZE * self.scale, []
        for i in range(int(1000 * duration)):
            angle = 2 * np.pi * i / 500  # two circles a second
            wanted = begin + radius * np.array([np.cos(angle) - 1.0, np.sin(angle), 0.0])
            hands.append(self.p)
            self.to(self.p + (wanted - self.to(self.p)) / self.scale)
        return float(np.linalg.norm(np.mean(hands[-1000:], axis=0)))


def main(duration: float = 4.0) -> None:
    """Print what each law reaches."""
    print("law       scale   reach of the tool   hand from the centre after following circles")
    for law in ("indexed", "scaled", "rate", "drift"):
        hand = Hand(law)
        reach, away = hand.reach(duration), hand.follow(duration)
        print(f"{law:<8} {hand.scale:6.2f} {1e3 * reach:12.0f} mm {1e3 * away:15.0f} mm")


if __name__ == "__main__":
    tyro.cli(main)
