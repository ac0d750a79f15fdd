"""Measures the round trip between two processes with CycloneDDS's Python binding, over loopback.

A request is 16 bytes, and a reply is 420 bytes, the size of a camera image. Both topics are
reliable and keep only the last sample; both processes block on a WaitSet. Prints one line of JSON:
`cyclone_rtt_us`, the 50th, 99th and 99.9th percentiles in microseconds, and `cyclone_round_trips`,
the number of measured round trips.
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

# Timeout for discovery and for each sample, in seconds.
TIMEOUT_S = 10.0
WARM_UP = 500


@dataclass
class Request(IdlStruct, typename="benchmark::Request"):
    """The fields of a step request."""

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
    """Returns a matched writer and a reader. Their topics are named after the types."""
    participant = DomainParticipant(domain)
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1))
    reader = DataReader(participant, Topic(participant, receive.__name__, receive), qos)
    writer = DataWriter(participant, Topic(participant, send.__name__, send), qos)
    deadline = time.monotonic() + TIMEOUT_S
    while not writer.get_matched_subscriptions():
        if time.monotonic() > deadline:
            sys.exit(f"no peer in domain {domain} within {TIMEOUT_S} s")
        time.sleep(0.01)
    return writer, reader


def answer(domain: int) -> None:
    """Answers requests until none arrives within the timeout."""
    writer, reader = connect(domain, Reply, Request)
    reply = Reply(image=bytes(420))
    for _ in reader.take_iter(timeout=duration(seconds=TIMEOUT_S)):
        writer.write(reply)


def ask(domain: int, seconds: float) -> list[float]:
    """Makes round trips for `seconds` seconds; returns their durations in microseconds."""
    writer, reader = connect(domain, Request, Reply)
    replies = reader.take_iter(timeout=duration(seconds=TIMEOUT_S))
    request = Request(episode=1, step=1, action=3)

    def round_trip_us() -> float:
        start_ns = time.perf_counter_ns()
        writer.write(request)
        if next(replies, None) is None:
            sys.exit(f"no reply within {TIMEOUT_S} s")
        return (time.perf_counter_ns() - start_ns) / 1e3

    for _ in range(WARM_UP):
        round_trip_us()
    round_trips_us = [round_trip_us()]
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        round_trips_us.append(round_trip_us())
    return round_trips_us


def main() -> None:
    """Parses the arguments, runs the benchmark and prints the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--domain", type=int, default=default_domain(), help="the DDS domain")
    parser.add_argument("--seconds", type=float, default=3.0, help="duration of the measurement")
    parser.add_argument("--answer", action="store_true", help="run as the remote end")
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
