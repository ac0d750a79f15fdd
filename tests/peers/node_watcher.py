"""Uses CycloneDDS to receive the diagnostics and parameter events of a node.

Prints the line "listening" once both subscriptions match. Waits for a report from the node on
/diagnostics, then for a change to a parameter on /parameter_events, and prints one line of JSON:
the components and levels of the report, and the new value of the parameter.
"""

import argparse
import json
import sys
import time

from reading import Participant
from ros_types import DiagnosticArray, ParameterEvent


def main() -> None:
    """Parses the arguments and waits for the messages."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--node", required=True, help="full name of the node, such as /sim_node")
    parser.add_argument("--parameter", required=True, help="name of a string parameter")
    parser.add_argument("--timeout", type=float, default=20.0, help="timeout in seconds")
    arguments = parser.parse_args()

    participant = Participant()
    diagnostics = participant.reader("/diagnostics", DiagnosticArray)
    events = participant.reader("/parameter_events", ParameterEvent)
    deadline = time.monotonic() + arguments.timeout
    while not (diagnostics.get_matched_publications() and events.get_matched_publications()):
        if time.monotonic() > deadline:
            sys.exit(
                "no publisher on /diagnostics or none on /parameter_events in domain"
                f" {participant.domain_id} within {arguments.timeout} s"
            )
        time.sleep(0.01)
    print("listening", flush=True)

    prefix = f"{arguments.node.rsplit('/', 1)[-1]}: "
    parts: dict[str, int] = {}
    for report in participant.samples(diagnostics, arguments.timeout):
        statuses = [status for status in report.status if status.name.startswith(prefix)]
        parts |= {status.name.removeprefix(prefix): status.level for status in statuses}
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
