#!/usr/bin/env python3
"""Drives the robot by the arrow keys, and shows what it sees.

It does what the agent does in `drive`: it hears /camera/image and says /action. So it drives the
simulator and a robot alike. In a workspace with evac_msgs, beside a running `sim_node`:

    ros2 run evac_bringup teleoperation.py
"""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import tty

import rclpy
from evac_msgs.msg import ActionCommand
from evac_msgs.srv import Reset
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from room import drawing, pixels
from sensor_msgs.msg import Image

KEYS = {
    "\x1b[A": ActionCommand.FORWARD,
    "\x1b[D": ActionCommand.TURN_LEFT_45,
    "\x1b[C": ActionCommand.TURN_RIGHT_45,
    "a": ActionCommand.TURN_LEFT_90,
    "d": ActionCommand.TURN_RIGHT_90,
    "z": ActionCommand.TURN_LEFT_135,
    "c": ActionCommand.TURN_RIGHT_135,
}
HELP = """\
Every key turns the robot and takes it a step forward:
  up                     straight on
  left, right            45 degrees
  a, d                   90 degrees to the left, to the right
  z, c                   135 degrees
  r                      begins a new episode (of the simulator)
  q                      ends
"""
HOME_AND_CLEAR = "\x1b[H\x1b[J"


class Teleoperation(Node):
    """The robot at the other end of the keys."""

    def __init__(self) -> None:
        """A node that has seen nothing yet."""
        super().__init__("teleoperation")
        self.latest: Image | None = None
        self.answered = False
        self.actions = self.create_publisher(ActionCommand, "action", 1)
        self.resets = self.create_client(Reset, "reset")
        self.create_subscription(Image, "camera/image", self.on_image, qos_profile_sensor_data)

    def on_image(self, image: Image) -> None:
        """Shows what the robot sees."""
        if (image.encoding, image.step) != ("rgb8", 3 * image.width):
            self.get_logger().error(
                f"an image in {image.encoding} with rows of {image.step} bytes: expected rgb8 and"
                f" {3 * image.width}", throttle_duration_sec=5.0
            )
            return
        self.latest, self.answered = image, False
        print(HOME_AND_CLEAR + HELP + drawing(pixels(image)), flush=True)

    def press(self, key: str) -> None:
        """Does what a key is for."""
        if key == "r":
            # Whatever comes of it comes as an image.
            self.resets.call_async(Reset.Request())
        elif key in KEYS and self.latest is not None and not self.answered:
            command = ActionCommand(action=KEYS[key])
            # The image that is answered: one that is older than the robot's last move is refused.
            command.header.stamp = self.latest.header.stamp
            self.actions.publish(command)
            self.answered = True


def pressed() -> str | None:
    """The key that was pressed last, if one was; an arrow is three characters."""
    if not select.select([sys.stdin], [], [], 0)[0]:
        return None
    # Not by sys.stdin, which would keep from select what it has read ahead.
    text = os.read(sys.stdin.fileno(), 64).decode(errors="replace")
    keys = re.findall(r"\x1b\[[A-D]|.", text)
    return keys[-1] if keys else None


def main() -> None:
    """Drives until q or Ctrl-C."""
    if not sys.stdin.isatty():
        sys.exit("teleoperation: the keys are read from a terminal, and standard input is none")
    rclpy.init()
    node = Teleoperation()
    before = termios.tcgetattr(sys.stdin)
    print(HELP + "There is no image yet: r brings one from the simulator.")
    try:
        tty.setcbreak(sys.stdin)
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.02)
            key = pressed()
            if key == "q":
                break
            if key is not None:
                node.press(key)
    except KeyboardInterrupt:
        pass
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
