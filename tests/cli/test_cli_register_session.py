"""`palpate register session` and `check`: what is written, what is refused, and the attended dialogue."""

import io
import json

import numpy as np
import pytest
import yaml
from json_contract import keys
from rich.console import Console

from palpate.arm import models_folder
from palpate.base.arrays import rigid
from palpate.base.errors import PalpateError, RegistrationError
from palpate.cli.commands.register import _attended, _viewer
from palpate.scene import Scene, placing
from palpate.scene.overrides import override
from palpate.scene.registered import RegisteredOrgan, at
from palpate.sensing.trackers import SimulatedTracker
from palpate.sensing.trackers.pointer import TrackedPointer
from palpate.world.mesh import Mesh
from palpate.world.registration.clouds import sampled
from palpate.world.registration.procedure import Organ, Procedure
from palpate.world.registration.touches import Guess
from palpate.world.shapes.organs import organ

SHIPPED = (models_folder().parent / "scenes" / "registration.yaml").read_text()


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "reg.yaml"
    path.write_text(SHIPPED.replace("shape: organ", "shape: organ\n    triangles: 4000"))
    return path


@pytest.mark.usefixtures("without_figures")
def test_session_then_check_then_run(palpate, scene, tmp_path):
    written = tmp_path / "registered" / "liver.yaml"
    before = palpate("run", scene, "--headless", "--duration", "0.1")
    assert before.code == 2
    assert "not found" in before.err
    done = palpate("register", "session", scene, "--json", "-")
    assert done.code == 0
    values = json.loads(done.out)
    assert set(values) == keys("register session")
    bounds = {one["name"]: one["within"] for one in values["targets"]}
    assert all(error < bounds[name] <= 1e-3 for name, error in values["true_errors"].items())
    assert "touch 6:" in done.err
    again = palpate("register", "session", scene)
    assert again.code == 2
    assert "exists already" in again.err

    good = palpate("register", "check", scene, "--json", "-")
    assert good.code == 0
    assert set(json.loads(good.out)) == keys("register check")
    assert yaml.safe_load(written.read_text())["check"]["passed"] is True
    assert palpate("run", scene, "--headless", "--duration", "0.1", "--out", tmp_path / "runs").code == 0

    data = yaml.safe_load(written.read_text())
    data["X"][0][3] += 2e-3
    data["X"][2][3] += 2.2e-3  # 3 mm off
    written.write_text(yaml.safe_dump(data))
    bad = palpate("register", "check", scene)
    assert bad.code == 1
    assert "not trusted any more" in bad.out
    assert yaml.safe_load(written.read_text())["trusted"] is False
    refused = palpate("run", scene, "--headless", "--duration", "0.1")
    assert refused.code == 2
    assert "not trusted" in refused.err


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("tumour: [-0.065", "tumour: [0.065", "the list is mirrored"),
        ("noise_mm: 1}", "noise_mm: 1, cloud: other.csv}", "cannot be registered"),
        ("tip_mm: 0.2", "tip_mm: 3\n  touches: 6", "6 touches are not enough"),
    ],
)
def test_sessions_that_cannot_succeed_write_nothing(palpate, scene, tmp_path, old, new, words):
    assert old in scene.read_text()
    scene.write_text(scene.read_text().replace(old, new))
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(800, 3))
    ball = 0.03 * ball / np.linalg.norm(ball, axis=1, keepdims=True) + 1e-3 * rng.normal(size=(800, 3))
    (tmp_path / "other.csv").write_text("\n".join(",".join(map(str, p)) for p in ball + np.array([0.0, 0.0, 0.4])))
    done = palpate("register", "session", scene, "--json", "x.json")
    assert done.code == 2
    assert words in done.err
    assert not (tmp_path / "registered" / "liver.yaml").exists()
    assert not (tmp_path / "x.json").exists()


TRACKED = """
objects: [{name: liver, shape: organ, triangles: 4000, frame: anatomy}]
frames:
  - {child: tracker, pose: {xyz: [0.3, 0.2, 1.4], rpy_deg: [180, 0, 90]}}
  - {parent: tracker, child: stylus, tracker: polaris, pose: {xyz: [0, 0, 1.2]}}
  - {child: anatomy, file: registered.yaml}
  - {child: eye, pose: {xyz: [0, 0, 0]}, sigma_mm: 0.5, sigma_deg: 0.1}
trackers: {polaris: {simulated: {}}}
registration:
  frame: anatomy
  targets: {tumour: [-0.065, -0.03, 0.0]}
  accuracy: 2 mm
  touch_mm: 0.4
  landmarks: LANDMARKS
  pointer: {frame: stylus, tip: [0.0, 0.0, 0.1]}
"""


