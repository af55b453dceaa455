"""Short runs of the targets for files, scenes and packets, and proof that each of their judges can fail."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import yaml

from palpate.arm.gravity_model import GravityModel
from palpate.base.errors import ArmError, RecordingError, SurfaceError
from palpate.session.session import Session
from palpate.world.surfaces import DistanceGrid
from palpate_lab.verify.fuzz import FaultError, contact, grids, models, packets, records, scenes, tables


def cases(target, count):
    return [target.case(seed) for seed in range(count)]


@pytest.mark.parametrize(("target", "count"), [(tables, 30), (grids, 100), (models, 20), (records, 8), (scenes, 5)])
def test_cases_hold(target, count):
    assert any("refused" not in one for one in cases(target, count))


def test_damaged_packets_leave_the_next_peer_served():
    pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
    cases(packets, 6)


@pytest.mark.parametrize("size", [10, 58, 80])
def test_a_message_cut_short_blocks_neither_server_nor_tracker(size):
    pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
    cut = packets._packed("tool", np.eye(4), 1.0)[:size]
    packets._to_server(cut)
    packets._to_tracker(cut)


def test_a_server_that_never_answers_is_a_fault(monkeypatch):
    pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
    monkeypatch.setattr(packets, "PATIENCE", 0.2)
    monkeypatch.setattr(packets.OpenIGTLinkServer, "send_pose", lambda self, name, X, t: None)
    with pytest.raises(FaultError, match="serves no sound client"):
        packets._to_server(b"")


def test_a_pose_that_is_not_rigid_and_trusted_is_a_fault(monkeypatch):
    pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
    X = np.diag([2.0, 1.0, 1.0, 1.0])
    monkeypatch.setattr(packets.Gate, "X", property(lambda self: X, lambda self, value: None), raising=False)
    with pytest.raises(FaultError, match="not rigid"):
        packets._to_tracker(b"")


@pytest.mark.parametrize(
    ("factor", "words"), [(np.nan, "is commanded"), (100.0, "above the cap"), (-1.0, "grew or turned by")]
)
def test_a_wrong_force_of_a_scene_is_a_fault(monkeypatch, factor, words):
    """Every twentieth tick reports another force; the sound scene has one object."""
    latest, count = Session.latest, [0]

    def changed(self):
        tick, count[0] = latest(self).copy(), count[0] + 1
        if count[0] % 20 == 0:
            tick["F_H_L"] = factor * np.r_[0.4, 0.0, 0.0]
        return tick

    monkeypatch.setattr(Session, "latest", changed)
    with pytest.raises(FaultError, match=words):
        cases(scenes, 4)


def test_a_force_off_the_normal_is_a_fault():
    F, n = np.array([[0.0, 0.0, 1.0], [1e-3, 0.0, 1.0]]), np.tile([0.0, 0.0, 1.0], (2, 1))
    contact._in_cone(F[:1], n[:1], np.ones(1), 0.0, 1.0)
    contact._in_cone(F, n, np.ones(2), 0.01, 1.0)
    with pytest.raises(FaultError, match="sideways at tip 1"):
        contact._in_cone(F, n, np.ones(2), 0.0, 1.0)


def test_answers_that_are_not_finite_are_faults(monkeypatch):
    monkeypatch.setattr(DistanceGrid, "nearest", lambda self, points: (np.full(3, np.nan),))
    with pytest.raises(FaultError, match="not finite"):
        cases(grids, 60)
    monkeypatch.setattr(models.Arm, "gravity", lambda self, q: np.full(7, np.inf))
    with pytest.raises(FaultError, match="gravity is not finite"):
        cases(models, 60)
    monkeypatch.setattr(tables, "read_rows", lambda path: (np.full((3, 3), np.nan), None))
    with pytest.raises(FaultError, match="a place is not finite"):
        cases(tables, 20)


def test_ticks_in_disorder_are_a_fault(monkeypatch):
    opened = records.Record.open

    def reversed_ticks(path):
        record = opened(path)
        record.ticks["t"] = record.ticks["t"][::-1].copy()
        return record

    monkeypatch.setattr(records.Record, "open", reversed_ticks)
    with pytest.raises(FaultError, match="not later than the one before"):
        cases(records, 20)


def test_gravity_models_with_nan_are_refused(tmp_path):
    """Both readers once accepted them, so that gravity compensation was not a number."""
    ours, theirs = tmp_path / "gravity.yaml", tmp_path / "gc.json"
    theirs.write_bytes(models._dvrk())
    model = models.dvrk_gravity.load(theirs)
    with pytest.raises(ValueError, match="not a finite number"):
        replace(model, theta=model.theta * np.nan)
    ours.write_text(yaml.safe_dump(yaml.safe_load(models._gravity()) | {"theta": [math.nan] * len(model.theta)}))
    with pytest.raises(RecordingError, match="not a finite number"):
        GravityModel.load(ours)
    first = json.loads(models._dvrk())["GC_controller"]["gc_dynamic_params_pos"][0]
    theirs.write_bytes(models._dvrk().replace(str(first).encode(), b"NaN", 1))
    with pytest.raises(RecordingError, match="not a finite number"):
        models.dvrk_gravity.load(theirs)


@pytest.mark.parametrize(("target", "seed"), [(tables, 14204), (models, 10346)])
def test_a_faulty_case_of_a_campaign_is_refused(target, seed):
    """Attitudes too close for a spline; joint limits in the wrong order."""
    assert "refused" in target.case(seed)


def test_a_zip_file_of_unknown_compression_is_no_grid(tmp_path):
    path = tmp_path / "grid.npz"
    height = 1e-3 * (np.arange(4.0) - 1.5)
    DistanceGrid(np.tile(height, (4, 4, 1)), np.zeros(3), 1e-3).save(path)
    data = bytearray(path.read_bytes())
    for start in (data.find(b"PK\x03\x04") + 8, data.find(b"PK\x01\x02") + 10):
        data[start] = 77
    path.write_bytes(data)
    with pytest.raises(SurfaceError, match="cannot be read"):
        DistanceGrid.load(path)


def test_a_model_file_with_a_value_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "arm.yaml"
    path.write_text("device: delta\nparameters: abc\n")
    with pytest.raises(ArmError, match="not valid"):
        models.Arm.load(path)
