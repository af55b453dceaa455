"""In which form the commands on the pages are run: their words as printed, and further ones that make them short.

The longest key that begins a line decides. `scenes/wall.yaml` is the scene `wall`, as for the command itself.
"""

_STUDY = "--workers 1 --figures f --out data.nc --json r.json"
_RUN = "--headless --fast --duration 0.05 --out o --json r.json"

#: Lines that `make test` runs, each in less than about half a second; test_requirement_commands.py runs other scenes.
QUICK = {
    "palpate certify": "",
    "palpate check": "",
    "palpate doctor": "disk versions",
    "palpate export": "",
    "palpate frames": "",
    "palpate identify tissue": "",
    "palpate keys": "",
    "palpate register": "",
    "palpate run": _RUN,
}
#: Lines that `make test-long` runs.
LONG = {
    "cc": "",
    "palpate bench contact --organs": "--json r.json",
    "palpate bench contact": "--quick --json r.json",
    "palpate bench growth": "--small --only fixtures",
    "palpate bench viewer": "--duration 1 --json r.json",
    "palpate calibrate dynamics": "",
    "palpate calibrate export": "",
    "palpate calibrate gravity": "",
    "palpate calibrate hand": "",
    "palpate coverage": "--estimate device --trials 2 --workers 1",
    "palpate calibrate import": "",
    "palpate export runs/* --to lerobot --out dataset": "",
    "palpate fuzz loops": "--runs 1 --workers 1",
    "palpate fuzz ports": "--cases 200 --workers 1",
    "palpate plan": "",
    "palpate policy": "--duration 0.2",
    "palpate record": "",
    "palpate register check": "",
    "palpate register session": "",
    "palpate register surface": "",
    "palpate reproduce": "eq1 --out paper --workers 1",
    "palpate run bilateral": _RUN,
    "palpate run breathing": _RUN,
    "palpate run grip": "--headless --fast",
    "palpate run guided": _RUN,
    "palpate run hand_over": _RUN,
    "palpate run planning": _RUN,
    "palpate run remote": _RUN,
    "palpate run soft_grasp": _RUN,
    "palpate run soft_liver": _RUN,
    "palpate run two_hands": _RUN,
    "palpate scan liver": "",
    "palpate soak tissue": "--pokes 2",
    "palpate study contact": _STUDY,
    "palpate study demonstrations": "--episodes 1 --operators 1 --seconds 0.5 --workers 1",
    "palpate study drift": f"--releases 1 {_STUDY}",
    "palpate study force": "--figures f --json r.json",
    "palpate study geometry": "--figures f --json r.json",
    "palpate study guidance --conformance": f"--seeds 1 {_STUDY}",
    "palpate study guidance": f"--operators 5 {_STUDY}",
    "palpate study network": f"--conditions netfi-delay-2 --modes model --runs 1 {_STUDY}",
    "palpate study passivity": f"--runs 2 {_STUDY}",
    "palpate study wall": f"--hands 2 {_STUDY}",
    "palpate study zwidth": f"--rates 1000 --delays 0 {_STUDY}",
}
#: Those of LONG that read recordings which are not shipped (PALPATE_DATA).
RECORDINGS = ("palpate study drift", "palpate bench contact --organs")
#: Lines that a test of another file runs, below tests: they need a robot, a second process or a person's answer.
ELSEWHERE = {
    "palpate experiment": "experiment/test_experiment_command.py",
    "export ROS_SECURITY_KEYSTORE=$PWD/keys": "ros/test_dds_security.py",
    "make setup": "../Makefile",
    "palpate device bench": "devices/test_bench.py",
    "palpate device stand-in": "devices/test_haply_stand_in.py",
    "palpate device test": "devices/test_shared_object.py",
    "palpate ros camera": "ros/test_camera.py",
    "palpate ros device": "ros/test_device_master.py",
    "palpate ros graph": "docs/test_requirement_commands.py",
    "palpate ros haptics": "ros/test_printed_commands.py",
    "palpate ros keystore": "ros/test_dds_security.py",
    "palpate ros move": "ros/test_move.py",
    "palpate ros setup": "ros/test_bridge.py",
    "palpate ros sim": "ros/test_printed_commands.py",
    "palpate ros topic": "ros/test_topic.py",
    "palpate run camera --serve": "cli/test_cli_run.py",
    "palpate run palpation --leader haply": "devices/test_haply.py",
    "palpate run palpation --leader webxr": "viewer/test_xr.py",
    "palpate run two_hands --leader": "devices/test_device_pairs.py",
    "palpate run registration --serve": "cli/test_cli_run.py",
    "palpate run remote --remote": "network/test_remote.py",
    "palpate scan": "cli/test_cli_scan.py",
    "palpate serve": "network/test_remote.py",
    "python examples/04_angle_of_a_face.py": "examples/test_examples.py",
}
