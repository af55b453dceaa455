"""Reference kinematics of the arms: the published Denavit-Hartenberg tables in plain numpy."""

import numpy as np

# alpha [deg], a, d [m], offset [deg]
MTM = [
    (90, 0, 0, -90), (0, 0.2794, 0, -90), (-90, 0.3645, 0, 90), (90, 0, 0.1506, 0),
    (-90, 0, 0, 0), (90, 0, 0, -90), (0, 0, 0, 90),
]  # fmt: skip
PSM = [
    (90, 0, 0, 90), (-90, 0, 0, -90), (90, 0, -0.4318, 0), (0, 0, 0.4162, 0), (-90, 0, 0, -90), (-90, 0.0091, 0, -90),
]  # fmt: skip
PSM_TOOL = np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0]])


def mtm(q):
    """X_0i of the seven standard-DH frames."""
    X, frames = np.eye(4), []
    for (alpha, a, d, offset), angle in zip(MTM, q, strict=True):
        ct, st = np.cos(angle + np.radians(offset)), np.sin(angle + np.radians(offset))
        ca, sa = np.cos(np.radians(alpha)), np.sin(np.radians(alpha))
        X = X @ np.array(
            [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
        )
        frames.append(X)
    return frames


def psm(q):
    """X_0T by the modified convention."""
    X = np.eye(4)
    for i, ((alpha, a, d, offset), value) in enumerate(zip(PSM, q, strict=True)):
        theta, d = (np.radians(offset), d + value) if i == 2 else (value + np.radians(offset), d)
        ct, st = np.cos(theta), np.sin(theta)
        ca, sa = np.cos(np.radians(alpha)), np.sin(np.radians(alpha))
        X = X @ np.array(
            [[ct, -st, 0, a], [st * ca, ct * ca, -sa, -d * sa], [st * sa, ct * sa, ca, d * ca], [0, 0, 0, 1]]
        )
    X[:3, :3] = X[:3, :3] @ PSM_TOOL
    return X
