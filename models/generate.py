"""Generates the arm models: `python models/generate.py` (the output is committed, and a test compares it).

This folder is the only source of the parameters of the da Vinci arms. Denavit-Hartenberg tables, limits, couplings,
encoders and drive limits are those published with the da Vinci Research Kit (sawIntuitiveResearchKit, share/kinematic
and share/io). Masses and centres of mass of the MTM are the CAD values of Lin et al., IROS 2019; in their link frames
the gravity model of the real controller is exact. Friction is from Wang, Gondokaryono, Munawar, Fischer, IROS 2019.
OURS marks estimates of this project: rotor inertias and rotational inertias are not published, and shapes are for
display only.

Frames in the URDF: a link's frame is on its joint's axis (z) and moves with the joint. With standard DH (MTM),
T_i = Rz(q + off) Tz(d) Tx(a) Rx(alpha) = Rz(q) F_i, so the next joint's origin is F_i. With modified DH (PSM),
T_i = Rx(alpha) Tx(a) Tz(d) Rz(q + off), so the joint's origin is T_i at q = 0. Units: m, rad, kg, N m.
"""

from __future__ import annotations

from pathlib import Path

from ecm import ECM_YAML, ecm
from mtm import MTM_YAML, mtm
from psm import LND, PROGRASP, psm, psm_yaml
from six_axis import DELTA_YAML, SIX_AXIS_YAML, six_axis

HERE = Path(__file__).parent


def outputs() -> dict[str, str]:
    """Files that this script writes: name -> text."""
    files = {}
    for tool in (LND, PROGRASP):
        files |= {f"psm_{tool.name}.urdf": psm(tool), f"psm_{tool.name}.yaml": psm_yaml(tool)}
    files |= {"ecm.urdf": ecm(), "ecm.yaml": ECM_YAML}
    files |= {"six_axis.urdf": six_axis(), "six_axis.yaml": SIX_AXIS_YAML, "delta.yaml": DELTA_YAML}
    for side in ("left", "right"):
        files[f"mtm_{side}.urdf"] = mtm(side)
        files[f"mtm_{side}.yaml"] = MTM_YAML.format(side=side, name=f"mtm_{side}")
    return files


if __name__ == "__main__":
    for file_name, text in outputs().items():
        (HERE / file_name).write_text(text)
        print(f"models/{file_name}")
