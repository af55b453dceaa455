"""Writes the bag of a CRTK session with known numbers, with the library rosbags: an MTM under a force in motion."""

from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

from palpate.arm import Arm

RATE, SECONDS = 200.0, 2.0
STATE = "std_msgs/Header header\nstring state\nbool is_homed\nbool is_busy\n"


def motion(t: float) -> np.ndarray:
    return np.array([0.1, -0.1, 0.2, 0.0, 0.3, -0.2, 0.1]) + 0.1 * np.sin(3.0 * t)


def force(t: float) -> np.ndarray:
    """Force (3,) [N], in the axes of the tip before 1 s and in those of the base afterwards."""
    return np.array([0.0, 0.0, 2.0 * np.sin(np.pi * t)]) if t < 1.5 else np.array([0.0, 0.0, 1.0])


def tool(t: float) -> np.ndarray:
    """Position (3,) of the follower's tip [m]."""
    return np.array([0.01 * np.sin(2.0 * t), 0.02, -0.1])


def write(folder: Path, plugin: StoragePlugin = StoragePlugin.MCAP, follower: bool = True, named: str = "MTMR",
          posed: bool = False, cameras: bool = False) -> Path:  # fmt: skip
    """`posed` adds poses of the follower, `cameras` two cameras at 25 Hz whose pictures become brighter.

    The wrench is repeated until 1.6 s and then stays at 1 N; an arm without a timeout pushes for 0.4 s more.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(STATE, "crtk_msgs/msg/OperatingState"))
    T = store.types
    stamp, Header = T["builtin_interfaces/msg/Time"], T["std_msgs/msg/Header"]
    Vector3, Wrench = T["geometry_msgs/msg/Vector3"], T["geometry_msgs/msg/Wrench"]
    leader, psm = Arm.mtm("right"), Arm.psm()

    def head(t):
        return Header(stamp(int(1e9 + t) - int(1e9) + 100, int((t % 1.0) * 1e9)), named)

    with Writer(folder, version=9, storage_plugin=plugin) as bag:
        topics = {}

        def send(topic, kind, t, message):
            if topic not in topics:
                topics[topic] = bag.add_connection(topic, kind, typestore=store)
            bag.write(topics[topic], int(1e9 * (100.0 + t)), store.serialize_cdr(message, kind))

        Joints, Pose = T["sensor_msgs/msg/JointState"], T["geometry_msgs/msg/Pose"]
        Bool, State = T["std_msgs/msg/Bool"], T["crtk_msgs/msg/OperatingState"]
        send(f"/{named}/operating_state", "crtk_msgs/msg/OperatingState", 0.0, State(head(0.0), "ENABLED", True, False))
        send(f"/{named}_PSM1/following", "std_msgs/msg/Bool", 0.0, Bool(True))
        for k in range(int(RATE * SECONDS)):
            t = k / RATE
            q = motion(t)
            X = leader.fk(q)
            x, y, z, w = Rotation.from_matrix(X[:3, :3]).as_quat()
            names = [f"j{i}" for i in range(7)]
            js = Joints(head(t), names, q, 0.3 * np.cos(3.0 * t) * np.ones(7), np.zeros(7))
            send(f"/{named}/measured_js", "sensor_msgs/msg/JointState", t, js)
            pose = Pose(T["geometry_msgs/msg/Point"](*X[:3, 3]), T["geometry_msgs/msg/Quaternion"](x, y, z, w))
            stamped = T["geometry_msgs/msg/PoseStamped"](head(t), pose)
            send(f"/{named}/measured_cp", "geometry_msgs/msg/PoseStamped", t, stamped)
            if follower:
                js = Joints(head(t), names[:6], psm.home, np.zeros(6), np.zeros(6))
                send("/PSM1/measured_js", "sensor_msgs/msg/JointState", t, js)
            if posed:
                tip = Pose(
                    T["geometry_msgs/msg/Point"](*tool(t)), T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
                )
                for name in ("measured_cp", "setpoint_cp"):
                    stamped = T["geometry_msgs/msg/PoseStamped"](head(t), tip)
                    send(f"/PSM1/{name}", "geometry_msgs/msg/PoseStamped", t, stamped)
            if cameras and k % 8 == 0:
                _shoot(T, send, head(t), t)
            if k == int(RATE):
                send(f"/{named}/body/set_cf_orientation_absolute", "std_msgs/msg/Bool", t, Bool(True))
            if t <= 1.6:
                wrench = Wrench(Vector3(*force(t)), Vector3(0.0, 0.0, 0.0))
                stamped = T["geometry_msgs/msg/WrenchStamped"](head(t), wrench)
                send(f"/{named}_PSM1/following/mtm/body/servo_cf", "geometry_msgs/msg/WrenchStamped", t, stamped)
    return folder


def _shoot(T, send, header, t: float) -> None:
    """A raw picture of the left camera, a JPEG of the right one, and their CameraInfo."""
    picture = shown(t)
    left = T["sensor_msgs/msg/Image"](
        header, 482, 640, "bgr8", 0, 1920, np.ascontiguousarray(picture[:, :, ::-1]).ravel()
    )
    send("/davinci/left/image_raw", "sensor_msgs/msg/Image", t, left)
    right = T["sensor_msgs/msg/CompressedImage"](header, "jpeg", jpeg(picture))
    send("/davinci/right/image_raw/compressed", "sensor_msgs/msg/CompressedImage", t, right)
    for side, shift in (("left", 0.0), ("right", -0.005)):
        K = np.array([700.0, 0, 320, 0, 701, 241, 0, 0, 1])
        P = np.array([700.0, 0, 320, 700 * shift, 0, 701, 241, 0, 0, 0, 1, 0])
        roi = T["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
        D = np.array([-0.1, 0.01, 0, 0, 0])
        info = T["sensor_msgs/msg/CameraInfo"](header, 482, 640, "plumb_bob", D, K, np.eye(3).ravel(), P, 0, 0, roi)
        send(f"/davinci/{side}/camera_info", "sensor_msgs/msg/CameraInfo", t, info)


def shown(t: float) -> np.ndarray:
    """Picture (482, 640, 3): red grows with time, green marks the left half."""
    picture = np.zeros((482, 640, 3), np.uint8)
    picture[:, :, 0] = round(40 + 80 * t)
    picture[:, :320, 1] = 150
    return picture


def jpeg(picture: np.ndarray) -> np.ndarray:
    from fractions import Fraction

    import av

    codec = av.CodecContext.create("mjpeg", "w")
    codec.height, codec.width = picture.shape[:2]
    codec.pix_fmt, codec.time_base = "yuvj444p", Fraction(1, 25)
    frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
    packets = [*codec.encode(frame), *codec.encode()]
    return np.frombuffer(b"".join(bytes(one) for one in packets), np.uint8)
