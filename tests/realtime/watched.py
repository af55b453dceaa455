"""Run under heap_guard (LD_PRELOAD): prints the heap and lock calls of a session's threads as JSON.

python watched.py realtime METHOD RATE SECONDS
    | lockstep METHOD [organ|solids|soft|live|cloud|LAW|ARM|identified|estimating|guided|executing|bodies] ...
    | planted METHOD RATE | beside [soft|bodies|linked] | robot [following|impedance|moving] ... | geometries all
    | crtk all | device [alone|linked] | haply all SECONDS
"""

import ctypes
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from palpate import _core, _guidance, _network, _verify
from palpate.arm import Arm
from palpate.record.ticks import as_ticks
from palpate.scene import held
from palpate.scene.contact_method import loaded
from palpate.scene.guidance import curve
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate.scene.together import join_instruments
from palpate.simulators import dvrk
from palpate.world.bodies.engine import World
from palpate.world.shapes import analytic

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "loop"))
import loop_rig
from watched_scenes import cloud_scene, organ_scene, press, soft_scene, solids_scene, targets

guard = ctypes.CDLL(os.environ["LD_PRELOAD"])


def counts(thread: int) -> np.ndarray:
    """Numbers of [allocations, releases, locks] of a thread so far."""
    out = (ctypes.c_long * 3)()
    guard.heap_guard_read(ctypes.c_long(thread), out)
    return np.array(out[:])


