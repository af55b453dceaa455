"""No file of a stranger takes the machine: each reader refuses it with an error of one place, below 500 MB and 3 s.

`READERS` names every reader. A new one fails the last two tests until it has a row here.
"""

import ast
import os
import pickle
import resource
import struct
import sys
import traceback
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import hostile
import pytest

import palpate
import palpate_lab
from palpate.base.errors import PalpateError

MOST_MEMORY, MOST_TIME = 500, 3.0  # [MB, s of the processor]
MAY_BE_READ = ("zeros", "a face without end", "a face without end, ascii")
"""Hostile files of which a part is sound, and may be read within the limits."""
PACKAGES = (Path(palpate.__file__).parent, Path(palpate_lab.__file__).parent)


def scene(path):
    palpate.Scene.load(path)


def solid(path):
    from palpate.world.mesh import files

    return files.read(path)


def cloud(path):
    from palpate.world.clouds import PointCloud

    PointCloud.load(path, "m")


def grid(path):
    from palpate.world.surfaces import DistanceGrid

    DistanceGrid.load(path)


def tetrahedra(path):
    from palpate.world.tissue import files

    files.load(path)


def record(path):
    from palpate.record.bags.open import open_any

    open_any(path)


def of(module, function, *arguments, wants=Path):
    """A reader by its place."""

    def read(path):
        from importlib import import_module

        found = import_module(f"palpate.{module}")
        for name in function.split("."):
            found = getattr(found, name)
        return found(wants(path), *arguments)

    read.__name__ = f"{module}.{function}"
    return read


def urdf(path):
    model = path.with_name("model.yaml")
    model.write_text(f"name: a\nurdf: {path.name}\n")
    palpate.Arm.load(model)


def exercise(path):
    file = path.parent / "exercise.yaml"
    file.write_text(f"scene: {{name: a, objects: [{{name: b, asset: {path.name}}}]}}\n")
    palpate.Scene.load(file)


def press(path):
    from palpate.arm.identify import press_recording

    press_recording.load(path)


def moving(path):
    from palpate.arm.identify import recordings

    recordings.read_moving(path, 7)


def dynamics(path):
    base = path.parent / "scene.yaml"
    base.write_text(f"objects: [{{sphere: {{radius: 0.02}}}}]\nforce: {{source: estimated, dynamics: {path.name}}}\n")
    from palpate.scene.rig import build

    build(palpate.Scene.load(base), until=0.0).simulation()


def replayed(path):
    from palpate.sensing.replay import ReplaySource

    ReplaySource(path)


def pictures(path):
    from palpate.session.network.video import Folder

    Folder(path.parent)


def journal(path):
    from palpate.base.sweep import journal

    if path.is_file() and not path.stat().st_size:
        raise PalpateError("an empty file is a new journal")
    journal.Journal(path, journal.Fingerprint(*["x"] * len(journal.Fingerprint.__dataclass_fields__)))


def colors(path):
    import numpy as np

    from palpate.world.mesh.colors import colors_of

    colors_of(path, np.eye(3))
    raise PalpateError("only colours are missing")


def quiet(function):
    """A reader that answers with False or None where a file is not of its kind."""

    def read(path):
        if function(path):
            return
        raise PalpateError("it is not of this kind")

    read.__name__ = function.__name__
    return read


