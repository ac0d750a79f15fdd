"""Calls /reset and /step with CycloneDDS, with the service mapping of rmw_cyclonedds_cpp.

Takes a number of steps with the actions 1, 2, ..., 6, 0, 1, ... Whenever an episode ends, starts
another one with the next seed, counted from 1. Prints one line of JSON: the number of successful
responses with the expected episode and step, the number of successful episodes, and a CRC-32 of all
images.
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

# An arbitrary client ID, which the responses contain.
CLIENT = 0x1122334455667788
Request = TypeVar("Request", bound=IdlStruct)
Response = TypeVar("Response", bound=IdlStruct)


class Client(Generic[Request, Response]):
    """A client of a service. Waits for the server when it is created."""

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
                sys.exit(f"no server for {service} within {timeout_s} s")
            time.sleep(0.01)

    def call(self, request: Request) -> Response:
        """Sends a request and repeats it every second until its response arrives."""
        deadline = time.monotonic() + self.timeout_s
        while time.monotonic() < deadline:
            self.writer.write(request)
            for response in self.participant.samples(self.reader, 1.0):
                if (response.client, response.sequence) == (CLIENT, request.sequence):
                    return response
        sys.exit(f"no response to {request} within {self.timeout_s} s")


def main() -> None:
    """Parses the arguments and calls the services."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, required=True, help="number of steps to take")
    parser.add_argument("--timeout", type=float, default=20.0, help="timeout in seconds")
    arguments = parser.parse_args()

    participant = Participant()
    timeout_s = arguments.timeout
    reset = Client(participant, "/reset", ResetRequest, ResetResponse, timeout_s)
    step = Client(participant, "/step", StepRequest, StepResponse, timeout_s)
    seed, number, expected, successes, checksum = 0, 0, 0, 0, 0
    episode = 0
    for sequence in range(1, arguments.steps + 1):
        if number == 0:
            seed += 1
            start = reset.call(ResetRequest(CLIENT, seed, seed, seed, ""))
            episode = start.episode
            checksum = zlib.crc32(bytes(start.image.data), checksum)
        number += 1
        result = step.call(StepRequest(CLIENT, sequence, episode, number, sequence % 7))
        expected += (result.success, result.episode, result.step) == (True, episode, number)
        checksum = zlib.crc32(bytes(result.image.data), checksum)
        if result.terminated or result.truncated:
            successes += result.terminated
            number = 0
    print(json.dumps({"right": expected, "escapes": successes, "checksum": checksum}))


if __name__ == "__main__":
    main()
