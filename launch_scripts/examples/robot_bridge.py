#!/usr/bin/env python3
"""Connects a differential-drive robot to the agent, in place of Evac's simulator.

The bridge resamples the robot's camera image to the agent's 20 x 7 image, and converts the
agent's commands to velocities. docs/robot.md describes the topics and the camera
requirements. Run the bridge in a workspace with evac_msgs:

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
# Rays per pixel of the small image, along each axis.
RAYS = 4
TURNS_DEGREES = (-135, -90, -45, 0, 45, 90, 135)
STEP_M = 0.1524
# Bytes per pixel, and the offsets of red, green and blue.
ENCODINGS = {"rgb8": (3, (0, 1, 2)), "bgr8": (3, (2, 1, 0)), "rgba8": (4, (0, 1, 2)),
             "bgra8": (4, (2, 1, 0)), "mono8": (1, (0, 0, 0))}


def rays() -> NDArray[numpy.float64]:
    """Returns the directions of the small image's rays in the optical frame, `[7, 20, 16, 3]`.

    They are unit vectors for a stereographic lens that covers 180 degrees across the width.
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


def ray_pixels(info: CameraInfo) -> tuple[NDArray[numpy.int64], NDArray[numpy.bool_]]:
    """Returns the camera's pixel for each ray and whether the camera sees the ray.

    The shapes are `[7, 20, 16, 2]`, with the row and column of the pixel, and `[7, 20, 16]`. The
    image must be from a fisheye lens (`equidistant`) or rectified.
    """
    x, y, z = numpy.moveaxis(rays(), -1, 0)
    if info.distortion_model == "equidistant":
        fx, cx, fy, cy = info.k[0], info.k[2], info.k[4], info.k[5]
        k1, k2, k3, k4 = (list(info.d) + [0.0] * 4)[:4]
        angle = numpy.arctan2(numpy.hypot(x, y), z)
        square = angle**2
        distorted = angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
        scale = distorted / numpy.maximum(numpy.hypot(x, y), 1e-9)
        is_in_view = numpy.ones_like(z, dtype=bool)
    else:
        # A pinhole camera, which sees only rays with a positive depth.
        fx, cx, fy, cy = info.p[0], info.p[2], info.p[5], info.p[6]
        scale = 1 / numpy.maximum(z, 1e-9)
        is_in_view = z > 1e-6
    column = numpy.floor(fx * x * scale + cx + 0.5)
    row = numpy.floor(fy * y * scale + cy + 0.5)
    is_in_view &= (0 <= column) & (column < info.width) & (0 <= row) & (row < info.height)
    pixels = numpy.stack([row, column], axis=-1)
    return numpy.where(is_in_view[..., None], pixels, 0).astype(numpy.int64), is_in_view


def colours(image: Image) -> NDArray[numpy.uint8]:
    """Returns the pixels of an image as `[rows, columns, 3]` RGB."""
    if image.encoding not in ENCODINGS:
        known = ", ".join(ENCODINGS)
        raise ValueError(f"image encoding: unknown value '{image.encoding}' (expected: {known})")
    size, channels = ENCODINGS[image.encoding]
    rows = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.step)
    pixels = rows[:, : image.width * size].reshape(image.height, image.width, size)
    return pixels[:, :, list(channels)]


