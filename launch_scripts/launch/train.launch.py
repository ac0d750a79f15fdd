"""Trains the agent, then evaluates it.

    ros2 launch evac_bringup train.launch.py scenario:=concave

'evac train' starts, supervises and stops the nodes; 'evac train --help' lists all options.
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

# Options that are passed on to 'evac train'. An empty value keeps the default.
OPTIONS = {
    "scenario": "scenario of all episodes, or mixed to draw one for each episode",
    "preset": "hyperparameters: robust or paper",
    "episodes": "number of training episodes",
    "seed": "random seed of the run",
    "evaluation_episodes": "number of evaluation episodes after training",
    "simulators": "number of simulators that the agent trains in at the same time",
    "out": "output directory of the run",
    "resume": "continue from the checkpoint in out: true or false",
}


def evac(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Returns the launcher process with the given options."""
    values = {name: LaunchConfiguration(name).perform(context) for name in OPTIONS}
    options = [f"--{name.replace('_', '-')}={value}" for name, value in values.items() if value]
    return [
        Node(
            package="evac_bringup",
            executable="evac",
            arguments=["train", *options],
            output="screen",
            on_exit=Shutdown(reason="evac train has exited"),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Returns the launch description."""
    arguments = [
        DeclareLaunchArgument(name, default_value="", description=description)
        for name, description in OPTIONS.items()
    ]
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
    return LaunchDescription([*arguments, use_rviz, OpaqueFunction(function=evac), rviz])
