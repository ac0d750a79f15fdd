"""Drives with a trained model: ros2 launch evac_bringup drive.launch.py model:=runs/empty-robust-seed0."""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, LogInfo, Shutdown
from launch.conditions import IfCondition
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

ARGUMENTS = {
    "model": (None, "the directory of a training"),
    "scenario": ("empty", "the simulator's room"),
    "seed": ("0", "other rooms"),
    "frame_rate": ("20.0", "images a second"),
    "motion_time": ("0.1", "how long a move of the simulator's robot takes, in seconds"),
    "settle_time": ("0.2", "how long after an image that it has answered the agent waits, in seconds"),
    "simulator": ("true", "a simulator takes the robot's place"),
    "rviz": ("false", "show room, robot, path and image in RViz"),
}

# A panic, and SIGABRT, for want of memory. What the agent says to be an error would be one again.
FAILURES = (101, -6)
MOST_RESTARTS = 3


def value(name: str, kind: type) -> ParameterValue:
    """An argument as a parameter of a type."""
    return ParameterValue(LaunchConfiguration(name), value_type=kind)


def agent(restarts: int = 0) -> Node:
    """The agent; one that failed is started again."""

    def ended(event: ProcessExited, _: LaunchContext) -> list[LaunchDescriptionEntity]:
        if event.returncode not in FAILURES or restarts == MOST_RESTARTS:
            return [Shutdown(reason="agent_node has ended")]
        message = f"agent_node failed; it is started again ({restarts + 1} of at most {MOST_RESTARTS} times)"
        return [LogInfo(msg=message), agent(restarts + 1)]

    return Node(
        package="agent_node",
        executable="agent_node",
        arguments=["drive"],
        parameters=[
            {"model": value("model", str), "settle_time": value("settle_time", float)},
        ],
        output="screen",
        on_exit=ended,
    )


def generate_launch_description() -> LaunchDescription:
    """Describes the launch."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    simulator = Node(
        package="sim_node",
        executable="sim_node",
        parameters=[
            {
                "scenario": value("scenario", str),
                "seed": value("seed", int),
                "frame_rate": value("frame_rate", float),
                "motion_time": value("motion_time", float),
                "auto_reset": True,
            }
        ],
        output="screen",
        respawn=True,
        respawn_delay=1.0,
        condition=IfCondition(LaunchConfiguration("simulator")),
    )
    configuration = PathJoinSubstitution([FindPackageShare("evac_bringup"), "rviz", "evac.rviz"])
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", configuration],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    return LaunchDescription([*declared, simulator, agent(), rviz])
