"""Which walls a device or a scene can render without swinging by itself (docs/certificate.md).

device = palpate.Device(mass=0.3, damping=0.5, rate=1000, delay=0.004, friction=0.1)
print(palpate.certify(device, K=400, B=2).reason)
print(palpate.certify(palpate.Scene.load("scenes/palpation.yaml")).reason)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from palpate.certificate.certificate import Certificate, certify_device
from palpate.certificate.device import Device

if TYPE_CHECKING:
    from palpate.scene import Scene
    from palpate.scene.rig import Rig

__all__ = ["Certificate", "Device", "certify", "certify_all"]


def certify(what: Device | Scene, K: float | None = None, B: float | None = None) -> Certificate:
    """The certificate of a `Device`, or of the arms, hand and objects of a scene: of the one nearest to its limit.

    Args:
        what: a device, or a scene.
        K: stiffness that is asked about [N/m]; for a device none (the limit alone), for a scene the object's, on the
            tool's side as in the scene file: the hand feels ``scale * force_scale * K``.
        B: damping of the wall [N s/m]; for a device none, for a scene the object's.

    Raises:
        SceneError, MeshError: the scene cannot be set up. PalpateError: its control law or its source
            of the force is not one that is analysed.
    """
    if not isinstance(what, Device):
        from palpate.certificate.scene import worst_of

        return worst_of(certify_all(what, K, B))
    with threadpool_limits(1):  # the matrices are small: threads would only wait for each other
        return certify_device(what, K, 0.0 if B is None else B)


def certify_all(
    scene: Scene, K: float | None = None, B: float | None = None, rig: Rig | None = None
) -> list[Certificate]:
    """One certificate per object and region of a scene, in the order of `scene.touched`; as `certify`.

    rig: the scene set up, when that has been done.
    """
    from palpate.certificate.scene import certificates

    return certificates(scene, K, B, rig)
