"""Measures one update of deep Q-learning in PyTorch, of a network and batch like Evac's.

Without options they are those of the preset `paper`.

An update is everything from drawing a batch of memories to the step of Adam. Prints one line of
JSON: `torch_update_us`, the median over chunks of 100 updates, in microseconds each, and
`torch_version`. One thread computes.
"""

import argparse
import json
import time
from itertools import pairwise
from statistics import median

import numpy
import torch
from torch import Tensor, nn

ACTIONS = 7
MEMORIES = 10_000
DISCOUNT = 0.999
CHUNK = 100
WARM_UP = 300


def network(widths: list[int]) -> nn.Sequential:
    """A perceptron of linear layers between these widths, with ReLU between the layers."""
    layers: list[nn.Module] = []
    for inputs, outputs in pairwise(widths):
        layers += [nn.Linear(inputs, outputs), nn.ReLU()]
    return nn.Sequential(*layers[:-1])


class Memory:
    """A full replay memory, whose observations are bytes as a camera gives them, at random."""

    def __init__(self, inputs: int) -> None:
        self.random = numpy.random.default_rng(0)
        self.states = torch.randint(256, (MEMORIES, inputs), dtype=torch.uint8)
        self.next_states = torch.randint(256, (MEMORIES, inputs), dtype=torch.uint8)
        self.actions = torch.randint(ACTIONS, (MEMORIES, 1))
        # One memory of forty ends its episode: no reward is lost there, and none follows.
        terminated = torch.rand(MEMORIES, 1) < 1 / 40
        self.rewards = torch.where(terminated, 0.0, -0.1)
        self.discounts = torch.where(terminated, 0.0, DISCOUNT)

    def sample(self, batch: int) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
        """Different memories, drawn uniformly: states, actions, rewards, discounts, next states."""
        drawn = torch.from_numpy(self.random.choice(MEMORIES, batch, replace=False))
        return (
            self.states.index_select(0, drawn).float().div_(255),
            self.actions.index_select(0, drawn),
            self.rewards.index_select(0, drawn),
            self.discounts.index_select(0, drawn),
            self.next_states.index_select(0, drawn).float().div_(255),
        )


class Learner:
    """A network in training, its target network and its optimiser."""

    def __init__(self, widths: list[int], double: bool) -> None:
        self.training = network(widths)
        self.target = network(widths)
        self.target.load_state_dict(self.training.state_dict())
        self.double = double
        self.adam = torch.optim.Adam(self.training.parameters(), lr=1e-4, eps=1e-7, fused=True)

    def update(self, memory: Memory, batch: int) -> None:
        """One step along the gradient of the mean squared error of a batch."""
        states, actions, rewards, discounts, next_states = memory.sample(batch)
        with torch.no_grad():
            future = self.target(next_states)
            if self.double:
                best = future.gather(1, self.training(next_states).argmax(1, keepdim=True))
            else:
                best = future.amax(1, keepdim=True)
            wanted = torch.addcmul(rewards, discounts, best)
        values = self.training(states).gather(1, actions)
        self.adam.zero_grad(set_to_none=True)
        nn.functional.mse_loss(values, wanted).backward()
        self.adam.step()


def main() -> None:
    """Measures as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--updates", type=int, default=3_000, help="how many to measure")
    parser.add_argument("--inputs", type=int, default=420, help="bytes of an observation")
    parser.add_argument("--hidden", type=int, nargs="+", default=[64, 128, 64], help="widths")
    parser.add_argument("--batch", type=int, default=50, help="memories of one update")
    parser.add_argument("--double", action="store_true", help="Double DQN")
    arguments = parser.parse_args()

    torch.set_num_threads(1)
    torch.manual_seed(0)
    memory = Memory(arguments.inputs)
    learner = Learner([arguments.inputs, *arguments.hidden, ACTIONS], arguments.double)
    for _ in range(WARM_UP):
        learner.update(memory, arguments.batch)

    chunks_us: list[float] = []
    for _ in range(max(1, arguments.updates // CHUNK)):
        start_ns = time.perf_counter_ns()
        for _ in range(CHUNK):
            learner.update(memory, arguments.batch)
        chunks_us.append((time.perf_counter_ns() - start_ns) / 1e3 / CHUNK)
    report = {"torch_update_us": round(median(chunks_us), 1), "torch_version": torch.__version__}
    print(json.dumps(report))


if __name__ == "__main__":
    main()