def system_calls(thread: int, seconds: float) -> dict[str, int]:
    """Numbers of the system calls that a thread makes, by number, while syscall_watch traces it."""
    ctypes.CDLL(None).prctl(0x59616D61, ctypes.c_ulong(-1), 0, 0, 0)  # PR_SET_PTRACER: a child may trace this process
    done = subprocess.run(
        [os.environ["SYSCALL_WATCH"], str(thread), str(seconds)],
        env={k: v for k, v in os.environ.items() if k != "LD_PRELOAD"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        return {"refused": done.returncode}
    return {number: int(n) for number, n in (line.split() for line in done.stdout.splitlines())}


def threads() -> set[int]:
    """Kernel ids of the threads of this process."""
    return {int(t) for t in os.listdir("/proc/self/task")}


def simulation(method: str, rate: float, scene: _core.Snapshot) -> _core.Simulation:
    """A simulation of both arms above the organ, with three spheres on the shaft."""
    loaded(method)
    shaft = Arm.psm("lnd").link_names.index("shaft")
    spheres = [_core.ToolSphere(np.array([0.0, 0.0, -0.004 * k]), 0.004, shaft) for k in range(3)]
    return loop_rig.simulation(scene, press(), method=method, rate=rate, contact__spheres=spheres)


def contacts(rows: np.ndarray) -> int:
    """Number of ticks in contact."""
    return int((as_ticks(rows)["contacts"] > 0).sum())


def capsule(x: float) -> _core.ToolCapsule:
    """A capsule of 4 mm radius along the axis of the tool, displaced by x [m]."""
    ends = (_core.ToolSphere(np.array([x, 0.0, z]), 0.004) for z in (0.0, -0.05))
    return _core.ToolCapsule(*ends, 0.004)


def realtime(method: str, rate: float, seconds: float) -> dict[str, object]:
    """Count calls of the loop's thread while another thread replaces scenes and changes controls."""
    live = organ_scene(20_000, live=True)
    other = organ_scene(3_000) if method.startswith("paper") else solids_scene()  # those methods need triangles
    scenes = [live, live, other, organ_scene(3_000, lift=0.001)]
    lists = [fixtures(), fixtures(0.5)]
    sim, partner = simulation(method, rate, scenes[0]), simulation(method, rate, scenes[0])
    join_instruments([sim, partner], [[capsule(0.0)], [capsule(0.003)]], 10.0, 0.1)  # they overlap all the time
    before = threads()
    sim.set_live(targets(0.0))
    sim.start()
    new = sorted(threads() - before)
    time.sleep(0.2)  # start-up time
    stop = threading.Event()
    swaps = 0

    def swap() -> None:
        nonlocal swaps
        while not stop.wait(0.02):
            swaps += 1
            sim.set_fixtures(lists[swaps % 2])
            sim.set_snapshot(scenes[swaps % len(scenes)])
            if swaps % len(scenes) == 0:
                sim.set_live(targets(float(as_ticks(sim.latest().reshape(1, -1))["t"][0])))
            controls = _core.Controls()
            controls.stiffness_scale = 1.0 - 0.1 * (swaps % 2)
            controls.lock_rotation, controls.scale = swaps % 3 == 1, 0.5 - 0.05 * (swaps % 2)
            controls.clutch, controls.camera, controls.hold_all = swaps % 7 == 4, swaps % 7 == 5, swaps % 7 == 6
            controls.quat_WL = np.eye(4)[0] if swaps % 4 == 3 else np.zeros(4)
            sim.controls = controls

    start, ticks0 = {t: counts(t) for t in new}, int(sim.timing()["ticks"])
    main0 = counts(threading.get_native_id())
    swapper = threading.Thread(target=swap)
    swapper.start()
    rows, end = [], time.monotonic() + seconds
    while time.monotonic() < end or (swaps < 40 and time.monotonic() < end + 60.0):  # a busy machine replaces seldom
        time.sleep(0.05)
        rows.append(sim.drain())
    ticks = int(sim.timing()["ticks"]) - ticks0
    used = {t: (counts(t) - start[t]).tolist() for t in new}
    main = (counts(threading.get_native_id()) - main0).tolist()
    stop.set()
    swapper.join()
    sim.stop()
    rows.append(sim.drain())
    last = as_ticks(np.concatenate(rows))[-1]
    return {
        "threads": [used[t] for t in new],
        "main": main,
        "ticks": ticks,
        "swaps": swaps,
        "contact_ticks": contacts(np.concatenate(rows)),
        "last_force": last["F_H_L"].tolist(),
        "last_gravity": last["tau_gravity"].tolist(),
    }


def planted(method: str, rate: float) -> dict[str, object]:
    """Counts of the loop's thread while calls of each kind are planted in it, and its system calls without and with."""
    sim = simulation(method, rate, organ_scene(3_000))
    before = threads()
    sim.start()
    (thread,) = threads() - before
    time.sleep(0.2)  # start-up time
    found: dict[str, object] = {}
    for kind, name in enumerate(("nothing", "allocation", "lock", "trylock", "condition")):
        guard.heap_guard_plant_in_loop(kind)
        start = counts(thread)
        time.sleep(0.2)
        found[name] = (counts(thread) - start).tolist()
    for kind, name in ((0, "system_calls"), (5, "system_calls_planted")):
        guard.heap_guard_plant_in_loop(kind)
        found[name] = system_calls(thread, 0.3)
    guard.heap_guard_plant_in_loop(0)
    sim.stop()
    return found


def linked(sim: _core.Simulation, scene: _core.Snapshot) -> Callable[[], None]:
    """Links the loop to a follower in a thread of its own; returns what ends it, and the exchange of packets."""
    hand = _network.LoopEnd(_network.LoopEndOptions(), scene)
    start = loop_rig.options().X_WB @ Arm.psm("lnd").fk(loop_rig.Q_FOLLOWER)  # another place would be approached slowly
    follower = _network.Follower(_network.FollowerOptions(), scene, scene, start)
    sim.attach(hand)
    follower.start()
    done = threading.Event()

    def exchange() -> None:
        while not done.wait(2e-3):
            for one, other in ((hand, follower), (follower, hand)):
                other.receive(one.packet(), time.monotonic())

    pump = threading.Thread(target=exchange)
    pump.start()

    def end() -> None:
        done.set()
        pump.join()
        follower.stop()
        sim.attach(None)
        assert hand.state().received > 100

    return end


def beside(what: str) -> dict[str, object]:
    """Counts of the threads of the loop and of what steps beside it, without and with a planted call.

    soft: a soft body; bodies: rigid ones; linked: the follower's end of a link.
    """
    after = ExitStack()
    if what == "bodies":
        sim, world = among_bodies()
    else:
        scene = soft_scene("own") if what == "soft" else organ_scene(3_000)
        sim = simulation("proxy", 1000.0, scene)
    before = threads()
    if what == "bodies":
        world.start()
        after.callback(world.stop)
    if what == "linked":
        after.callback(linked(sim, scene))
    sim.start()
    new = sorted(threads() - before - {t.native_id for t in threading.enumerate()})
    time.sleep(0.2)  # start-up time
    found: dict[str, object] = {"contact_ticks": 0}
    for kind, name in enumerate(("nothing", "allocation")):
        guard.heap_guard_plant_in_loop(kind)
        start = [counts(thread) for thread in new]
        time.sleep(0.6)
        found[name] = [(counts(thread) - old).tolist() for thread, old in zip(new, start, strict=True)]
    guard.heap_guard_plant_in_loop(0)
    sim.stop()
    after.close()
    found["contact_ticks"] = contacts(sim.drain())
    return found


def other_law(law: str) -> _core.Simulation:
    """A simulation with another control law and with all options on."""
    changes = {"torque__law": law, "torque__laws__shape_inertia": True, "torque__friction__gain": 0.7}
    leader = Arm.mtm("right").leader_options()
    for name in ("coulomb", "viscous"):
        changes[f"torque__friction__{name}"] = getattr(leader, name)
    changes |= {"torque__rotor_inertia": leader.rotor_inertia, "leader__cell_noise": 0.02}
    return loop_rig.simulation(organ_scene(20_000), press(), **changes)


def identified() -> _core.Simulation:
    """A simulation with an identified gravity model with every kind of term in arm and controller."""
    arm = Arm.mtm("right")
    centres = np.random.default_rng(0).uniform(-0.5, 0.5, (60, 3))
    terms = _core.GravityTerms(degree=4, fields=[_core.Field([0, 1, 2], centres, [0.9, 0.5, 1.5])])
    arm.set_gravity_model(terms, np.concatenate([arm.moments, np.zeros(35), np.full(60, 1e-4)]))
    return loop_rig.simulation(organ_scene(20_000), press(), leader=arm)


def estimating() -> _core.Simulation:
    """A simulation with a follower with drives, whose torques give the force estimate."""
    options = Arm.psm("lnd").follower_options()
    changes = {"source": "both", "follower__driven": True, "follower__drives": options.drives}
    return loop_rig.simulation(organ_scene(20_000), press(), **changes)


def fixtures(gain: float = 1.0) -> _guidance.Fixtures:
    """Fixtures of every role and law, soft and hard, with ramps, near the hand; some contradict each other."""
    made, line = [], _guidance.LineGeometry(np.zeros(3), np.array([0.1, 0.0, 0.0]), True)
    ball = _guidance.SurfaceGeometry(_core.Sphere(0.012))
    law, role = _core.GuidanceLawOptions(), _core.GuidanceRoleOptions()
    law.K, role.speed, role.force = 300.0 * gain, 0.05, 1.0
    for i, name in enumerate(_guidance.guidance_roles()):
        for j, how in enumerate(_guidance.guidance_laws()):
            policy = _core.Policy()
            policy.hard, policy.priority = (i + j) % 3 == 0, j
            policy.ramps = [_core.Ramp("distance", 0.2, 0.0), _core.Ramp("force", 9.0, 1.0)]
            geometry = {"guide": line, "orient": line, "rcm": _guidance.PointGeometry()}.get(name, ball)
            made.append(_guidance.Fixture(f"{name} {how}", geometry, name, role, how, law, policy))
    return _guidance.Fixtures(made)


def guided() -> _core.Simulation:
    """A simulation with all guidance features and contact."""
    sim = loop_rig.simulation(organ_scene(20_000), press())
    sim.set_fixtures(fixtures())
    return sim


def other_arm(name: str) -> _core.Simulation:
    """A simulation with another arm on both sides."""
    scene = f"objects: [{{shape: organ}}]\narms: {{leader: {{model: {name}}}, follower: {{model: {name}}}}}\n"
    quick = "operator: {palpate: {approach: 0.3, press: 0.3, slide: 2.0, leave: 0.3}}\n"
    return build(Scene.parse(scene + quick)).simulation()


def among_bodies() -> tuple[_core.Simulation, World]:
    """A simulation that presses an organ, while bodies roll off it, leave the field, and hang in a thread."""
    ball = "{name: ball, mass: 0.005, parts: [{sphere: 0.004}], pose: {xyz: [0.01, 0, 0.03]}, thread: {}}"
    box = "{name: box, parts: [{box: [0.006, 0.006, 0.006]}], pose: {xyz: [-0.02, 0, 0.03]}}"
    quick = "operator: {palpate: {approach: 0.3, press: 0.3, slide: 2.0, leave: 0.3}}\n"
    rig = build(Scene.parse(f"objects: [{{shape: organ}}]\nbodies: [{ball}, {box}]\n" + quick))
    sim = rig.simulation()
    world = held.join({"": rig}, [sim])
    assert world is not None
    return sim, world


def lockstep(method: str, what: str = "organ") -> dict[str, object]:
    """Counts of calls of n ticks; equal counts for different n mean that a tick allocates nothing."""
    if what in ("impedance", "admittance"):
        sim = other_law(what)
    elif what in ("identified", "estimating", "guided"):
        sim = {"identified": identified, "estimating": estimating, "guided": guided}[what]()
    elif what == "live":
        sim = simulation(method, 1000.0, organ_scene(20_000, live=True))
        sim.set_live(targets(0.0))
    elif what == "cloud":
        sim = simulation(method, 1000.0, cloud_scene())
        still = _core.LiveTargets()
        still.add(0.0, np.eye(4), np.zeros(6))
        sim.set_live(still)
    elif what in ("six_axis", "delta"):
        sim = other_arm(what)
    elif what == "bodies":
        sim, _ = among_bodies()
    else:
        scene = {"solids": solids_scene, "soft": soft_scene}.get(what, lambda: organ_scene(20_000))
        sim = simulation(method, 1000.0, scene())
    me, counted, touched = threading.get_native_id(), [], 0
    if what == "executing":  # a planned motion moves the tool a little, from a place in contact
        touched = contacts(sim.run(1200))
        q = np.tile(as_ticks(sim.latest().reshape(1, -1))[0]["q_follower_goal"][:6], (1000, 1))
        q[:, 0] += 0.01 * np.sin(np.linspace(0.0, 2.0 * np.pi, 1000))
        sim.execute(q, np.gradient(q, 0.01, axis=0), 0.01, np.full(6, 0.1), until=9.0, guard=1e9)
    for n in (700, 700, 7, 2000, 7):
        before = counts(me)
        rows = sim.run(n)
        counted.append((counts(me) - before).tolist())
        touched += contacts(rows)
    if what == "executing":
        assert 3.0 < as_ticks(rows)[-1]["execution_t"] < 3.5
    return {"calls": counted, "contact_ticks": touched}


def robot(what: str) -> dict[str, object]:
    """Counts of calls of n ticks of a simulated dVRK, including events that are not read."""
    system = dvrk.system(("MTMR", "MTML", "PSM1", "PSM2", "ECM"))
    system.send("system", "home")
    system.step(24_000)
    if what == "following":
        system.send("console", "teleop/enable", True)
        system.send("console", "emulate_operator_present", 1)
        system.step(12_000)
        for gripper in (0.0, 1.0, 0.3):
            system.send("MTMR", "hand/gripper", gripper)
            system.step(300)
        system.send("MTMR_PSM1", "following/mtm/body/servo_cf", [0.0, 0.2, 0.3, 0.0, 0.0, 0.0])
    if what == "impedance":
        wall = {"p": [-200.0] * 3, "d": [-5.0] * 3}
        system.send("MTMR", "servo_ci", {"position_positive": wall, "position_negative": wall})
        system.send("MTML", "body/servo_cf", [0.0] * 6)
        system.send("MTML", "lock_orientation", system.state("MTML")["measured_cp"][:3, :3])
        system.send("footpedals", "emulate_clutch", 1)
    if what == "moving":
        system.send("MTMR", "move_jp", [0.2, 0.3, 0.1, -0.4, 1.2, 0.3, 0.5])
        system.send("PSM1", "move_jp", [0.5, 0.3, 0.2, 1.0, 0.5, -0.5])
        system.send("MTML", "emulate_fault", "on purpose")
    if what == "carried":
        system.send("SUJ", "set_reference_arm", "ECM")
        system.send("SUJ/PSM1", "move_jp", [0.1, 0.2, -0.3, 0.1, 0.2, 0.1])
        system.send("console", "teleop/enable", True)
        system.send("console", "emulate_operator_present", 1)
        system.send("console", "emulate_camera", 1)
        system.send("endoscope_focus", "focus_in", True)
        system.send("ECM", "set_endoscope_type", "SD_UP")
        system.send("PSM2", "emulate_arm_clutch", 1)
    me, counted = threading.get_native_id(), []
    for n in (300, 300, 3, 6000, 3):
        before = counts(me)
        system.step(n)
        counted.append((counts(me) - before).tolist())
    return {"calls": counted, "following": system.teleop("MTMR_PSM1")["following"]}


def geometries() -> dict[str, object]:
    """Counts of n queries of every kind of geometry, at near and distant points."""
    ball, box = _guidance.SurfaceGeometry(_core.Sphere(0.03)), _guidance.SurfaceGeometry(_core.Box(np.full(3, 0.05)))
    vertices, triangles = analytic.Sphere(0.03).mesh(20_000)
    course = curve.path(0.01 * np.random.default_rng(0).normal(size=(40, 3)), crossing=0.0)
    live = _core.LiveFrame()
    shapes = {
        "point": _guidance.PointGeometry(),
        "line": _guidance.LineGeometry(np.zeros(3), np.ones(3)),
        "path": course,
        "tube": _guidance.OffsetGeometry(course, 0.002),
        "cone": _guidance.ConeGeometry(np.zeros(3), np.ones(3), 0.3),
        "mesh": _guidance.SurfaceGeometry(_core.Mesh(vertices, triangles)),
        "cloud": _guidance.SurfaceGeometry(_core.Cloud(vertices, 0.001)),
        "combined": _guidance.CombinedGeometry("difference", [ball, box], 0.002),
        "placed": _guidance.PlacedGeometry(ball, np.eye(4), live),
    }
    X = np.tile(np.eye(4), (3000, 1, 1))
    X[:, :3, 3] = np.random.default_rng(1).normal(size=(3000, 3)) * np.logspace(-3, 6, 3000)[:, None]
    me, counted = threading.get_native_id(), {}
    for name, shape in shapes.items():
        counted[name] = []
        for n in (300, 300, 1000, 3000):
            part = np.ascontiguousarray(X[:: 3000 // n])
            before = counts(me)
            _verify.time_query(shape, part)
            counted[name].append((counts(me) - before).tolist())
    return counted


def crtk() -> dict[str, object]:
    """The different counts of a step, with its messages, of the cycle of networked devices, with and without a scene.

    The arm is never reported as enabled, so a step returns no wrench and takes the same calls of Python; operating
    states are not required, so all other parts of the cycle run, in contact, in faults and after them.
    """
    import crtk_rig

    me, counted, touched = threading.get_native_id(), {}, 0

    def steps(
        name: str, device: crtk_rig.Device, n: int, depth: float, stamp: float | None = None, plant: bool = False
    ) -> None:
        nonlocal touched
        p, quat = device.pose(depth)
        zero, made = np.zeros(3), set()
        device.cycle.set_gates(device.gates)
        for k in range(n + 50):
            device.t += crtk_rig.DT
            time = device.wall if stamp is None else stamp
            before = counts(me)
            device.cycle.leader_twist(time, zero, zero, device.t, device.wall)
            device.cycle.leader_pose(time, p, quat, device.t, device.wall)
            if plant and k % 100 == 99:
                guard.heap_guard_plant(1)
            device.cycle.step(device.t, device.wall)
            if k >= 50:
                made.add(tuple((counts(me) - before).tolist()))
        counted[name] = sorted(made)
        touched += contacts(np.array([device.cycle.step(device.t, device.wall)[0]]))

    device = crtk_rig.Device(scene=organ_scene(20_000), needs_state=False)
    device.gates.leader_enabled = False
    blind = crtk_rig.Device(needs_state=False, scene=False)
    steps("no scene", blind, 500, 0.0)
    device.run(0.3)
    steps("free", device, 500, 0.0)
    device.run(0.5, to=0.034)
    steps("pressed", device, 500, 0.034)
    steps("bad stamps", device, 500, 0.034, stamp=0.0)
    steps("recovered", device, 500, 0.034)
    steps("planted", device, 500, 0.034, plant=True)
    return {"counts": counted, "contact_ticks": touched}


def device(what: str) -> dict[str, object]:
    """Counts of calls that make 200 to 2000 steps of a device's cycle: free, pressed, and with bad states.

    linked: across a network, both ends of which and the far tool run in the cycle.
    """
    import crtk_rig

    rig, scene = crtk_rig.Device(needs_state=False), organ_scene(20_000)
    cycle = _core.DeviceCycle(rig.options, Arm.psm("lnd"), scene)
    if what == "linked":
        cycle.attach(_network.EmulatedEnd(_network.EmulatedOptions(), scene, scene))
    cycle.start()
    me, counted, t = threading.get_native_id(), {}, 0.0
    down = np.linspace(0.0, 0.034, 2000)
    paths = {
        "free": 0.0 * down,
        "pressing": down,
        "pressed": 0.034 + 0.0 * down,
        "bad": down * np.nan,
        "back": 0.0 * down,
    }
    for name, depths in paths.items():
        counted[name] = []
        for n in (200, 200, 500, 2000):
            X, F = np.tile(rig.X0, (n, 1, 1)), np.zeros((n, 6))
            X[:, :3, 3] += np.resize(depths[:: max(1, 2000 // n)], n)[:, None] * rig.down
            times = t + 1e-3 * np.arange(1, n + 1)
            t = float(times[-1])
            before = counts(me)
            cycle.replay(times, X, F)
            counted[name].append((counts(me) - before).tolist())
    before = counts(me)
    drained = cycle.drain()
    rows = as_ticks(drained)
    linked = int(((rows["contacts"] > 0) & (rows["remote_link"] == 2.0)).sum())
    return {
        "calls": counted,
        "contact_ticks": contacts(drained),
        "linked_ticks": linked,
        "control": (counts(me) - before).tolist(),
    }


def haply(seconds: float) -> dict[str, object]:
    """Count calls of the threads of a Haply's session: sound answers, malformed and late ones, a service that hangs."""
    from palpate.devices.haply.driver import Haply
    from palpate.devices.haply.stand_in import Options, StandIn
    from palpate.devices.native import NativeLoop

    scene = Scene.parse("objects: [{name: one, plane: {}, stiffness: 400}]\narms: {leader: {driver: haply}}\n")
    with StandIn(0, Options(idle_after=1.0)) as service:
        loop = NativeLoop(scene, "haply", Haply(f"url=ws://127.0.0.1:{service.port},rate=500").native())
        before = threads()
        loop.start()
        time.sleep(0.3)
        new = sorted(threads() - before)
        counted = {}
        for fault in ("none", "malformed", "late", "sleep", "stall", "ebrake", "hang"):
            if fault != "none":
                service.fail(fault, 0.015)
            begin = [counts(t) for t in new]
            time.sleep(seconds if fault != "hang" else 0.3)
            counted[fault] = [(counts(t) - b).tolist() for t, b in zip(new, begin, strict=True)]
            service.mend(fault)
            time.sleep(0.05)
        answers, control = loop.driver.exchanges, counts(threading.get_native_id()).tolist()
        loop.stop()
    return {"calls": counted, "exchanges": answers, "control": control, "notices": loop.notices()}


if __name__ == "__main__":
    mode, method, *rest = sys.argv[1:]
    if mode == "robot":
        found = {case: robot(case) for case in (method, *rest)}
    elif mode == "planted":
        found = planted(method, *map(float, rest))
    elif mode == "beside":
        found = beside(method)
    elif mode == "crtk":
        found = crtk()
    elif mode == "device":
        found = device(method)
    elif mode == "haply":
        found = haply(float(rest[0]))
    elif mode == "geometries":
        found = geometries()
    else:
        steps = {case: lockstep(method, case) for case in rest} if mode == "lockstep" else {}
        found = steps or realtime(method, *map(float, rest))
    print(json.dumps(found))
