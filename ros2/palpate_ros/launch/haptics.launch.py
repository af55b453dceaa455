"""A CRTK master feels a scene: ros2 launch palpate_ros haptics.launch.py scene:=my.yaml leader:=MTMR follower:=PSM1."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "scene": ("teleop", "scene file, or the name of a shipped scene"),
    "leader": ("MTMR", "CRTK name of the master"),
    "follower": ("PSM1", "CRTK name of the patient-side arm; virtual: no arm"),
    "teleop": ("MTMR_PSM1", "teleoperation component that moves the follower; none: Palpate moves it"),
    "force_cap": ("1.0", "largest force on the hand [N]"),
    "rviz": ("false", "true: show arms, forces and objects"),
}


def generate_launch_description():
    """The haptic node, whose end ends the launch, and RViz."""
    words = [word for name in ("leader", "follower", "teleop") for word in (f"--{name}", LaunchConfiguration(name))]
    node = Node(
        package="palpate_ros",
        executable="haptics",
        output="screen",
        arguments=[LaunchConfiguration("scene"), *words, "--force-cap", LaunchConfiguration("force_cap")],
        on_exit=Shutdown(),
    )
    view = Path(get_package_share_directory("palpate_ros")) / "rviz" / "palpate.rviz"
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(view)],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    declared = [
        DeclareLaunchArgument(name, default_value=value, description=words)
        for name, (value, words) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, node, rviz])
