"""Starts simulator and agent, and trains: ros2 launch evac_bringup train.launch.py scenario:=concave."""

from pathlib import Path

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.events.process import ProcessExited
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
# A panic, and SIGABRT, for want of memory. What the agent says to be an error would be one again.
FAILURES = (101, -6)
MOST_RESTARTS = 3


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The agent, with the parameters that were given."""
    parameters = {}
    for name in ARGUMENTS:
        value = LaunchConfiguration(name).perform(context) or ARGUMENTS[name][0]
        if name == "rviz" or not value:
            continue
        if name in TEXTS:
            parameters[name] = value
        elif name == "resume":
            parameters[name] = value.lower() == "true"
        else:
            parameters[name] = int(value)
    parameters.setdefault("out", "runs/{scenario}-{preset}-seed{seed}".format(**parameters))
    return [agent(parameters)]


def agent(parameters: dict, restarts: int = 0) -> Node:
    """The agent; one that failed is started again, and goes on from its last checkpoint."""

    def ended(event: ProcessExited, _: LaunchContext) -> list[LaunchDescriptionEntity]:
        if event.returncode not in FAILURES or restarts == MOST_RESTARTS:
            return [Shutdown(reason="agent_node has ended")]
        resume = Path(parameters["out"], "checkpoint.safetensors").exists()
        message = f"agent_node failed; it is started again ({restarts + 1} of at most {MOST_RESTARTS} times)"
        return [LogInfo(msg=message), agent({**parameters, "resume": resume}, restarts + 1)]

    return Node(
        package="agent_node",
        executable="agent_node",
        arguments=["train"],
        parameters=[parameters],
        output="screen",
        on_exit=ended,
    )


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
    return LaunchDescription([*declared, simulator, OpaqueFunction(function=start), rviz])
