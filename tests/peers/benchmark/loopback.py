"""What the measurements of CycloneDDS share: a network of loopback alone and a second process."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LOOPBACK_ONLY = Path(__file__).parent.with_name("loopback.xml").read_text()


def default_domain() -> int:
    """The DDS domain that ROS_DOMAIN_ID names, as for ROS 2's nodes."""
    return int(os.environ.get("ROS_DOMAIN_ID", "0"))


@contextmanager
def second_process(command: list[str]) -> Iterator[None]:
    """Runs a command, both it and this process on loopback alone, until the end of the block."""
    os.environ["CYCLONEDDS_URI"] = LOOPBACK_ONLY
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.kill()
        process.wait()
