"""Trains, then tests: ros2 launch evac_bringup train.launch.py scenario:=concave.

'evac train' starts the nodes, watches them and ends them; its --help has all options.
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

# Empty: as 'evac train' has it.
OPTIONS = {
    "scenario": "the room, or mixed: one of all, drawn for each episode",
    "preset": "the hyperparameters: robust or paper",
    "episodes": "training episodes",
    "seed": "the run is a function of it",
    "evaluation_episodes": "episodes of the test after the training",
    "simulators": "how many simulators the agent learns in at once",
    "out": "where the run's files go",
    "resume": "go on from the checkpoint in out: true or false",
}


def evac(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The launcher, with the options that were given."""
    values = {name: LaunchConfiguration(name).perform(context) for name in OPTIONS}
    options = [f"--{name.replace('_', '-')}={value}" for name, value in values.items() if value]
    return [
        Node(
            package="evac_bringup",
            executable="evac",
            arguments=["train", *options],
            output="screen",
            on_exit=Shutdown(reason="the training has ended"),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Describes the launch."""
    declared = [
        DeclareLaunchArgument(name, default_value="", description=description)
        for name, description in OPTIONS.items()
    ]
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
    return LaunchDescription([*declared, show, OpaqueFunction(function=evac), rviz])
