#!/usr/bin/env python3
"""A Gymnasium environment for Evac's simulator, and a Stable-Baselines3 DQN that trains in it.

`EvacEnv` lets any Python learner train against `sim_node`. The program needs rclpy, evac_msgs and
the packages from `pip install gymnasium stable-baselines3 tqdm rich`. Run it while a `sim_node` is
running:

    ros2 run evac_bringup evac_gymnasium.py --steps 20000
"""

from __future__ import annotations

import argparse
from typing import Any, ClassVar, Protocol

import gymnasium
import numpy
from numpy.typing import NDArray

HEIGHT, WIDTH, ACTIONS = 7, 20, 7
Pixels = NDArray[numpy.uint8]


class StepResult(Protocol):
    """The result of a step: fields of the response of evac_msgs/srv/Step."""

    reward: float
    terminated: bool
    truncated: bool
    blocked: bool


class Simulator(Protocol):
    """A client of the simulator: `room.SimulatorClient`, or one that uses another DDS library."""

    def reset(self, seed: int = 0, scenario: str = "") -> Pixels:
        """Begins an episode and returns its first image."""

    def step(self, action: int) -> tuple[Pixels, StepResult]:
        """Executes an action and returns the next image and the result."""

    def close(self) -> None:
        """Releases the client."""


class EvacEnv(gymnasium.Env[Pixels, numpy.int64]):
    """A room that the robot has to leave, guided by its camera alone.

    An observation is an RGB image, `[7, 20, 3]` uint8. Each of the seven actions is a turn followed
    by a step of 0.1524 m. The reward of a step is -0.1, or 0 if it reaches the exit, which
    terminates the episode. The simulator's parameter `max_steps` is the number of steps after which
    an episode is truncated.
    """

    metadata: ClassVar[dict[str, object]] = {"render_modes": ["rgb_array"], "render_fps": 2}

    def __init__(
        self,
        simulator: Simulator | None = None,
        scenario: str = "",
        render_mode: str | None = None,
    ) -> None:
        """Uses the given client of the simulator, by default a `room.SimulatorClient`.

        An empty `scenario` keeps the simulator's current one.
        """
        if simulator is None:
            # Imported here, because other clients do not need rclpy.
            import rclpy
            from room import SimulatorClient

            if not rclpy.ok():
                rclpy.init()
            simulator = SimulatorClient("evac_gymnasium")
        self.simulator = simulator
        self.scenario = scenario
        self.render_mode = render_mode
        self.observation_space = gymnasium.spaces.Box(0, 255, (HEIGHT, WIDTH, 3), numpy.uint8)
        self.action_space = gymnasium.spaces.Discrete(ACTIONS)
        self.image = numpy.zeros((HEIGHT, WIDTH, 3), numpy.uint8)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Pixels, dict[str, Any]]:
        """Begins an episode and returns its first image.

        `seed` determines this episode and all later ones until the next seed. The option `scenario`
        selects the scenario from this episode on.
        """
        super().reset(seed=seed)
        self.scenario = (options or {}).get("scenario", self.scenario)
        # Never 0, which would make the simulator use its own random state.
        episode_seed = int(self.np_random.integers(1, 2**63))
        self.image = self.simulator.reset(episode_seed, self.scenario)
        return self.image, {}

    def step(self, action: numpy.int64) -> tuple[Pixels, float, bool, bool, dict[str, Any]]:
        """Executes an action, 0 (135 degrees right) to 6 (135 degrees left)."""
        self.image, result = self.simulator.step(int(action))
        # The response stores -0.1 as an inexact float32; rounding restores the value.
        reward = round(float(result.reward), 6)
        return self.image, reward, result.terminated, result.truncated, {"blocked": result.blocked}

    def render(self) -> Pixels | None:
        """Returns the latest camera image."""
        return self.image if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Closes the client of the simulator."""
        self.simulator.close()


def main() -> None:
    """Trains a DQN and prints the mean length of the first and last tenth of the episodes."""
    import torch
    from stable_baselines3 import DQN
    from stable_baselines3.common.monitor import Monitor

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=20_000, help="number of training steps")
    parser.add_argument("--scenario", default="empty", help="scenario of the simulator")
    parser.add_argument("--seed", type=int, default=0, help="seed of the episodes and the learner")
    # ROS may add its own arguments.
    arguments, _ = parser.parse_known_args()

    # More threads do not speed up a network of this size; they slow down the simulator.
    torch.set_num_threads(1)
    # The image is too small for the convolutions of Stable-Baselines3, so it is flattened.
    flat = gymnasium.spaces.Box(0, 1, (HEIGHT * WIDTH * 3,), numpy.float32)
    env = Monitor(
        gymnasium.wrappers.TransformObservation(
            EvacEnv(scenario=arguments.scenario),
            lambda image: image.flatten().astype(numpy.float32) / 255,
            flat,
        )
    )
    model = DQN(
        "MlpPolicy", env, learning_starts=500, train_freq=1, gamma=0.95, target_update_interval=500,
        exploration_fraction=0.5, learning_rate=5e-4, seed=arguments.seed, device="cpu",
    )
    model.learn(arguments.steps, progress_bar=True)
    lengths = env.get_episode_lengths()
    tenth = max(1, len(lengths) // 10)
    first, last = numpy.mean(lengths[:tenth]), numpy.mean(lengths[-tenth:])
    print(f"{len(lengths)} episodes: {first:.1f} steps each at the start, {last:.1f} at the end")
    env.close()


if __name__ == "__main__":
    main()