YAML = lambda: hostile.yaml_files()  # noqa: E731
NONE = lambda: ()  # noqa: E731
READERS = [
    # module whose limits are judged, reader, name of the file, hostile files of its format
    ("scene/text.py", scene, "scene.yaml", YAML),
    ("scene/exercises.py", exercise, "body.urdf", hostile.urdf_files),
    ("arm/arm.py", of("arm", "Arm.load"), "arm.yaml", YAML),
    ("arm/arm.py", urdf, "arm.urdf", hostile.urdf_files),
    ("arm/gravity_model.py", of("arm.gravity_model", "GravityModel.load"), "gravity.yaml", YAML),
    ("arm/dvrk_gravity.py", of("arm.dvrk_gravity", "load"), "gc.json", YAML),
    ("world/frames/files.py", of("world.frames.files", "load"), "frames.yaml", YAML),
    ("world/frames/files.py", of("world.frames.files", "pose"), "pose.yaml", YAML),
    ("arm/hands/__init__.py", of("arm.hands", "load"), "hand.yaml", YAML),
    ("devices/certificate/device.py", of("devices.certificate.device", "DeviceModel.load"), "device.yaml", YAML),
    ("devices/certificate/device.py", quiet(of("devices.certificate.device", "is_device")), "device.yaml", YAML),
    ("scene/force_source.py", dynamics, "dynamics.yaml", YAML),
    ("planning/result.py", of("planning.result", "load"), "plan.yaml", YAML),
    ("planning/goals.py", of("planning.goals", "read_places"), "goal.yaml", YAML),
    ("planning/moveit.py", of("planning.moveit", "read"), "trajectory.yaml", YAML),
    ("scene/guidance/files.py", of("scene.guidance.files", "clearance_of_plan"), "plan.yaml", YAML),
    ("scene/guidance/files.py", of("scene.guidance.files", "read_rows"), "curve.csv", hostile.csv_files),
    ("devices/wrist.py", of("devices.wrist", "load"), "wrist.csv", hostile.csv_files),
    ("arm/identify/recordings.py", moving, "moving.csv", hostile.csv_files),
    ("arm/identify/press_recording.py", press, "press.csv", hostile.csv_files),
    ("arm/identify/grip_recording.py", of("arm.identify.grip_recording", "load"), "grip.csv", hostile.csv_files),
    ("world/registration/files.py", of("world.registration.files", "read_points"), "points.csv", hostile.csv_files),
    ("world/registration/slicer_files.py", of("world.registration.files", "read_points"), "a.fcsv", hostile.csv_files),
    ("world/registration/slicer_files.py", of("world.registration.files", "read_points"), "a.mrk.json", YAML),
    ("world/registration/files.py", of("world.registration.files", "read_poses"), "poses.csv", hostile.csv_files),
    (
        "world/registration/cloud_files.py",
        of("world.registration.cloud_files", "read_cloud"),
        "cloud.npy",
        hostile.npy_files,
    ),
    ("world/surfaces/grid.py", grid, "grid.npz", lambda: hostile.npz_files("distance", "origin", "spacing")),
    ("world/mesh/volume_files.py", grid, "grid.nrrd", lambda: hostile.nrrd_files("float")),
    ("world/clouds/files.py", cloud, "cloud.npz", lambda: hostile.npz_files("points", "normals", "colors")),
    ("world/clouds/files.py", cloud, "cloud.npy", hostile.npy_files),
    ("world/clouds/files.py", cloud, "cloud.xyz", hostile.csv_files),
    ("world/clouds/pcd.py", cloud, "cloud.pcd", hostile.pcd_files),
    ("world/clouds/ply.py", cloud, "cloud.ply", lambda: [one for one in hostile.ply_files() if "face" not in one[0]]),
    ("world/mesh/files.py", solid, "organ.stl", hostile.stl_files),
    ("world/mesh/headers.py", solid, "organ.obj", hostile.obj_files),
    ("world/mesh/files.py", solid, "organ.ply", hostile.ply_files),
    ("world/mesh/files.py", solid, "organ.off", hostile.off_files),
    ("world/mesh/headers.py", solid, "organ.glb", hostile.glb_files),
    ("world/mesh/files.py", solid, "organ.gltf", hostile.gltf_files),
    ("world/mesh/files.py", solid, "organ.3mf", NONE),
    ("world/mesh/files.py", solid, "organ.dae", NONE),
    ("world/mesh/colors.py", colors, "organ.obj", hostile.obj_files),
    ("world/mesh/colors.py", colors, "organ.glb", hostile.glb_files),
    ("world/mesh/vtk_file.py", solid, "organ.vtk", hostile.vtk_files),
    ("world/mesh/vtk_file.py", solid, "organ.vtp", hostile.vtu_files),
    ("world/mesh/volume_files.py", solid, "labels.nrrd", lambda: hostile.nrrd_files("uint8")),
    ("world/mesh/volume_files.py", solid, "labels.nhdr", lambda: hostile.nrrd_files("uint8")),
    ("world/mesh/volume_files.py", solid, "labels.nii", lambda: hostile.nifti_files(False)),
    ("world/mesh/volume_files.py", solid, "labels.nii.gz", lambda: hostile.nifti_files(True)),
    ("world/mesh/meta_image.py", solid, "labels.mha", hostile.mha_files),
    ("world/mesh/meta_image.py", solid, "labels.mhd", hostile.mha_files),
    ("world/tissue/files.py", tetrahedra, "organ.vtk", hostile.vtk_files),
    ("world/tissue/files.py", tetrahedra, "organ.vtu", hostile.vtu_files),
    ("world/tissue/files.py", tetrahedra, "organ.msh", hostile.msh_files),
    ("world/tissue/old_gmsh.py", tetrahedra, "old.msh", hostile.msh_files),
    ("world/tissue/files.py", tetrahedra, "organ.mesh", hostile.medit_files),
    ("world/tissue/files.py", tetrahedra, "organ.meshb", hostile.meshb_files),
    ("record/mcap_scan.py", of("record.reader", "Record.open"), "record.mcap", hostile.mcap_files),
    ("record/bags/library.py", record, "bag.mcap", hostile.mcap_files),
    ("record/bags/recover.py", record, "cut.mcap", hostile.mcap_files),
    ("record/bags/library.py", record, "bag.db3", NONE),
    ("record/bags/library.py", replayed, "clouds.mcap", hostile.mcap_files),
    ("base/sweep/lines.py", journal, "points.jsonl", NONE),
    ("experiment/study.py", of("experiment.study", "read_manifest"), "manifest.json", NONE),
    ("session/network/traces.py", of("session.network.traces", "read_trace"), "trace.csv", hostile.csv_files),
    ("session/network/traces.py", of("session.network.traces", "read_trace"), "trace.pcap", hostile.pcap_files),
    ("session/network/video.py", pictures, "00.jpg", NONE),
    ("session/network/keys.py", of("session.network.keys", "read_key"), "link.key", NONE),
]
"""Every reader of files, with hostile files of its format; `hostile.any_files` and `special` are for each of them."""


