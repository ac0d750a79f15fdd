#!/usr/bin/env python3
"""Puts a differential-drive robot in the place of Evac's simulator.

The bridge makes of the robot's own camera the 20 x 7 image that the agent knows, and of the agent's
commands velocities for the robot. See docs/robot.md for the contract, and for what the camera must
see. In a workspace with evac_msgs:

    python3 robot_bridge.py --ros-args -r image:=/front_camera/image_rect \
        -r camera_info:=/front_camera/camera_info -r cmd_vel:=/cmd_vel -r odom:=/odom
"""

from __future__ import annotations

import math

import numpy
import rclpy
from evac_msgs.msg import ActionCommand
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import CameraInfo, Image

WIDTH, HEIGHT = 20, 7
# Rays for each pixel of the small image, along each side.
RAYS = 4
TURNS_DEGREES = (-135, -90, -45, 0, 45, 90, 135)
STEP_M = 0.1524
# Bytes of a pixel, and where red, green and blue are in it.
ENCODINGS = {"rgb8": (3, (0, 1, 2)), "bgr8": (3, (2, 1, 0)), "rgba8": (4, (0, 1, 2)),
             "bgra8": (4, (2, 1, 0)), "mono8": (1, (0, 0, 0))}


def rays() -> NDArray[numpy.float64]:
    """The directions that the small image looks in: [7, 20, rays, 3], in the optical frame.

    Its lens is stereographic: 180 degrees from side to side.
    """
    fine = (numpy.arange(RAYS) + 0.5) / RAYS
    column = numpy.add.outer(numpy.arange(WIDTH), fine)
    row = numpy.add.outer(numpy.arange(HEIGHT), fine)
    right = 2 * column / WIDTH - 1
    down = (2 * row - HEIGHT) / WIDTH
    u, v = numpy.broadcast_arrays(right[None, :, None, :], down[:, None, :, None])
    square = u**2 + v**2
    directions = numpy.stack([2 * u, 2 * v, 1 - square], axis=-1) / (1 + square)[..., None]
    return directions.reshape(HEIGHT, WIDTH, RAYS * RAYS, 3)


def pixels(info: CameraInfo) -> tuple[NDArray[numpy.int64], NDArray[numpy.bool_]]:
    """Where a camera has these directions, as [..., (row, column)], and whether it sees them.

    An image is one of a fisheye lens, as `equidistant` describes it, or a rectified one.
    """
    x, y, z = numpy.moveaxis(rays(), -1, 0)
    if info.distortion_model == "equidistant":
        fx, cx, fy, cy = info.k[0], info.k[2], info.k[4], info.k[5]
        k1, k2, k3, k4 = (list(info.d) + [0.0] * 4)[:4]
        angle = numpy.arctan2(numpy.hypot(x, y), z)
        square = angle**2
        distorted = angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
        scale = distorted / numpy.maximum(numpy.hypot(x, y), 1e-9)
        is_ahead = numpy.ones_like(z, dtype=bool)
    else:
        # A pinhole camera, which sees nothing at its sides.
        fx, cx, fy, cy = info.p[0], info.p[2], info.p[5], info.p[6]
        scale = 1 / numpy.maximum(z, 1e-9)
        is_ahead = z > 1e-6
    column = numpy.floor(fx * x * scale + cx + 0.5)
    row = numpy.floor(fy * y * scale + cy + 0.5)
    is_seen = is_ahead & (0 <= column) & (column < info.width) & (0 <= row) & (row < info.height)
    places = numpy.stack([row, column], axis=-1)
    return numpy.where(is_seen[..., None], places, 0).astype(numpy.int64), is_seen


def colours(image: Image) -> NDArray[numpy.uint8]:
    """The pixels of an image as [rows, columns, (red, green, blue)]."""
    if image.encoding not in ENCODINGS:
        known = ", ".join(ENCODINGS)
        raise ValueError(f"the image's encoding is '{image.encoding}': expected one of {known}")
    size, channels = ENCODINGS[image.encoding]
    rows = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.step)
    pixels = rows[:, : image.width * size].reshape(image.height, image.width, size)
    return pixels[:, :, list(channels)]


