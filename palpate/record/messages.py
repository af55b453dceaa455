"""Definitions (`ros2msg`) of the standard ROS 2 message types in a record, so that any reader can decode them."""

from __future__ import annotations

_SEPARATOR = "=" * 80

_FIELDS = {
    "builtin_interfaces/Time": ("int32 sec", "uint32 nanosec"),
    "std_msgs/Header": ("builtin_interfaces/Time stamp", "string frame_id"),
    "std_msgs/Float64": ("float64 data",),
    "geometry_msgs/Point": ("float64 x", "float64 y", "float64 z"),
    "geometry_msgs/Vector3": ("float64 x", "float64 y", "float64 z"),
    "geometry_msgs/Quaternion": ("float64 x", "float64 y", "float64 z", "float64 w"),
    "geometry_msgs/Wrench": ("geometry_msgs/Vector3 force", "geometry_msgs/Vector3 torque"),
    "geometry_msgs/PointStamped": ("std_msgs/Header header", "geometry_msgs/Point point"),
    "geometry_msgs/Vector3Stamped": ("std_msgs/Header header", "geometry_msgs/Vector3 vector"),
    "geometry_msgs/QuaternionStamped": ("std_msgs/Header header", "geometry_msgs/Quaternion quaternion"),
    "geometry_msgs/WrenchStamped": ("std_msgs/Header header", "geometry_msgs/Wrench wrench"),
    "builtin_interfaces/Duration": ("int32 sec", "uint32 nanosec"),
    "std_msgs/String": ("string data",),
    "std_msgs/ColorRGBA": ("float32 r", "float32 g", "float32 b", "float32 a"),
    "geometry_msgs/Pose": ("geometry_msgs/Point position", "geometry_msgs/Quaternion orientation"),
    "geometry_msgs/Transform": ("geometry_msgs/Vector3 translation", "geometry_msgs/Quaternion rotation"),
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header",
        "string child_frame_id",
        "geometry_msgs/Transform transform",
    ),
    "tf2_msgs/TFMessage": ("geometry_msgs/TransformStamped[] transforms",),
    "std_msgs/MultiArrayDimension": ("string label", "uint32 size", "uint32 stride"),
    "std_msgs/MultiArrayLayout": ("std_msgs/MultiArrayDimension[] dim", "uint32 data_offset"),
    "std_msgs/Int16MultiArray": ("std_msgs/MultiArrayLayout layout", "int16[] data"),
    "sensor_msgs/PointField": ("string name", "uint32 offset", "uint8 datatype", "uint32 count"),
    "sensor_msgs/PointCloud2": (
        "std_msgs/Header header",
        "uint32 height",
        "uint32 width",
        "sensor_msgs/PointField[] fields",
        "bool is_bigendian",
        "uint32 point_step",
        "uint32 row_step",
        "uint8[] data",
        "bool is_dense",
    ),
    "sensor_msgs/CompressedImage": ("std_msgs/Header header", "string format", "uint8[] data"),
    "visualization_msgs/UVCoordinate": ("float32 u", "float32 v"),
    "visualization_msgs/MeshFile": ("string filename", "uint8[] data"),
    "visualization_msgs/Marker": (
        "std_msgs/Header header",
        "string ns",
        "int32 id",
        "int32 type",
        "int32 action",
        "geometry_msgs/Pose pose",
        "geometry_msgs/Vector3 scale",
        "std_msgs/ColorRGBA color",
        "builtin_interfaces/Duration lifetime",
        "bool frame_locked",
        "geometry_msgs/Point[] points",
        "std_msgs/ColorRGBA[] colors",
        "string texture_resource",
        "sensor_msgs/CompressedImage texture",
        "visualization_msgs/UVCoordinate[] uv_coordinates",
        "string text",
        "string mesh_resource",
        "visualization_msgs/MeshFile mesh_file",
        "bool mesh_use_embedded_materials",
    ),
    "visualization_msgs/MarkerArray": ("visualization_msgs/Marker[] markers",),
    "sensor_msgs/JointState": (
        "std_msgs/Header header",
        "string[] name",
        "float64[] position",
        "float64[] velocity",
        "float64[] effort",
    ),
}

TYPE_OF_PART = {
    "data": "std_msgs/msg/Float64",
    "point": "geometry_msgs/msg/PointStamped",
    "vector": "geometry_msgs/msg/Vector3Stamped",
    "quaternion": "geometry_msgs/msg/QuaternionStamped",
    "force": "geometry_msgs/msg/WrenchStamped",
    "position": "sensor_msgs/msg/JointState",
    "velocity": "sensor_msgs/msg/JointState",
    "effort": "sensor_msgs/msg/JointState",
}
"""The message type that carries each part of a record of the first layout (see `palpate.record.per_signal.part`)."""


def _inside(name: str) -> list[str]:
    """The nested message types of a type, each once, outermost first."""
    found: list[str] = []
    for field in _FIELDS[name]:
        inner = field.split()[0].removesuffix("[]")
        if inner in _FIELDS:
            found += [t for t in (inner, *_inside(inner)) if t not in found]
    return found


def nested(names: list[str]) -> str:
    """The definitions of some message types, as they follow that of a message which uses them."""
    return "".join(f"{_SEPARATOR}\nMSG: {name}\n" + "\n".join(_FIELDS[name]) + "\n" for name in names)


def _definition(name: str) -> str:
    return "\n".join(_FIELDS[name]) + "\n" + nested(_inside(name))


_OTHERS = {
    "tf2_msgs/msg/TFMessage",
    "std_msgs/msg/String",
    "visualization_msgs/msg/MarkerArray",
    "std_msgs/msg/Int16MultiArray",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/PointCloud2",
}
DEFINITIONS = {schema: _definition(schema.replace("/msg/", "/")) for schema in sorted(_OTHERS)}
"""Definition text of each message type beside the signals, with its nested types."""