def resident_MB():
    """Memory of this process, and of a child at its start: the kernel counts from there."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / (1 << 20)


def judged(read, path):
    """What a reader makes of a file, in a process of its own: kind of outcome, words, memory beyond that of the tests
    which ran before [MB], time [s]."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (15, 20))
            resource.setrlimit(resource.RLIMIT_AS, (12 << 30, 12 << 30))
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            os.write(into, struct.pack("d", resident_MB()))
            try:
                read(path)
                said = ("read", "")
            except PalpateError as error:
                said = ("refused", str(error))
            except BaseException:
                said = ("raised", traceback.format_exc())
            with os.fdopen(into, "wb") as pipe:
                pickle.dump(said, pipe)
        finally:
            os._exit(0)
    os.close(into)
    with os.fdopen(out, "rb") as pipe:  # read first: a long answer does not fit into the pipe
        before = struct.unpack("d", pipe.read(8))[0]
        data = pipe.read()
    _, status, used = os.wait4(child, 0)
    said = pickle.loads(data) if data else ("died", f"status {status}")
    return *said, used.ru_maxrss / 1024 - before, used.ru_utime + used.ru_stime


def faults(row, folder):
    """What is wrong with the answers of the reader of a row to all hostile files, or the reason to skip it."""
    _, read, name, made = READERS[row]
    wrong, files = [], [*hostile.special(folder, name)]
    for k, (what, data) in enumerate([*hostile.any_files(), *made()]):
        path = folder / str(k) / name
        path.parent.mkdir()
        path.write_bytes(data)
        files.append((what, path))
    small = folder / "warm" / name
    small.parent.mkdir()
    small.write_bytes(b"1")
    try:  # imports count neither as time nor as memory of one file
        read(small)
    except Exception as error:
        if "not installed" in str(error):
            return str(error)
    for what, path in files:
        kind, words, memory, time = judged(read, path)
        if kind != "refused" and not (kind == "read" and what in MAY_BE_READ):
            wrong.append(f"{what}: {kind} {words[-600:]}")
        elif words.count("\n") > 4 or "Traceback" in words or len(words) > 3000:
            wrong.append(f"{what}: an error of {words.count(chr(10)) + 1} lines, {len(words)} letters: {words[:200]}")
        if memory > MOST_MEMORY or time > MOST_TIME:
            wrong.append(f"{what}: {memory:.0f} MB, {time:.1f} s ({words[:100]})")
    return wrong


