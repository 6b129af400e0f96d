"""Starts the node: ros2 launch vibrissa_ros2 vibrissa.launch.py map:=arena.svg robot:=robot.toml."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

ARGUMENTS = {
    "params_file": (
        PathJoinSubstitution([FindPackageShare("vibrissa_ros2"), "config", "vibrissa.yaml"]),
        "File of parameters",
    ),
    "map": ("", "Map file (.svg, .geojson, .dxf, .yaml)"),
    "map_topic": ("", "Topic of the map (nav_msgs/OccupancyGrid) where no file is given"),
    "robot": ("", "Robot file (.toml); the whisker of the paper without it"),
    "namespace": ("", "Namespace of the node"),
    "use_sim_time": ("false", "Whether time is that of /clock"),
    "autostart": ("true", "Whether the node activates itself, without a lifecycle manager"),
}


def generate_launch_description():
    """The arguments, and the node that takes them."""
    given = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    texts = {name: ParameterValue(given[name], value_type=str) for name in ("map", "map_topic", "robot")}
    switches = {name: ParameterValue(given[name], value_type=bool) for name in ("use_sim_time", "autostart")}
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=value, description=what) for name, (value, what) in ARGUMENTS.items()]
        + [
            Node(
                package="vibrissa_ros2",
                executable="vibrissa-ros2",
                name="vibrissa",
                namespace=given["namespace"],
                parameters=[given["params_file"], texts, switches],
                output="screen",
            )
        ]
    )
