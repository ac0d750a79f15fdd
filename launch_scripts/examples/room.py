#!/usr/bin/env python3
"""Evac's simulator as something to call: a client of /reset and /step in rclpy.

As a program it takes some steps by hand and shows what the robot sees. In a workspace with
evac_msgs, beside a running `sim_node`:

    ros2 run evac_bringup room.py
"""

from __future__ import annotations

import random
import time
from typing import Any

import numpy
import rclpy
from evac_msgs.srv import Reset, Step
from numpy.typing import NDArray
from rclpy.client import Client
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.task import Future
from sensor_msgs.msg import Image

# An answer that takes so long was lost: a request is repeated then, which executes nothing twice.
PATIENCE_S = 1.0


class Refused(Exception):
    """The simulator has refused a request, and says why."""


class Room:
    """The simulator behind the services `reset` and `step`."""

    def __init__(self, name: str = "room_client", timeout_s: float = 30.0) -> None:
        """Waits for the simulator, at most `timeout_s` seconds; so does every call."""
        self.node = rclpy.create_node(name)
        self.timeout_s = timeout_s
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.resets = self.node.create_client(Reset, "reset")
        self.steps = self.node.create_client(Step, "step")
        for client in (self.resets, self.steps):
            if not client.wait_for_service(timeout_s):
                raise TimeoutError(f"nobody serves {client.srv_name}: is sim_node running?")
        # The upper half of its numbers is a program's name: no other has the same.
        self.request = random.getrandbits(31) << 32
        self.episode = 0
        self.step_number = 0

    def reset(self, seed: int = 0, scenario: str = "") -> NDArray[numpy.uint8]:
        """Begins an episode; the first image, [7, 20, (red, green, blue)].

        Everything random in it follows from the seed; with 0 it is another one each time. Without
        the name of a scenario the simulator keeps its own.
        """
        self.request += 1
        begun = self._call(
            self.resets, Reset.Request(request=self.request, seed=seed, scenario=scenario)
        )
        self.episode, self.step_number = begun.episode, 0
        return pixels(begun.image)

    def step(self, action: int) -> tuple[NDArray[numpy.uint8], Step.Response]:
        """Takes a step with an action, 0 to 6: the image after it, and all of the answer."""
        number = self.step_number + 1
        taken = self._call(
            self.steps, Step.Request(episode=self.episode, step=number, action=action)
        )
        self.step_number = number
        return pixels(taken.image), taken

    def close(self) -> None:
        """Leaves the graph."""
        self.executor.shutdown()
        self.node.destroy_node()

    def _call(self, client: Client, request: Any) -> Any:
        deadline = time.monotonic() + self.timeout_s
        while time.monotonic() < deadline:
            future = client.call_async(request)
            self._spin_until(future, min(deadline, time.monotonic() + PATIENCE_S))
            if not future.done():
                client.remove_pending_request(future)
                continue
            response = future.result()
            if not response.success:
                raise Refused(response.message)
            return response
        raise TimeoutError(f"no answer from {client.srv_name} within {self.timeout_s:g} s")

    def _spin_until(self, future: Future, end: float) -> None:
        # Not spin_until_future_complete: in Jazzy each call of it leaves work to the next ones.
        while not future.done() and time.monotonic() < end:
            # Ctrl-C or SIGTERM: without the context no answer comes any more.
            if not rclpy.ok():
                raise ExternalShutdownException
            self.executor.spin_once(timeout_sec=max(0.0, end - time.monotonic()))


def pixels(image: Image) -> NDArray[numpy.uint8]:
    """The pixels of an image in rgb8 without padding, [rows, columns, (red, green, blue)]."""
    return numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.width, 3)


def drawing(image: NDArray[numpy.uint8]) -> str:
    """An image for a terminal that knows colours: two rows of pixels a line, the last one alone."""
    lines = []
    for row in range(0, len(image), 2):
        line = ""
        for column in range(image.shape[1]):
            upper = "{};{};{}".format(*image[row, column])
            line += f"\x1b[38;2;{upper}m"
            if row + 1 < len(image):
                line += "\x1b[48;2;{};{};{}m".format(*image[row + 1, column])
            line += "\u2580"
        lines.append(line + "\x1b[0m")
    return "\n".join(lines)


def main() -> None:
    """Takes random steps until the episode is over, 20 at most."""
    rclpy.init()
    room = Room()
    try:
        print(drawing(room.reset(seed=7)))
        for _ in range(20):
            action = random.randrange(7)
            image, taken = room.step(action)
            blocked = ", blocked" if taken.blocked else ""
            print(f"step {taken.step}: action {action}, reward {taken.reward:g}{blocked}")
            print(drawing(image))
            if taken.terminated or taken.truncated:
                print("the exit" if taken.terminated else "no more steps")
                break
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        room.close()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