class Operator:
    """A person with a tracked stylus: moves its tip to what the prompt asks for, and presses Enter."""

    def __init__(self, X_WO, answers=()):
        self.X_WO, self.answers, self.prompts = X_WO, list(answers), []
        self.t, self.tip_W = 0.0, np.array([0.0, 0.0, 0.3])

    def scene(self, tmp_path, spoil=lambda p: p):
        p_O = self.organ().touchable[0]
        rows = [int(np.argmax(p_O @ v)) for v in ([1, 0, 1], [-1, 0, 1], [0, 1, 1], [0, -1, 1], [0, 0, 1])]
        self.landmarks = dict(zip("abcde", p_O[rows], strict=True))
        listed = {name: spoil(p).tolist() for name, p in self.landmarks.items()}
        scene = Scene.parse(TRACKED.replace("LANDMARKS", json.dumps(listed)), str(tmp_path / "t.yaml"))
        self.scanned = RegisteredOrgan(scene)
        graph = placing.graph(at(scene, np.eye(4)))
        self.X_KW = rigid.inverse(graph.pose("tracker").X)
        tracker = SimulatedTracker({"stylus": lambda t: self.stylus()})
        self.pointer = TrackedPointer(scene, graph, tracker, lambda: self.t, self.wait)
        return scene

    def organ(self):
        body = Mesh(*organ(4000))
        return Organ(body.core, sampled(body.vertices, body.triangles, 20_000), {})

    def wait(self, seconds):
        self.t += seconds

    def stylus(self):
        return self.X_KW @ rigid.rigid(np.diag([1.0, -1.0, -1.0]), self.tip_W + np.array([0.0, 0.0, 0.1]))

    def __call__(self, prompt):
        self.prompts.append(prompt)
        if self.answers:
            answer = self.answers.pop(0)
            if isinstance(answer, Exception):
                raise answer
            return answer
        if "landmark" in prompt:
            self.tip_W = rigid.transform(self.X_WO, self.landmarks[prompt.split("'")[1]][None])[0]
        elif "touch near" in prompt:
            p_O = rigid.transform(rigid.inverse(self.X_WO), self.dialogue.next_W[None])
            self.tip_W = rigid.transform(self.X_WO, self.scanned.organ.surface.nearest(p_O)[1])[0]
        return ""

    def register(self, tmp_path, spoil=lambda p: p):
        scene = self.scene(tmp_path, spoil)
        self.dialogue = _attended.Dialogue(Console(quiet=True), scene, self.scanned, self.pointer, self)
        return self.dialogue.run()


def test_operator_with_a_tracked_stylus_registers_from_landmarks(tmp_path):
    X = rigid.rigid(rigid.exp([0.1, -0.2, 0.4]), [0.05, -0.02, 0.1])
    operator = Operator(X)
    state = operator.register(tmp_path)
    assert any("not enough: touch near" in prompt for prompt in operator.prompts)
    goal = state.organ.targets["tumour"]
    error = np.linalg.norm((state.found.X - X) @ np.append(goal, 1.0))
    assert error < state.bounds["tumour"] <= 2e-3


def test_operator_may_undo_skip_and_quit(tmp_path):
    X = rigid.rigid(np.eye(3), [0.05, -0.02, 0.1])
    with pytest.raises(RegistrationError, match="ended before"):
        Operator(X, ["q"]).register(tmp_path)
    with pytest.raises(RegistrationError, match="ended before"):
        Operator(X, [EOFError()]).register(tmp_path)


def test_mirrored_landmarks_and_an_organ_that_moves_are_told(tmp_path):
    X = rigid.rigid(np.eye(3), [0.05, -0.02, 0.1])
    with pytest.raises(RegistrationError, match=r"landmark .* from the organ's surface"):
        Operator(X).register(tmp_path, lambda p: p * [1.0, -1.0, 1.0])

    class Clumsy(Operator):
        def __call__(self, prompt):
            if len(self.prompts) == 10:
                self.X_WO = rigid.displaced(self.X_WO, [0.006, 0.004, 0.008, 0, 0, 0])
            return super().__call__(prompt)

    with pytest.raises(RegistrationError, match="touches disagree"):
        Clumsy(X).register(tmp_path)


