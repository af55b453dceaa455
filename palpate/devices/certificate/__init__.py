"""Which virtual walls a device or a scene can render without self-sustained oscillation (docs/certificate.md).

device = palpate.DeviceModel(mass=0.3, damping=0.5, rate=1000, delay=0.004, friction=0.1)
print(palpate.certify(device, K=400, B=2).reason)
print(palpate.certify(palpate.Scene.load("scenes/palpation.yaml")).reason)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from palpate.devices.certificate.certificate import Certificate, certify_device
from palpate.devices.certificate.device import DeviceModel

if TYPE_CHECKING:
    from palpate.scene import Scene
    from palpate.scene.rig import Rig

__all__ = ["Certificate", "DeviceModel", "certify", "certify_all"]


def certify(what: DeviceModel | Scene, K: float | None = None, B: float | None = None) -> Certificate:
    """Certify a `DeviceModel`, or a scene with its arms, hand and objects; a scene gives its most critical certificate.

    Args:
        what: a device, or a scene.
        K: stiffness to judge [N/m]. Default for a device: no verdict, only the limit. Default for a scene: the
            stiffness of each object on the tool's side. The hand feels ``scale * force_scale * K``.
        B: damping of the wall [N s/m]. Default for a device: 0. Default for a scene: the damping of each object.

    Raises:
        SceneError, MeshError: the scene cannot be set up.
        PalpateError: the analysis does not cover the scene's control law or its force source.
    """
    if not isinstance(what, DeviceModel):
        from palpate.devices.certificate.scene import worst_of

        return worst_of(certify_all(what, K, B))
    with threadpool_limits(1):  # the matrices are small, so threads cost more time than they save
        return certify_device(what, K, 0.0 if B is None else B)


def certify_all(
    scene: Scene, K: float | None = None, B: float | None = None, rig: Rig | None = None
) -> list[Certificate]:
    """One certificate per object, region and fixture of a scene, in the order of `certificate.touched.touched`.

    Arguments and errors are those of `certify`; ``rig`` is the assembled scene if it already exists.
    """
    from palpate.devices.certificate.scene import certificates

    return certificates(scene, K, B, rig)
