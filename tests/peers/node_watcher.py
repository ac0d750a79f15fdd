"""Hears with CycloneDDS what a node says of itself.

Waits for a report of the node on /diagnostics, then for a change of a parameter on
/parameter_events, and prints one line of JSON: the parts and levels of the report, and the new value
of the parameter. Once it listens to both it says "listening" in a line of its own.
"""

import argparse
import json
import sys
import time

from reading import Participant
from ros_types import DiagnosticArray, ParameterEvent


def main() -> None:
    """Watches as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--node", required=True, help="its name, such as /sim_node")
    parser.add_argument("--parameter", required=True, help="a parameter that holds a string")
    parser.add_argument("--timeout", type=float, default=20.0, help="seconds to wait at most")
    arguments = parser.parse_args()

    participant = Participant()
    diagnostics = participant.reader("/diagnostics", DiagnosticArray)
    events = participant.reader("/parameter_events", ParameterEvent)
    deadline = time.monotonic() + arguments.timeout
    while not (diagnostics.get_matched_publications() and events.get_matched_publications()):
        if time.monotonic() > deadline:
            sys.exit(f"{arguments.node} does not publish what every node does")
        time.sleep(0.01)
    print("listening", flush=True)

    own = f"{arguments.node.rsplit('/', 1)[-1]}: "
    parts: dict[str, int] = {}
    for report in participant.samples(diagnostics, arguments.timeout):
        parts |= {s.name.removeprefix(own): s.level for s in report.status if s.name.startswith(own)}
        if parts:
            break
    changed: list[str] = []
    for event in participant.samples(events, arguments.timeout):
        if event.node == arguments.node:
            changes = event.changed_parameters
            changed += [p.value.string_value for p in changes if p.name == arguments.parameter]
        if changed:
            break
    print(json.dumps({"parts": parts, "changed": changed}))


if __name__ == "__main__":
    main()
