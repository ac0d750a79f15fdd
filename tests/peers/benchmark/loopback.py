"""What the measurements of CycloneDDS share: a network of loopback alone and a second process."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

# As ROS 2 configures CycloneDDS for ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST: nothing leaves this
# machine, and participants find each other at the well-known unicast ports of loopback.
LOOPBACK_ONLY = """
<CycloneDDS><Domain Id="any">
  <General>
    <Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
</Domain></CycloneDDS>
"""


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
