"""Reads camera images over loopback with CycloneDDS, a DDS implementation of another house.

Waits for a number of frames and prints one line of JSON about them: their number, the shape,
encoding and frame of the last one, and whether the stamps increase. Exits with 1 and says what was
missing if they do not come in time. The domain is that of ROS_DOMAIN_ID.
"""

import argparse
import json
import os
import sys
import time
from itertools import pairwise
from pathlib import Path

from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from ros_types import Image

LOOPBACK_ONLY = Path(__file__).with_name("loopback.xml").read_text()


def read_images(
    participant: DomainParticipant, reader: DataReader[Image], frames: int, timeout_s: float
) -> list[Image]:
    """The first `frames` images, or those that came within `timeout_s`."""
    images: list[Image] = []
    new = ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.NotRead)
    waiting = WaitSet(participant)
    waiting.attach(new)
    deadline = time.monotonic() + timeout_s
    while len(images) < frames and (remaining_s := deadline - time.monotonic()) > 0:
        waiting.wait(duration(seconds=remaining_s))
        taken = reader.take(frames - len(images), condition=new)
        # A publisher that leaves is announced by a sample without an image.
        images.extend(sample for sample in taken if isinstance(sample, Image))
    return images


def stamp(image: Image) -> tuple[int, int]:
    """The stamp of an image as a pair that compares like time."""
    return (image.header.stamp.sec, image.header.stamp.nanosec)


def main() -> None:
    """Reads images as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=5, help="how many to wait for")
    parser.add_argument("--timeout", type=float, default=20.0, help="seconds to wait at most")
    parser.add_argument("--topic", default="/camera/image", help="the ROS name of the topic")
    parser.add_argument("--best-effort", action="store_true", help="do not ask for lost frames")
    arguments = parser.parse_args()

    domain_id = int(os.environ.get("ROS_DOMAIN_ID", "0"))
    # Kept until the end: the configuration ends with the object.
    _domain = Domain(domain_id, LOOPBACK_ONLY)
    participant = DomainParticipant(domain_id)
    reliability = (
        Policy.Reliability.BestEffort
        if arguments.best_effort
        else Policy.Reliability.Reliable(duration(seconds=1))
    )
    qos = Qos(reliability, Policy.History.KeepAll)
    reader = DataReader(participant, Topic(participant, f"rt{arguments.topic}", Image), qos)

    images = read_images(participant, reader, arguments.frames, arguments.timeout)
    if len(images) < arguments.frames:
        sys.exit(
            f"{len(images)} of {arguments.frames} frames came on {arguments.topic} in domain"
            f" {domain_id} within {arguments.timeout} s;"
            f" matching publishers: {len(reader.get_matched_publications())}"
        )
    last = images[-1]
    report = {
        "frames": len(images),
        "width": last.width,
        "height": last.height,
        "encoding": last.encoding,
        "step": last.step,
        "bytes": len(last.data),
        "frame_id": last.header.frame_id,
        "stamps_increase": all(stamp(a) < stamp(b) for a, b in pairwise(images)),
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main()
