"""Drives with a trained model: ros2 launch evac_bringup drive.launch.py model:=runs/empty-robust-seed0.

'evac drive' starts the nodes, watches them and ends them; its --help has all options.
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

# Empty: as 'evac drive' has it.
OPTIONS = {
    "model": "the directory of a training",
    "scenario": "the simulator's room",
    "seed": "other rooms",
    "frame_rate": "images a second",
    "motion_time": "how long a move of the simulator's robot takes, in seconds",
    "settle_time": "how long after an image that it has answered the agent waits, in seconds",
}


def evac(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The launcher, with the options that were given."""
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
            on_exit=Shutdown(reason="the drive has ended"),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Describes the launch."""
    declared = [
        DeclareLaunchArgument(name, default_value="", description=description)
        for name, description in OPTIONS.items()
    ]
    simulator = DeclareLaunchArgument(
        "simulator", default_value="true", description="a simulator takes the robot's place"
    )
    show = DeclareLaunchArgument(
        "rviz", default_value="false", description="show room, robot, path and image in RViz"
    )
    configuration = PathJoinSubstitution([FindPackageShare("evac_bringup"), "rviz", "evac.rviz"])
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", configuration],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    return LaunchDescription([*declared, simulator, show, OpaqueFunction(function=evac), rviz])
