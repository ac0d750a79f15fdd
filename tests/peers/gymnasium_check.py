"""Runs Gymnasium's environment checker on the environment in launch_scripts/examples.

The example calls the simulator with rclpy; here CycloneDDS takes its place, with the service
mapping of rmw_cyclonedds_cpp. Prints one line of JSON: the number of completed episodes of random
steps, and whether the same seed reproduced an episode.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray
from reading import Participant
from ros_types import Image, ResetRequest, ResetResponse, StepRequest, StepResponse
from service_caller import CLIENT, Client

sys.path.append(str(Path(__file__).parents[2] / "launch_scripts/examples"))
from evac_gymnasium import EvacEnv


class Room:
    """Replaces `SimulatorClient` from the example `room.py`, which uses rclpy."""

    def __init__(self, timeout_s: float) -> None:
        participant = Participant()
        self.resets = Client(participant, "/reset", ResetRequest, ResetResponse, timeout_s)
        self.steps = Client(participant, "/step", StepRequest, StepResponse, timeout_s)
        self.sequence = 0
        self.episode = 0
        self.step_number = 0

    def reset(self, seed: int = 0, scenario: str = "") -> NDArray[numpy.uint8]:
        """Starts an episode and returns its first image."""
        self.sequence += 1
        request = ResetRequest(CLIENT, self.sequence, self.sequence, seed, scenario)
        response = self.resets.call(request)
        self.episode, self.step_number = response.episode, 0
        return pixels(response.image)

    def step(self, action: int) -> tuple[NDArray[numpy.uint8], StepResponse]:
        """Takes a step and returns the next image and the response."""
        self.sequence += 1
        self.step_number += 1
        request = StepRequest(CLIENT, self.sequence, self.episode, self.step_number, action)
        response = self.steps.call(request)
        return pixels(response.image), response

    def close(self) -> None:
        """Does nothing: the participant is deleted when the process exits."""


def pixels(image: Image) -> NDArray[numpy.uint8]:
    """Returns the pixels of an image, `[height, width, 3]` in RGB."""
    return numpy.array(image.data, numpy.uint8).reshape(image.height, image.width, 3)


def episode(env: EvacEnv, seed: int) -> tuple[int, float]:
    """Runs an episode of random steps; returns a hash of its images and the sum of its rewards."""
    image, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    images, total, is_over = [image], 0.0, False
    while not is_over:
        image, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        images.append(image)
        total += reward
        is_over = terminated or truncated
    return hash(numpy.stack(images).tobytes()), total


def main() -> None:
    """Parses the arguments and runs the checks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--timeout", type=float, default=20.0, help="timeout in seconds")
    env = EvacEnv(Room(parser.parse_args().timeout), render_mode="rgb_array")
    # The render check would create further environments.
    check_env(env, skip_render_check=True)
    episodes = [episode(env, seed) for seed in (1, 2, 1)]
    repeats = episodes[0] == episodes[2] and episodes[0] != episodes[1]
    print(json.dumps({"episodes": len(episodes), "repeats": repeats}))


if __name__ == "__main__":
    main()
