"""Sets the core's options of the force source from the section `force` and the follower's dynamics."""

from __future__ import annotations

import warnings
from pathlib import Path

import yaml

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays.yaml_loader import read_yaml
from palpate.base.errors import PalpateWarning, RecordingError, SceneError
from palpate.scene.scene import Scene


def fill(options: _core.SimulationOptions, scene: Scene, arm: Arm) -> None:
    """Set source, drives and estimate of the follower `arm` in `options`.

    Raises:
        SceneError: the dynamics file cannot be read, or belongs to another arm.
    """
    section, estimate = scene.force, _core.EstimateOptions()
    options.source = section.source
    options.follower.driven = section.source != "contact"  # the estimate needs simulated drive torques
    estimate.bandwidth, estimate.dead_band = section.bandwidth, section.dead_band
    path = scene.dynamics_path()
    if path is None:
        drives = options.follower.drives
        estimate.coulomb, estimate.viscous, estimate.rotor_inertia = (
            drives.coulomb,
            drives.viscous,
            drives.rotor_inertia,
        )
    else:
        estimate = _identified(estimate, path, scene, arm)
    options.estimate = estimate


def _identified(options: _core.EstimateOptions, path: Path, scene: Scene, arm: Arm) -> _core.EstimateOptions:
    from palpate.arm.dynamics import from_data
    from palpate.arm.observer import estimate_options

    where = scene.where("force", "dynamics")
    try:
        return estimate_options(from_data(read_yaml(path), arm, str(path)), options)
    except OSError as error:
        why, mend = f"{path}: {error.strerror or error}", "palpate calibrate dynamics writes one"
        raise SceneError("the dynamics cannot be read", where=where, why=why, mend=mend) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        what = "the dynamics are not valid YAML"
        raise SceneError(what, where=where, why=str(error), mend="identify them again") from None
    except RecordingError as error:
        raise SceneError(error.what, where=where, why=error.why or str(path), mend=error.mend) from None


def check_presence(scene: Scene) -> None:
    """Refuse objects that the force source cannot render; warn of objects that it renders twice.

    Raises:
        SceneError: an object is never felt; the message names the object.
    """
    for i, obj in enumerate(scene.objects):
        where, source = scene.where("objects", i, "presence"), scene.force.source
        if obj.presence == "real" and any(sensor.simulated is not None for sensor in scene.sensors.values()):
            continue  # a camera sees it
        if obj.presence == {"contact": "real", "estimate": "virtual"}.get(source):
            raise SceneError(
                f"object {obj.name!r} is {obj.presence} only and force.source is {source!r}: it is never felt",
                where=where, mend="use force: {source: both}, or another presence",
            )  # fmt: skip
        if source == "both" and obj.presence == "both":
            what = f"object {obj.name!r} is felt twice: as a virtual surface, and through the follower's drives"
            mend = "use presence: real or presence: virtual"
            warnings.warn(PalpateWarning(what, where=where, mend=mend), stacklevel=3)
