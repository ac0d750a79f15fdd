#!/usr/bin/env python3
"""An rclpy client for /reset and /step, the services of Evac's simulator.

The program takes random steps and shows the camera images in the terminal. Run it in a workspace
with evac_msgs while a `sim_node` is running:

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

# A request is sent again if there is no response within this time. The simulator executes it once.
RETRY_AFTER_S = 1.0


class RequestRefusedError(Exception):
    """The simulator refused a request; the message gives the reason."""


class SimulatorClient:
    """A client of the simulator's services `reset` and `step`."""

    def __init__(self, name: str = "room_client", timeout_s: float = 30.0) -> None:
        """Waits for the services of the simulator.

        `timeout_s` limits the wait for each service and the duration of each call, in seconds. When
        it is exceeded, TimeoutError is raised.
        """
        self.node = rclpy.create_node(name)
        self.timeout_s = timeout_s
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.resets = self.node.create_client(Reset, "reset")
        self.steps = self.node.create_client(Step, "step")
        for client in (self.resets, self.steps):
            if not client.wait_for_service(timeout_s):
                raise TimeoutError(f"service not found: {client.srv_name} (is sim_node running?)")
        # The upper 32 bits identify this client; the lower 32 bits count its requests.
        self.request = random.getrandbits(31) << 32
        self.episode = 0
        self.step_number = 0

    def reset(self, seed: int = 0, scenario: str = "") -> NDArray[numpy.uint8]:
        """Begins an episode and returns its first image, `[7, 20, 3]` RGB.

        `seed` determines everything random in the episode; 0 uses the simulator's own random state.
        An empty `scenario` keeps the current one.
        """
        self.request += 1
        response = self._call(
            self.resets, Reset.Request(request=self.request, seed=seed, scenario=scenario)
        )
        self.episode, self.step_number = response.episode, 0
        return pixels(response.image)

    def step(self, action: int) -> tuple[NDArray[numpy.uint8], Step.Response]:
        """Executes an action, 0 to 6, and returns the next image and the whole response."""
        number = self.step_number + 1
        response = self._call(
            self.steps, Step.Request(episode=self.episode, step=number, action=action)
        )
        self.step_number = number
        return pixels(response.image), response

    def close(self) -> None:
        """Destroys the node."""
        self.executor.shutdown()
        self.node.destroy_node()

    def _call(self, client: Client, request: Any) -> Any:
        deadline = time.monotonic() + self.timeout_s
        while time.monotonic() < deadline:
            future = client.call_async(request)
            self._spin_until(future, min(deadline, time.monotonic() + RETRY_AFTER_S))
            if not future.done():
                client.remove_pending_request(future)
                continue
            response = future.result()
            if not response.success:
                raise RequestRefusedError(response.message)
            return response
        raise TimeoutError(f"no response from {client.srv_name} within {self.timeout_s:g} s")

    def _spin_until(self, future: Future, end: float) -> None:
        # Not spin_until_future_complete, which in Jazzy leaves work behind for later calls.
        while not future.done() and time.monotonic() < end:
            # After Ctrl-C or SIGTERM the context is shut down, and no response can arrive.
            if not rclpy.ok():
                raise ExternalShutdownException
            self.executor.spin_once(timeout_sec=max(0.0, end - time.monotonic()))


def pixels(image: Image) -> NDArray[numpy.uint8]:
    """Returns the pixels of an rgb8 image without padding, `[rows, columns, 3]`."""
    return numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.width, 3)


def drawing(image: NDArray[numpy.uint8]) -> str:
    """Returns an image as text for a colour terminal, with two rows of pixels per line."""
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
    """Takes random steps until the episode ends, but at most 20."""
    rclpy.init()
    simulator = SimulatorClient()
    try:
        print(drawing(simulator.reset(seed=7)))
        for _ in range(20):
            action = random.randrange(7)
            image, response = simulator.step(action)
            blocked = ", blocked" if response.blocked else ""
            print(f"step {response.step}: action {action}, reward {response.reward:g}{blocked}")
            print(drawing(image))
            if response.terminated or response.truncated:
                print("terminated at the exit" if response.terminated else "truncated")
                break
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        simulator.close()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
