"""Reads camera images over loopback with CycloneDDS, an independent DDS implementation.

Waits for a number of images and prints one line of JSON: their number, the shape, encoding and
frame of the last one, and whether the stamps increase. Exits with status 1 and an error if the
images do not arrive before the timeout. The domain is given by ROS_DOMAIN_ID.
"""

import argparse
import json
import sys
from itertools import islice, pairwise

from cyclonedds.qos import Policy
from reading import RELIABLE, Participant
from ros_types import Image


def stamp(image: Image) -> tuple[int, int]:
    """Returns the stamp of an image as a comparable pair of seconds and nanoseconds."""
    return (image.header.stamp.sec, image.header.stamp.nanosec)


def main() -> None:
    """Parses the arguments and reads the images."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=5, help="number of images to wait for")
    parser.add_argument("--timeout", type=float, default=20.0, help="timeout in seconds")
    parser.add_argument("--topic", default="/camera/image", help="the ROS name of the topic")
    parser.add_argument("--best-effort", action="store_true", help="use best-effort reliability")
    arguments = parser.parse_args()

    participant = Participant()
    reliability = Policy.Reliability.BestEffort if arguments.best_effort else RELIABLE
    reader = participant.reader(arguments.topic, Image, reliability)
    images = list(islice(participant.samples(reader, arguments.timeout), arguments.frames))
    if len(images) < arguments.frames:
        sys.exit(
            f"received {len(images)} of {arguments.frames} images on {arguments.topic} in domain"
            f" {participant.domain_id} within {arguments.timeout} s;"
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