class RobotBridge(Node):
    """Small images out, velocities out; large images, odometry and commands in."""

    def __init__(self) -> None:
        super().__init__("robot_bridge")
        self.linear = self.declare_parameter("linear_speed", 0.2).value
        self.angular = self.declare_parameter("angular_speed", 1.0).value
        self.longest_s = self.declare_parameter("longest_move", 5.0).value
        self.places: tuple[NDArray[numpy.int64], NDArray[numpy.bool_]] | None = None
        self.size = (0, 0)
        self.seen_at = self.get_clock().now()
        self.pose: tuple[float, float, float] | None = None
        # The command at work: the heading to turn to, then where the straight part began.
        self.heading: float | None = None
        self.start: tuple[float, float] | None = None
        self.began = self.settled = self.get_clock().now()
        self.images = self.create_publisher(Image, "camera/image", 5)
        self.velocities = self.create_publisher(Twist, "cmd_vel", 1)
        sensors = qos_profile_sensor_data
        self.create_subscription(CameraInfo, "camera_info", self.on_camera_info, sensors)
        self.create_subscription(Image, "image", self.on_image, sensors)
        self.create_subscription(Odometry, "odom", self.on_odometry, sensors)
        self.create_subscription(ActionCommand, "action", self.on_action, QoSProfile(depth=1))
        self.create_timer(0.02, self.drive)

    def on_camera_info(self, info: CameraInfo) -> None:
        """Works out once where the camera sees what the small image looks at."""
        if self.places is None:
            self.places = pixels(info)
            self.size = (info.height, info.width)
            share = self.places[1].mean()
            if share < 0.95:
                self.get_logger().warning(
                    f"the camera sees {100 * share:.0f} % of what the agent looks at: the rest is "
                    "black; a wide-angle lens would see it"
                )

    def on_image(self, large: Image) -> None:
        """Publishes the small image, stamped as the large one."""
        if self.places is None:
            self.get_logger().warning("no camera_info yet", throttle_duration_sec=5.0)
            return
        try:
            if (large.height, large.width) != self.size:
                raise ValueError(
                    f"an image of {large.width} x {large.height}: expected"
                    f" {self.size[1]} x {self.size[0]}, as camera_info says"
                )
            seen = colours(large)
        except ValueError as error:
            self.get_logger().error(str(error), throttle_duration_sec=5.0)
            return
        places, is_seen = self.places
        samples = seen[places[..., 0], places[..., 1]] * is_seen[..., None]
        count = numpy.maximum(is_seen.sum(axis=-1), 1)[..., None]
        data = (samples.sum(axis=-2) / count).round().astype(numpy.uint8)
        small = Image(height=HEIGHT, width=WIDTH, encoding="rgb8", step=3 * WIDTH)
        small.header = large.header
        small.data = data.tobytes()
        self.images.publish(small)

    def on_odometry(self, odometry: Odometry) -> None:
        """Remembers where the robot is."""
        pose = odometry.pose.pose
        q = pose.orientation
        yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
        self.pose = (pose.position.x, pose.position.y, yaw)
        self.seen_at = self.get_clock().now()

    def on_action(self, command: ActionCommand) -> None:
        """Takes a command, unless the robot moves or the command answers an old image."""
        if self.pose is None:
            self.get_logger().warning("a command is refused: there is no odometry yet")
        elif self.heading is not None:
            self.get_logger().warning("a command is refused: the robot is moving")
        elif Time.from_msg(command.header.stamp) < self.settled:
            self.get_logger().warning("a command is refused: it answers an old image")
        elif command.action >= len(TURNS_DEGREES):
            self.get_logger().error(f"action {command.action} is refused: expected 0 to 6")
        else:
            self.heading = self.pose[2] + math.radians(TURNS_DEGREES[command.action])
            self.start = None
            self.began = self.get_clock().now()

    def drive(self) -> None:
        """Turns, then goes straight on; stands still at the end, or when it takes too long."""
        if self.heading is None or self.pose is None:
            return
        x, y, yaw = self.pose
        velocity = Twist()
        error = math.remainder(self.heading - yaw, math.tau)
        now = self.get_clock().now()
        is_late = (now - self.began).nanoseconds > 1e9 * self.longest_s
        is_lost = (now - self.seen_at).nanoseconds > 0.5e9
        if is_late or is_lost:
            # Something is in the way, or nobody knows where the robot is. The agent sees where it
            # stands now, and decides anew.
            self.heading = None
            self.settled = self.get_clock().now()
        elif self.start is None and abs(error) > 0.02:
            velocity.angular.z = math.copysign(min(self.angular, 2 * abs(error) + 0.1), error)
        else:
            self.start = self.start or (x, y)
            if math.dist(self.start, (x, y)) < STEP_M:
                velocity.linear.x = self.linear
                velocity.angular.z = 2 * error
            else:
                self.heading = None
                self.settled = self.get_clock().now()
        self.velocities.publish(velocity)


def main() -> None:
    """Runs the bridge until Ctrl-C, and leaves the robot standing."""
    rclpy.init()
    bridge = RobotBridge()
    try:
        rclpy.spin(bridge)
    except KeyboardInterrupt:
        pass
    finally:
        bridge.velocities.publish(Twist())
        bridge.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
