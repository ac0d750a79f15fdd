"""Lists the endpoints that CycloneDDS discovers in the domain given by ROS_DOMAIN_ID.

Waits until each of the given topics has an endpoint, then prints one line of JSON: a list with the
kind ("writer" or "reader"), topic, type and USER_DATA of each endpoint. CycloneDDS writes warnings,
for example about malformed packets, to standard error.
"""

import argparse
import json
import sys
import time

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.qos import Policy
from reading import Participant


def main() -> None:
    """Parses the arguments and waits for the endpoints."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("topics", nargs="+", help="DDS topic names such as rt/camera/image")
    parser.add_argument("--timeout", type=float, default=20.0, help="timeout in seconds")
    arguments = parser.parse_args()

    participant = Participant()
    readers = {
        "writer": BuiltinDataReader(participant.participant, BuiltinTopicDcpsPublication),
        "reader": BuiltinDataReader(participant.participant, BuiltinTopicDcpsSubscription),
    }
    endpoints: dict[str, dict[str, str]] = {}
    missing = set(arguments.topics)
    deadline = time.monotonic() + arguments.timeout
    while missing:
        if time.monotonic() > deadline:
            sys.exit(f"no endpoint on {', '.join(sorted(missing))} within {arguments.timeout} s")
        time.sleep(0.05)
        for kind, reader in readers.items():
            for sample in reader.take(100):
                user_data = sample.qos[Policy.Userdata]
                endpoints[str(sample.key)] = {
                    "kind": kind,
                    "topic": sample.topic_name,
                    "type": sample.type_name,
                    "user_data": user_data.data.decode("latin-1") if user_data else "",
                }
        missing -= {endpoint["topic"] for endpoint in endpoints.values()}
    print(json.dumps(list(endpoints.values())))


if __name__ == "__main__":
    main()
