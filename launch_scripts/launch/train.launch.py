"""Starts simulator and agent, and trains: ros2 launch evac_bringup train.launch.py scenario:=concave."""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

ARGUMENTS = {
    "scenario": ("empty", "the room, or mixed: one of the eight, drawn for each episode"),
    "preset": ("robust", "the hyperparameters: robust or paper"),
    "episodes": ("", "training episodes; empty: the preset's"),
    "seed": ("0", "the run is a function of it"),
    "evaluation_episodes": ("1000", "episodes of the test after the training"),
    "out": ("", "where the run's files go; empty: runs/SCENARIO-PRESET-seedN"),
    "resume": ("false", "go on from the checkpoint in out"),
    "rviz": ("false", "show room, robot, path and image in RViz"),
}
TEXTS = ("scenario", "preset", "out")


def agent(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The agent, with the parameters that were given."""
    parameters = {}
    for name in ARGUMENTS:
        value = LaunchConfiguration(name).perform(context)
        if name == "rviz" or not value:
            continue
        if name in TEXTS:
            parameters[name] = value
        elif name == "resume":
            parameters[name] = value.lower() == "true"
        else:
            parameters[name] = int(value)
    return [
        Node(
            package="agent_node",
            executable="agent_node",
            arguments=["train"],
            parameters=[parameters],
            output="screen",
            on_exit=Shutdown(),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Describes the launch."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    # A simulator that was lost is started again; the agent takes the episode up.
    simulator = Node(
        package="sim_node", executable="sim_node", output="screen", respawn=True, respawn_delay=1.0
    )
    configuration = PathJoinSubstitution([FindPackageShare("evac_bringup"), "rviz", "evac.rviz"])
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", configuration],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    return LaunchDescription([*declared, simulator, OpaqueFunction(function=agent), rviz])
