"""Measures a round trip between two processes with CycloneDDS's Python binding, over loopback.

A request of 16 bytes is answered by 420 bytes, the size of a camera image; both ways are reliable,
keep the last sample and block on a WaitSet. Prints one line of JSON: `cyclone_rtt_us`, the
percentiles 50, 99 and 99.9 in microseconds, and `cyclone_round_trips`, how many were measured.
"""

import argparse
import json
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from loopback import default_domain, second_process

# After so long without a partner or a sample, either side gives up.
PATIENCE_S = 10.0
WARM_UP = 500


@dataclass
class Request(IdlStruct, typename="benchmark::Request"):
    """What a step of the simulator is asked with."""

    episode: uint64
    step: uint32
    action: uint32


@dataclass
class Reply(IdlStruct, typename="benchmark::Reply"):
    """A camera image without a header."""

    image: array[uint8, 420]


def connect(
    domain: int, send: type[IdlStruct], receive: type[IdlStruct]
) -> tuple[DataWriter[Any], DataReader[Any]]:
    """A writer that has found its reader, and a reader, whose topics bear their types' names."""
    participant = DomainParticipant(domain)
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1))
    reader = DataReader(participant, Topic(participant, receive.__name__, receive), qos)
    writer = DataWriter(participant, Topic(participant, send.__name__, send), qos)
    deadline = time.monotonic() + PATIENCE_S
    while not writer.get_matched_subscriptions():
        if time.monotonic() > deadline:
            sys.exit(f"no partner in domain {domain} within {PATIENCE_S} s")
        time.sleep(0.01)
    return writer, reader


def answer(domain: int) -> None:
    """Answers requests until none comes any more."""
    writer, reader = connect(domain, Reply, Request)
    reply = Reply(image=bytes(420))
    for _ in reader.take_iter(timeout=duration(seconds=PATIENCE_S)):
        writer.write(reply)


def ask(domain: int, seconds: float) -> list[float]:
    """The durations of the round trips that fit into a time, in microseconds."""
    writer, reader = connect(domain, Request, Reply)
    replies = reader.take_iter(timeout=duration(seconds=PATIENCE_S))
    request = Request(episode=1, step=1, action=3)

    def round_trip_us() -> float:
        start_ns = time.perf_counter_ns()
        writer.write(request)
        if next(replies, None) is None:
            sys.exit(f"no reply within {PATIENCE_S} s")
        return (time.perf_counter_ns() - start_ns) / 1e3

    for _ in range(WARM_UP):
        round_trip_us()
    round_trips_us = [round_trip_us()]
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        round_trips_us.append(round_trip_us())
    return round_trips_us


def main() -> None:
    """Measures as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--domain", type=int, default=default_domain(), help="the DDS domain")
    parser.add_argument("--seconds", type=float, default=3.0, help="how long to measure")
    parser.add_argument("--answer", action="store_true", help="be the second process")
    arguments = parser.parse_args()

    if arguments.answer:
        answer(arguments.domain)
        return
    command = [sys.executable, __file__, "--answer", "--domain", str(arguments.domain)]
    with second_process(command):
        round_trips_us = ask(arguments.domain, arguments.seconds)
    p50, p99, p999 = numpy.percentile(round_trips_us, [50, 99, 99.9]).round(1)
    report = {
        "cyclone_rtt_us": {"p50": p50, "p99": p99, "p999": p999},
        "cyclone_round_trips": len(round_trips_us),
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main()
