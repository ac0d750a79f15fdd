"""Calls /reset and /step with CycloneDDS, as rmw_cyclonedds_cpp maps services to DDS.

Takes a number of steps with the actions 0, 1, ... 6, 0, ... and prints one line of JSON: how many
answers were right in their numbers, how often the exit was reached, and a checksum of all images.
An episode that is over is followed by one with the next seed, from 1.
"""

import argparse
import json
import sys
import time
import zlib
from typing import Generic, TypeVar

from cyclonedds.idl import IdlStruct

from reading import Participant
from ros_types import ResetRequest, ResetResponse, StepRequest, StepResponse

# Whatever this is, the answers bear it, too.
CLIENT = 0x1122334455667788
Request = TypeVar("Request", bound=IdlStruct)
Response = TypeVar("Response", bound=IdlStruct)


class Client(Generic[Request, Response]):
    """A client of a service."""

    def __init__(
        self,
        participant: Participant,
        service: str,
        request: type[Request],
        response: type[Response],
        timeout_s: float,
    ) -> None:
        self.participant = participant
        self.timeout_s = timeout_s
        self.writer = participant.writer(f"rq{service}Request", request)
        self.reader = participant.reader(f"rr{service}Reply", response, prefix="")
        deadline = time.monotonic() + timeout_s
        while not (
            self.writer.get_matched_subscriptions() and self.reader.get_matched_publications()
        ):
            if time.monotonic() > deadline:
                sys.exit(f"nobody serves {service}")
            time.sleep(0.01)

    def call(self, request: Request) -> Response:
        """The answer to a request, which is repeated until there is one."""
        deadline = time.monotonic() + self.timeout_s
        while time.monotonic() < deadline:
            self.writer.write(request)
            for response in self.participant.samples(self.reader, 1.0):
                if (response.client, response.sequence) == (CLIENT, request.sequence):
                    return response
        sys.exit(f"no answer to {request}")


def main() -> None:
    """Calls as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, required=True, help="how many to take")
    parser.add_argument("--timeout", type=float, default=20.0, help="seconds to wait at most")
    arguments = parser.parse_args()

    participant = Participant()
    timeout_s = arguments.timeout
    reset = Client(participant, "/reset", ResetRequest, ResetResponse, timeout_s)
    step = Client(participant, "/step", StepRequest, StepResponse, timeout_s)
    seed, number, right, escapes, checksum = 0, 0, 0, 0, 0
    episode = 0
    for sequence in range(1, arguments.steps + 1):
        if number == 0:
            seed += 1
            begun = reset.call(ResetRequest(CLIENT, seed, seed, seed, ""))
            episode = begun.episode
            checksum = zlib.crc32(bytes(begun.image.data), checksum)
        number += 1
        taken = step.call(StepRequest(CLIENT, sequence, episode, number, sequence % 7))
        right += (taken.success, taken.episode, taken.step) == (True, episode, number)
        checksum = zlib.crc32(bytes(taken.image.data), checksum)
        if taken.terminated or taken.truncated:
            escapes += taken.terminated
            number = 0
    print(json.dumps({"right": right, "escapes": escapes, "checksum": checksum}))


if __name__ == "__main__":
    main()
