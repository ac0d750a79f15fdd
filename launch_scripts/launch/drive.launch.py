"""Drives with a trained model.

    ros2 launch evac_bringup drive.launch.py model:=runs/mixed-robust-seed0

'evac drive' starts, supervises and stops the nodes; 'evac drive --help' lists all options.
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

# Options that are passed on to 'evac drive'. An empty value keeps the default.
OPTIONS = {
    "model": "directory of a training run",
    "scenario": "scenario of the simulator; default: that of the training run, or three_moving",
    "seed": "random seed of the simulator",
    "frame_rate": "images per second from the simulator",
    "motion_time": "duration of a move in the simulator, in seconds",
    "settle_time": "minimum difference, in seconds, between the stamps of two images that the agent acts on",
}


def evac(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Returns the launcher process with the given options."""
    values = {name: LaunchConfiguration(name).perform(context) for name in OPTIONS}
    options = [f"--{name.replace('_', '-')}={value}" for name, value in values.items() if value]
    if LaunchConfiguration("simulator").perform(context).lower() == "false":
        options.append("--robot")
    return [
        Node(
            package="evac_bringup",
            executable="evac",
            arguments=["drive", *options],
            output="screen",
            on_exit=Shutdown(reason="evac drive has exited"),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Returns the launch description."""
    arguments = [
        DeclareLaunchArgument(name, default_value="", description=description)
        for name, description in OPTIONS.items()
    ]
    simulator = DeclareLaunchArgument(
        "simulator", default_value="true", description="start a simulator; false: drive a robot"
    )
    use_rviz = DeclareLaunchArgument(
        "rviz", default_value="false", description="show room, robot, path and camera image in RViz"
    )
    configuration = PathJoinSubstitution([FindPackageShare("evac_bringup"), "rviz", "evac.rviz"])
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", configuration],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    return LaunchDescription([*arguments, simulator, use_rviz, OpaqueFunction(function=evac), rviz])
