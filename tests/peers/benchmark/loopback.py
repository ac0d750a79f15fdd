"""Helpers for the CycloneDDS measurements, which run two processes over loopback only."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LOOPBACK_ONLY = Path(__file__).parent.with_name("loopback.xml").read_text()


def default_domain() -> int:
    """Returns the DDS domain given by ROS_DOMAIN_ID (default: 0), as for ROS 2 nodes."""
    return int(os.environ.get("ROS_DOMAIN_ID", "0"))


@contextmanager
def second_process(command: list[str]) -> Iterator[None]:
    """Runs a command during a `with` block. Restricts it and this process to loopback."""
    os.environ["CYCLONEDDS_URI"] = LOOPBACK_ONLY
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.kill()
        process.wait()
