#!/usr/bin/env python3
"""Evac's simulator as a Gymnasium environment, and a DQN of Stable-Baselines3 that learns in it.

Any learner of Python's can train against `sim_node` with it. As a program it needs, beside rclpy and
evac_msgs, `pip install gymnasium stable-baselines3 tqdm rich`; beside a running `sim_node`:

    ros2 run evac_bringup evac_gymnasium.py --steps 20000
"""

from __future__ import annotations

import argparse
from typing import Any, Protocol

import gymnasium
import numpy
from numpy.typing import NDArray

HEIGHT, WIDTH, ACTIONS = 7, 20, 7
Pixels = NDArray[numpy.uint8]


class Answer(Protocol):
    """What a step comes to: the fields of evac_msgs/srv/Step's response."""

    reward: float
    terminated: bool
    truncated: bool
    blocked: bool


class RoomClient(Protocol):
    """Whoever calls the simulator: `room.Room`, or another client of its services."""

    def reset(self, seed: int = 0, scenario: str = "") -> Pixels:
        """Begins an episode; the first image."""

    def step(self, action: int) -> tuple[Pixels, Answer]:
        """Takes a step; the image after it, and the answer."""

    def close(self) -> None:
        """Nobody will call any more."""


class EvacEnv(gymnasium.Env[Pixels, numpy.int64]):
    """The room: one sees 7 x 20 pixels, turns and steps seven ways, and is to find the exit.

    A step costs 0.1, and nothing at the exit, where an episode is terminated. It is truncated after
    as many steps as the simulator's parameter `max_steps` says.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 2}

    def __init__(
        self,
        room: RoomClient | None = None,
        scenario: str = "",
        render_mode: str | None = None,
    ) -> None:
        """An environment in a room, by default that of `room.Room`.

        Without a name, the simulator keeps its own scenario.
        """
        if room is None:
            # Not above: another client needs no rclpy.
            import rclpy
            from room import Room

            if not rclpy.ok():
                rclpy.init()
            room = Room("evac_gymnasium")
        self.room = room
        self.scenario = scenario
        self.render_mode = render_mode
        self.observation_space = gymnasium.spaces.Box(0, 255, (HEIGHT, WIDTH, 3), numpy.uint8)
        self.action_space = gymnasium.spaces.Discrete(ACTIONS)
        self.image = numpy.zeros((HEIGHT, WIDTH, 3), numpy.uint8)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Pixels, dict[str, Any]]:
        """Begins an episode, which follows from the seed or from those before it.

        The option `scenario` chooses another one from now on.
        """
        super().reset(seed=seed)
        self.scenario = (options or {}).get("scenario", self.scenario)
        # The simulator takes 0 for "as you like".
        own = int(self.np_random.integers(1, 2**63))
        self.image = self.room.reset(own, self.scenario)
        return self.image, {}

    def step(self, action: numpy.int64) -> tuple[Pixels, float, bool, bool, dict[str, Any]]:
        """Takes a step with one of the actions, 0 (135 degrees right) to 6 (135 degrees left)."""
        self.image, taken = self.room.step(int(action))
        # In the simulator's float32, -0.1 is a little more or less.
        reward = round(float(taken.reward), 6)
        return self.image, reward, taken.terminated, taken.truncated, {"blocked": taken.blocked}

    def render(self) -> Pixels | None:
        """What the camera sees."""
        return self.image if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Leaves the room."""
        self.room.close()


def main() -> None:
    """Trains, and says how the last episodes went."""
    import torch
    from stable_baselines3 import DQN
    from stable_baselines3.common.monitor import Monitor

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=20_000, help="how many to train")
    parser.add_argument("--scenario", default="empty", help="one of the simulator's")
    parser.add_argument("--seed", type=int, default=0, help="of the episodes and of the learner")
    # ROS adds arguments of its own.
    arguments, _ = parser.parse_known_args()

    # A network so small is fastest on one thread, and the simulator wants the other.
    torch.set_num_threads(1)
    # Stable-Baselines3's convolutions are for larger images.
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
    print(f"{len(lengths)} episodes: {first:.1f} steps each at first, {last:.1f} at last")
    env.close()


if __name__ == "__main__":
    main()
