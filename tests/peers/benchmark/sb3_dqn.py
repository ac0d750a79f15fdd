"""Measures Stable-Baselines3's DQN with the network and hyperparameters of Evac's preset `paper`.

Environment and learner run in one process. The environment returns precomputed random images, so
its cost is negligible. Prints one line of JSON: `sb3_steps_per_s`, the environment steps per
second, with one update per step, and `sb3_version`. Uses one thread.
"""

import argparse
import json
import time
from typing import Any

import gymnasium
import numpy
import stable_baselines3
import torch
from numpy.typing import NDArray

ACTIONS = 7
EPISODE_STEPS = 40
IMAGE_SHAPE = (7, 20, 3)
IMAGES = 1_000
WARM_UP = 500


class RandomImages(gymnasium.Env[NDArray[numpy.uint8], numpy.int64]):
    """Returns random camera images regardless of the action; an episode has 40 steps."""

    def __init__(self) -> None:
        self.observation_space = gymnasium.spaces.Box(0, 255, IMAGE_SHAPE, numpy.uint8)
        self.action_space = gymnasium.spaces.Discrete(ACTIONS)
        random = numpy.random.default_rng(0)
        self.images = random.integers(256, size=(IMAGES, *IMAGE_SHAPE), dtype=numpy.uint8)
        self.steps = 0

    def image(self) -> NDArray[numpy.uint8]:
        """Returns the image of the current step."""
        return self.images[self.steps % IMAGES]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[numpy.uint8], dict[str, Any]]:
        """Starts an episode."""
        super().reset(seed=seed)
        return self.image(), {}

    def step(
        self, action: numpy.int64
    ) -> tuple[NDArray[numpy.uint8], float, bool, bool, dict[str, Any]]:
        """Returns the next image, the reward, terminated, truncated and an empty info."""
        self.steps += 1
        return self.image(), -0.1, self.steps % EPISODE_STEPS == 0, False, {}


def main() -> None:
    """Parses the arguments, runs the benchmark and prints the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=3_000, help="number of steps to measure")
    arguments = parser.parse_args()

    torch.set_num_threads(1)
    learner = stable_baselines3.DQN(
        "MlpPolicy",
        RandomImages(),
        learning_rate=1e-4,
        buffer_size=10_000,
        learning_starts=50,
        batch_size=50,
        tau=0.1,
        gamma=0.999,
        train_freq=1,
        gradient_steps=1,
        target_update_interval=EPISODE_STEPS,
        # The final exploration rate of the paper: nine out of ten actions need inference.
        exploration_initial_eps=0.1,
        exploration_final_eps=0.1,
        policy_kwargs={
            "net_arch": [64, 128, 64],
            "optimizer_kwargs": {"eps": 1e-7, "fused": True},
        },
        device="cpu",
        seed=0,
    )
    learner.learn(WARM_UP)
    start = time.perf_counter()
    learner.learn(arguments.steps, reset_num_timesteps=False)
    steps_per_s = arguments.steps / (time.perf_counter() - start)
    report = {
        "sb3_steps_per_s": round(steps_per_s, 1),
        "sb3_version": stable_baselines3.__version__,
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main()
