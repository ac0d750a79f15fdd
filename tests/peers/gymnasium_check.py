"""Lets Gymnasium check the environment of launch_scripts/examples, which calls the simulator by rclpy.

Here it is called by CycloneDDS, with the service mapping of rmw_cyclonedds_cpp. Prints one line of
JSON: how many episodes of random steps came to an end, and whether one came twice from its seed.
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
from evac_gymnasium import EvacEnv  # noqa: E402


class Room:
    """What the example `room.py` is in rclpy."""

    def __init__(self, timeout_s: float) -> None:
        participant = Participant()
        self.resets = Client(participant, "/reset", ResetRequest, ResetResponse, timeout_s)
        self.steps = Client(participant, "/step", StepRequest, StepResponse, timeout_s)
        self.sequence = 0
        self.episode = 0
        self.step_number = 0

    def reset(self, seed: int = 0, scenario: str = "") -> NDArray[numpy.uint8]:
        """Begins an episode; the first image."""
        self.sequence += 1
        request = ResetRequest(CLIENT, self.sequence, self.sequence, seed, scenario)
        begun = self.resets.call(request)
        self.episode, self.step_number = begun.episode, 0
        return pixels(begun.image)

    def step(self, action: int) -> tuple[NDArray[numpy.uint8], StepResponse]:
        """Takes a step; the image after it, and the answer."""
        self.sequence += 1
        self.step_number += 1
        request = StepRequest(CLIENT, self.sequence, self.episode, self.step_number, action)
        taken = self.steps.call(request)
        return pixels(taken.image), taken

    def close(self) -> None:
        """The participant ends with the process."""


def pixels(image: Image) -> NDArray[numpy.uint8]:
    """The pixels of an image, [rows, columns, (red, green, blue)]."""
    return numpy.array(image.data, numpy.uint8).reshape(image.height, image.width, 3)


def episode(env: EvacEnv, seed: int) -> tuple[int, float]:
    """Random steps until an episode is over: a checksum of its images, and its return."""
    image, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    images, total, over = [image], 0.0, False
    while not over:
        image, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        images.append(image)
        total += reward
        over = terminated or truncated
    return hash(numpy.stack(images).tobytes()), total


def main() -> None:
    """Checks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--timeout", type=float, default=20.0, help="seconds to wait at most")
    env = EvacEnv(Room(parser.parse_args().timeout), render_mode="rgb_array")
    # The checker would make environments of its own to look at their pictures.
    check_env(env, skip_render_check=True)
    episodes = [episode(env, seed) for seed in (1, 2, 1)]
    repeats = episodes[0] == episodes[2] and episodes[0] != episodes[1]
    print(json.dumps({"episodes": len(episodes), "repeats": repeats}))


if __name__ == "__main__":
    main()