class RobotBridge(Node):
    """Publishes small images and velocities, given large images, odometry and commands."""

    def __init__(self) -> None:
        super().__init__("robot_bridge")
        # The units are m/s, rad/s and s.
        self.linear_speed = self.declare_parameter("linear_speed", 0.2).value
        self.angular_speed = self.declare_parameter("angular_speed", 1.0).value
        self.longest_move = self.declare_parameter("longest_move", 5.0).value
        self.ray_pixels: tuple[NDArray[numpy.int64], NDArray[numpy.bool_]] | None = None
        self.image_size = (0, 0)
        self.odometry_time = self.get_clock().now()
        self.pose: tuple[float, float, float] | None = None
        # The current move: the heading to turn to, then the position where the straight part began.
        self.target_heading: float | None = None
        self.straight_start: tuple[float, float] | None = None
        self.move_start_time = self.move_end_time = self.get_clock().now()
        self.images = self.create_publisher(Image, "camera/image", 5)
        self.velocities = self.create_publisher(Twist, "cmd_vel", 1)
        sensors = qos_profile_sensor_data
        self.create_subscription(CameraInfo, "camera_info", self.on_camera_info, sensors)
        self.create_subscription(Image, "image", self.on_image, sensors)
        self.create_subscription(Odometry, "odom", self.on_odometry, sensors)
        self.create_subscription(ActionCommand, "action", self.on_action, QoSProfile(depth=1))
        self.create_timer(0.02, self.drive)

    def on_camera_info(self, info: CameraInfo) -> None:
        """Computes the pixel of each ray from the first message."""
        if self.ray_pixels is None:
            self.ray_pixels = ray_pixels(info)
            self.image_size = (info.height, info.width)
            coverage = self.ray_pixels[1].mean()
            if coverage < 0.95:
                self.get_logger().warning(
                    f"the camera covers {100 * coverage:.0f} % of the agent's field of view; the "
                    "rest is black (use a wider lens)"
                )

    def on_image(self, large: Image) -> None:
        """Publishes the small image with the header of the large one."""
        if self.ray_pixels is None:
            self.get_logger().warning(
                "image ignored: no camera_info received yet", throttle_duration_sec=5.0
            )
            return
        try:
            if (large.height, large.width) != self.image_size:
                raise ValueError(
                    f"image size: {large.width} x {large.height} differs from camera_info"
                    f" (expected: {self.image_size[1]} x {self.image_size[0]})"
                )
            large_pixels = colours(large)
        except ValueError as error:
            self.get_logger().error(str(error), throttle_duration_sec=5.0)
            return
        pixels, is_in_view = self.ray_pixels
        samples = large_pixels[pixels[..., 0], pixels[..., 1]] * is_in_view[..., None]
        count = numpy.maximum(is_in_view.sum(axis=-1), 1)[..., None]
        data = (samples.sum(axis=-2) / count).round().astype(numpy.uint8)
        small = Image(height=HEIGHT, width=WIDTH, encoding="rgb8", step=3 * WIDTH)
        small.header = large.header
        small.data = data.tobytes()
        self.images.publish(small)

    def on_odometry(self, odometry: Odometry) -> None:
        """Stores the pose of the robot."""
        pose = odometry.pose.pose
        q = pose.orientation
        yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
        self.pose = (pose.position.x, pose.position.y, yaw)
        self.odometry_time = self.get_clock().now()

    def on_action(self, command: ActionCommand) -> None:
        """Starts a move, unless the robot is moving or the command is for an outdated image."""
        if self.pose is None:
            self.get_logger().warning("command refused: no odometry received yet")
        elif self.target_heading is not None:
            self.get_logger().warning("command refused: the robot is moving")
        elif Time.from_msg(command.header.stamp) < self.move_end_time:
            self.get_logger().warning("command refused: its image is older than the last move")
        elif command.action >= len(TURNS_DEGREES):
            self.get_logger().error(f"command refused: action {command.action} (expected: 0 to 6)")
        else:
            self.target_heading = self.pose[2] + math.radians(TURNS_DEGREES[command.action])
            self.straight_start = None
            self.move_start_time = self.get_clock().now()

    def drive(self) -> None:
        """Controls a move: turns, then drives straight; stops when the move ends or is aborted."""
        if self.target_heading is None or self.pose is None:
            return
        x, y, yaw = self.pose
        velocity = Twist()
        error = math.remainder(self.target_heading - yaw, math.tau)
        now = self.get_clock().now()
        is_overdue = (now - self.move_start_time).nanoseconds > 1e9 * self.longest_move
        is_odometry_stale = (now - self.odometry_time).nanoseconds > 0.5e9
        if is_overdue or is_odometry_stale:
            # The robot is blocked or its pose is unknown: it stops, and the agent decides again
            # from the next image.
            self.target_heading = None
            self.move_end_time = self.get_clock().now()
        elif self.straight_start is None and abs(error) > 0.02:
            speed = min(self.angular_speed, 2 * abs(error) + 0.1)
            velocity.angular.z = math.copysign(speed, error)
        else:
            self.straight_start = self.straight_start or (x, y)
            if math.dist(self.straight_start, (x, y)) < STEP_M:
                velocity.linear.x = self.linear_speed
                velocity.angular.z = 2 * error
            else:
                self.target_heading = None
                self.move_end_time = self.get_clock().now()
        self.velocities.publish(velocity)


def main() -> None:
    """Runs the bridge until Ctrl-C, then publishes a zero velocity."""
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