@pytest.fixture(scope="module")
def small():
    """A process without the modules of other tests: its copy for each file costs a tenth of that of the tests."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        yield pool


@pytest.mark.parametrize("row", range(len(READERS)), ids=[f"{r[1].__name__}-{r[2]}" for r in READERS])
def test_a_hostile_file_is_refused_within_memory_and_time(row, small, tmp_path):
    found = small.submit(faults, row, tmp_path).result()
    if isinstance(found, str):
        pytest.skip(found)
    assert found == []


def test_the_judge_finds_a_reader_without_limits(tmp_path):
    """Memory, time, a traceback, a device: each is found."""
    import json
    import time as clock

    def greedy(path):
        bytearray(600 << 20).count(1)

    def slow(path):
        end = clock.process_time() + 3.2
        while clock.process_time() < end:
            pass

    def careless(path):
        json.loads(path.read_text())

    path = tmp_path / "a"
    path.write_text("[")
    assert judged(greedy, path)[2] > MOST_MEMORY
    assert judged(slow, path)[3] > MOST_TIME
    assert judged(careless, path)[0] == "raised"


# -- the registry is complete ------------------------------------------------------------------------------------------

BARE = {"read_text", "read_bytes", "fromfile", "loadtxt", "genfromtxt", "safe_load", "memmap"}
BARE_OF = {
    *(("np", "load"), ("yaml", "load"), ("json", "load"), ("gzip", "open"), ("gzip", "decompress"), ("nrrd", "read")),
    *(("trimesh", "load"), ("nibabel", "load"), ("meshio", "read"), ("pickle", "load"), ("pickle", "loads")),
}
OWN = {
    "base/limits.py": "the limits themselves",
    "rebuild.py": "files of this installation",
    "ros/build.py": "files of this installation",
    "ros/where.py": "files of this installation",
    "base/values/descriptions.py": "sources of this package",
    "scene/shipped.py": "scenes of this package",
    "devices/trust.py": "sources and metadata of this environment",
    "base/sweep/work.py": "sources of this package",
    "base/cache/store.py": "the cache that this user wrote",
    "world/tissue/make.py": "the folder of its own process",
    "world/tissue/fill.py": "the folder of its own process",
    "base/sweep/local.py": "work of its own process",
    "viewer/page.py": "files of the packages",
    "report/bag.py": "files of the package",
    "report/html.py": "files of the package",
    "cli/_folder.py": "sources of this package",
    "simulators/touching_hand.py": "text of this process",
    "devices/evdev.py": "files of the kernel",
    "base/arrays/yaml_loader.py": "the limits of YAML",
    "base/dds_security.py": "a library of this ROS",
    "report/summary.py": "the record that was read before",
    "reproduce/run.py": "results that this command wrote",
    "reproduce/sliders.py": "files of the package",
    "cli/commands/_licenses.py": "metadata of this environment",
    "cli/doctor/connected.py": "files of the kernel",
    "cli/doctor/machine.py": "files of the kernel",
}
"""Modules that read without limits, and what they read."""
SAFE = {"cli/commands/register/check.py"}  # the file was read before


FINE = {
    ("devices/wrist.py", "loadtxt"): "lines of a text that was read within limits",
    ("ros/topic.py", "safe_load"): "text of the command line",
    ("base/sweep/journal.py", "read_bytes"): "the source of the user's own function",
}
"""Calls that read without limits, and what they read."""


def calls(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            owner = node.func.value
            yield (owner.id if isinstance(owner, ast.Name) else ""), node.func.attr, node.lineno


@cache
def modules():
    """Place, text and calls of each module which is no check of ours."""
    files = ((package, file) for package in PACKAGES for file in sorted(package.rglob("*.py")))
    texts = {str(file.relative_to(package)): file.read_text(encoding="utf-8") for package, file in files}
    ours = {place: text for place, text in texts.items() if not place.startswith(("verify/", "studies/"))}
    return [(place, text, [*calls(ast.parse(text))]) for place, text in ours.items() if place not in OWN]


def test_no_other_code_reads_files_without_limits():
    found = []
    for place, _, made in modules():
        for owner, name, line in made:
            bare = (name in BARE and owner not in ("limits",)) or (owner, name) in BARE_OF
            checked = any(place == module for module, *_ in READERS) and (owner, name) in BARE_OF
            if bare and not checked and (place, name) not in FINE:
                found.append(f"{place}:{line}: {owner}.{name}")
    assert found == [], "read with palpate.base.limits, and add a row to READERS"


def test_each_reader_has_a_row():
    rows = {module for module, *_ in READERS}
    found = set()
    for place, text, made in modules():
        if place in SAFE:
            continue
        used = {(owner, name) for owner, name, _ in made}
        if any(
            owner == "limits" and name in ("read_text", "read_bytes", "load_npz", "load_npy") for owner, name in used
        ):
            found.add(place)
        if "read_yaml(" in text:
            found.add(place)
    assert found - rows == set(), "add a row to READERS, with hostile files of the format"


if sys.platform != "linux":
    pytestmark = pytest.mark.skip(reason="limits of processes are those of Linux")
