"""A simulated dVRK, and the node that makes its master feel a scene: ros2 launch palpate_ros simulated.launch.py."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node


def generate_launch_description():
    """The simulated arms, and haptics.launch.py with its arguments."""
    robot = Node(package="palpate_ros", executable="sim", output="screen")
    haptics = PythonLaunchDescriptionSource(str(Path(__file__).with_name("haptics.launch.py")))
    return LaunchDescription([robot, IncludeLaunchDescription(haptics)])
