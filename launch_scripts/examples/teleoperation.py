#!/usr/bin/env python3
"""Drives the robot with the keyboard and shows its camera image in the terminal.

Like `agent_node drive`, it subscribes to /camera/image and publishes to /action, so it works with
the simulator and a real robot alike. Run it in a workspace with evac_msgs while a `sim_node` is
running:

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
Keys (a movement key turns the robot, then moves it one step forward):
  up                     no turn
  left, right            45 degrees to the left, to the right
  a, d                   90 degrees to the left, to the right
  z, c                   135 degrees to the left, to the right
  r                      begin a new episode (simulator only)
  q                      quit
"""
HOME_AND_CLEAR = "\x1b[H\x1b[J"


class Teleoperation(Node):
    """Shows camera images and publishes the action of each key."""

    def __init__(self) -> None:
        super().__init__("teleoperation")
        self.latest: Image | None = None
        self.answered = False
        self.actions = self.create_publisher(ActionCommand, "action", 1)
        self.resets = self.create_client(Reset, "reset")
        self.create_subscription(Image, "camera/image", self.on_image, qos_profile_sensor_data)

    def on_image(self, image: Image) -> None:
        """Shows the image."""
        if (image.encoding, image.step) != ("rgb8", 3 * image.width):
            self.get_logger().error(
                f"camera/image: encoding '{image.encoding}', step {image.step}"
                f" (expected: 'rgb8', {3 * image.width})", throttle_duration_sec=5.0
            )
            return
        self.latest, self.answered = image, False
        print(HOME_AND_CLEAR + HELP + drawing(pixels(image)), flush=True)

    def press(self, key: str) -> None:
        """Executes the command assigned to a key; ignores other keys."""
        if key == "r":
            # The response is not needed: a reset publishes its image.
            self.resets.call_async(Reset.Request())
        elif key in KEYS and self.latest is not None and not self.answered:
            command = ActionCommand(action=KEYS[key])
            # The robot refuses a command for an image from before its last move.
            command.header.stamp = self.latest.header.stamp
            self.actions.publish(command)
            self.answered = True


def read_key() -> str | None:
    """Returns the key that was pressed last, or None. An arrow key is three characters."""
    if not select.select([sys.stdin], [], [], 0)[0]:
        return None
    # Not sys.stdin.read, which would buffer input that select cannot see.
    text = os.read(sys.stdin.fileno(), 64).decode(errors="replace")
    keys = re.findall(r"\x1b\[[A-D]|.", text)
    return keys[-1] if keys else None


def main() -> None:
    """Runs until q or Ctrl-C."""
    if not sys.stdin.isatty():
        sys.exit("teleoperation: standard input is not a terminal: run the program in a terminal")
    rclpy.init()
    node = Teleoperation()
    before = termios.tcgetattr(sys.stdin)
    print(HELP + "No image received yet; r makes the simulator publish one.")
    try:
        tty.setcbreak(sys.stdin)
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.02)
            key = read_key()
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