@pytest.mark.parametrize("away", [0.0, 1.5e-3])
def test_operator_writes_the_cameras_points_again_after_the_touches(tmp_path, away):
    X = rigid.rigid(np.eye(3), [0.05, -0.02, 0.1])

    class Seeing(Operator):
        def write(self, name):
            p = self.scanned.organ.points[::20]
            p = p[p[:, 2] > 0.0] + 5e-4 * np.random.default_rng(len(self.prompts)).normal(
                size=(len(p[p[:, 2] > 0.0]), 3)
            )
            np.save(tmp_path / name, rigid.transform(self.X_WO, p))

        def scene(self, tmp_path, spoil=lambda p: p):
            scene = override(super().scene(tmp_path, spoil), {
                "registration.camera": {"frame": "eye", "cloud": "before.npy", "cloud_after": "after.npy"},
            })  # fmt: skip
            self.scanned = RegisteredOrgan(scene)
            self.write("before.npy")
            return scene

        def __call__(self, prompt):
            if "sees now" in prompt:
                self.X_WO = rigid.displaced(self.X_WO, [0.0, away, 0.0, 0, 0, 0])
                self.write("after.npy")
            return super().__call__(prompt)

    operator = Seeing(X)
    if away:
        with pytest.raises(RegistrationError, match=r"organ or camera moved .* by about [12]\.\d mm"):
            operator.register(tmp_path)
    else:
        assert operator.register(tmp_path).smallest_motion_seen < 1.5e-3
    assert any("after.npy" in prompt for prompt in operator.prompts)


def test_stylus_that_is_hidden_or_moves_is_not_read(tmp_path):
    operator = Operator(np.eye(4))
    operator.scene(tmp_path)
    still = operator.stylus
    operator.stylus = lambda: rigid.displaced(still(), [0, 0, 0.05 * np.sin(40 * operator.t), 0, 0, 0])
    with pytest.raises(RegistrationError, match=r"moved by .* mm|poses of 'stylus' arrived"):
        operator.pointer.read()


def test_viewer_shows_the_next_place_and_the_newest_errors(scene):
    pytest.importorskip("viser", reason="the viewer is not installed")
    from palpate.viewer.staging import stage_of

    loaded = Scene.load(scene)
    scanned, arm = RegisteredOrgan(loaded), _attended.ArmPointer(loaded, 0, 1)
    dialogue = _attended.Dialogue(Console(quiet=True), loaded, scanned, arm, lambda prompt: "")
    opened = []
    with _viewer.shown(Console(file=io.StringIO()), arm, dialogue, 8471):
        opened = [mark.name for mark in stage_of(arm.session.rig).targets]
    marks = _viewer.marks(dialogue, stage_of(arm.session.rig).targets)
    assert opened == [mark.name for mark in marks] == ["tumour", "vessel"]
    assert marks[0].newest()[1].max() == 0.0  # before the first pose
    state = Procedure(scanned.organ, Guess(np.eye(4), 1e-6 * np.eye(6)), 1e-3, 3e-4, 2e-4, 2e-3)
    dialogue.procedure = state
    p_W, covariance = marks[0].newest()
    assert p_W == pytest.approx([-0.065, -0.03, 0.0])
    assert covariance == pytest.approx(state.targets["tumour"].covariance)
    with pytest.raises(PalpateError, match="leave out --viewer"), _viewer.shown(Console(), object(), dialogue, 8471):
        pass


def test_arm_is_a_pointer_that_must_feel_contact(scene):
    loaded = Scene.load(scene)
    arm = _attended.ArmPointer(loaded, 0, 1)
    with pytest.raises(RegistrationError, match="no contact is felt"):
        arm.read()
    arm.session.step(2600)
    X_WT = arm.read()
    placed = arm.session.rig.surfaces[0]
    p_O = rigid.transform(rigid.inverse(placed.X_WO), X_WT[None, :3, 3])
    assert placed.body.core.nearest(p_O)[0][0] - arm.radius == pytest.approx(0.0, abs=0.2e-3)
