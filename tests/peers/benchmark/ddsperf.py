"""Measures the round trip between two processes with ddsperf, CycloneDDS's own benchmark in C.

Sends 480 bytes in each direction over loopback, reliably. Prints one line of JSON:
`ddsperf_rtt_us`, the median in microseconds, or null if ddsperf is not installed (Debian:
cyclonedds-tools).
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
from statistics import median

from loopback import default_domain, second_process

PAYLOAD_BYTES = 480


def measure(ddsperf: str, domain: int, seconds: int, trigger: str) -> float:
    """Measures for `seconds` seconds; returns the median round trip in microseconds."""
    command = [ddsperf, "-i", str(domain), "-D"]
    pong = [*command, str(seconds + 2), "pong", trigger]
    ping = [*command, str(seconds), "ping", "size", str(PAYLOAD_BYTES), trigger]
    with second_process(pong):
        output = subprocess.run(
            ping, check=True, capture_output=True, text=True, timeout=seconds + 10
        ).stdout
    # ddsperf prints a line per second: "size 480 mean 9.9us min 8.5us 50% 8.8us 90% 11.5us ...".
    # Each value is half the round trip, an estimate of the one-way latency.
    halves_us = [float(half) for half in re.findall(r" 50% ([\d.]+)us", output)]
    if not halves_us:
        sys.exit(f"ddsperf measured nothing:\n{output}")
    return round(2 * median(halves_us), 1)


def main() -> None:
    """Parses the arguments, runs the benchmark and prints the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--domain", type=int, default=default_domain(), help="the DDS domain")
    parser.add_argument("--seconds", type=int, default=3, help="duration of the measurement")
    parser.add_argument(
        "--trigger",
        choices=["listener", "waitset"],
        default="listener",
        help="reply in the receiving thread (listener), or wake a waiting thread (waitset)",
    )
    arguments = parser.parse_args()

    ddsperf = shutil.which("ddsperf")
    if ddsperf is None:
        print("ddsperf not found on the PATH (Debian: cyclonedds-tools)", file=sys.stderr)
        rtt_us = None
    else:
        rtt_us = measure(ddsperf, arguments.domain, arguments.seconds, arguments.trigger)
    print(json.dumps({"ddsperf_rtt_us": rtt_us}))


if __name__ == "__main__":
    main()
