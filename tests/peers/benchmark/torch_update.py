"""Measures one update of deep Q-learning in PyTorch, with a network and batch like Evac's.

The defaults are those of the preset `paper`. An update includes sampling the batch and the Adam
step. Prints one line of JSON: `torch_update_us`, the time per update in microseconds, as the median
over chunks of 100 updates, and `torch_version`. Uses one thread.
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
CAPACITY = 10_000
DISCOUNT = 0.999
CHUNK = 100
WARM_UP = 300


def network(widths: list[int], parts: int) -> nn.Sequential:
    """Returns a multilayer perceptron with these layer widths and ReLU between the layers.

    The first layer is applied to each of `parts` equal parts of the inputs.
    """
    inputs, first, *others = widths
    layers: list[nn.Module] = [
        nn.Unflatten(1, (parts, inputs // parts)),
        nn.Linear(inputs // parts, first),
        nn.ReLU(),
        nn.Flatten(),
    ]
    for size, outputs in pairwise([parts * first, *others]):
        layers += [nn.Linear(size, outputs), nn.ReLU()]
    return nn.Sequential(*layers[:-1])


class ReplayMemory:
    """A full replay memory of random transitions. Observations are bytes, as from a camera."""

    def __init__(self, inputs: int) -> None:
        self.random = numpy.random.default_rng(0)
        self.states = torch.randint(256, (CAPACITY, inputs), dtype=torch.uint8)
        self.next_states = torch.randint(256, (CAPACITY, inputs), dtype=torch.uint8)
        self.actions = torch.randint(ACTIONS, (CAPACITY, 1))
        # One transition in forty is terminal: its reward is 0 and nothing is bootstrapped.
        terminated = torch.rand(CAPACITY, 1) < 1 / 40
        self.rewards = torch.where(terminated, 0.0, -0.1)
        self.discounts = torch.where(terminated, 0.0, DISCOUNT)

    def sample(self, batch: int) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
        """Samples distinct transitions uniformly.

        Returns states, actions, rewards, discounts and next states, `[batch, ...]` each.
        """
        indices = torch.from_numpy(self.random.choice(CAPACITY, batch, replace=False))
        return (
            self.states.index_select(0, indices).float().div_(255),
            self.actions.index_select(0, indices),
            self.rewards.index_select(0, indices),
            self.discounts.index_select(0, indices),
            self.next_states.index_select(0, indices).float().div_(255),
        )


class Learner:
    """The training network, the target network and the optimizer."""

    def __init__(self, widths: list[int], parts: int, double: bool) -> None:
        self.training = network(widths, parts)
        self.target = network(widths, parts)
        self.target.load_state_dict(self.training.state_dict())
        self.double = double
        self.adam = torch.optim.Adam(self.training.parameters(), lr=1e-4, eps=1e-7, fused=True)

    def update(self, memory: ReplayMemory, batch: int) -> None:
        """Takes one gradient step on the mean squared error of a batch."""
        states, actions, rewards, discounts, next_states = memory.sample(batch)
        with torch.no_grad():
            future = self.target(next_states)
            if self.double:
                best = future.gather(1, self.training(next_states).argmax(1, keepdim=True))
            else:
                best = future.amax(1, keepdim=True)
            targets = torch.addcmul(rewards, discounts, best)
        values = self.training(states).gather(1, actions)
        self.adam.zero_grad(set_to_none=True)
        nn.functional.mse_loss(values, targets).backward()
        self.adam.step()


def main() -> None:
    """Parses the arguments, runs the benchmark and prints the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--updates", type=int, default=3_000, help="number of updates to measure")
    parser.add_argument("--inputs", type=int, default=420, help="size of an observation in bytes")
    parser.add_argument("--hidden", type=int, nargs="+", default=[64, 128, 64], help="layer widths")
    parser.add_argument("--parts", type=int, default=1, help="parts that share the first layer")
    parser.add_argument("--batch", type=int, default=50, help="batch size")
    parser.add_argument("--double", action="store_true", help="use double Q-learning")
    arguments = parser.parse_args()

    torch.set_num_threads(1)
    torch.manual_seed(0)
    memory = ReplayMemory(arguments.inputs)
    widths = [arguments.inputs, *arguments.hidden, ACTIONS]
    learner = Learner(widths, arguments.parts, arguments.double)
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
