"""Encodes messages as CDR with `rosbags`, which shares no code with Evac's encoder.

Standard input is a JSON list of {"type": ..., "value": {...}}, where a type is a message
("evac_msgs/msg/ActionCommand", "sensor_msgs/msg/Image") or the request or response of a service
("evac_msgs/srv/Step_Request"). Standard output is a JSON list of the little-endian encodings, in
hexadecimal digits, each with its four-byte encapsulation header.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy
from rosbags.interfaces import Nodetype
from rosbags.interfaces.typing import FieldDesc
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore


def load_types(package: Path) -> Typestore:
    """Returns the standard types of ROS 2 Jazzy and those that evac_msgs defines in `package`."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for path in package.glob("msg/*.msg"):
        store.register(get_types_from_msg(path.read_text(), f"evac_msgs/msg/{path.stem}"))
    for path in package.glob("srv/*.srv"):
        request, response = path.read_text().split("\n---\n")
        for half, text in (("Request", request), ("Response", response)):
            name = stored_name(f"evac_msgs/srv/{path.stem}_{half}")
            store.register(get_types_from_msg(text, name))
    return store


def stored_name(ros_type: str) -> str:
    """Returns the name of a type in the library rosbags, which represents a service as two messages."""
    return ros_type.replace("/srv/", "/msg/")


def build(store: Typestore, name: str, value: dict[str, Any]) -> object:
    """Returns a message of type `name` from a JSON object with exactly the same fields."""
    fields = dict(store.fielddefs[name][1])
    if fields.keys() != value.keys():
        raise ValueError(f"{name}: fields are {[*value]} (expected: {[*fields]})")
    arguments = {field: build_field(store, fields[field], value[field]) for field in fields}
    return store.types[name](**arguments)


def build_field(store: Typestore, description: FieldDesc, value: Any) -> Any:
    """Returns a field value for rosbags, with numpy arrays for numbers and objects for messages."""
    if description[0] == Nodetype.BASE:
        return value
    if description[0] == Nodetype.NAME:
        return build(store, description[1], value)
    element, _ = description[1]
    if element[0] == Nodetype.BASE and element[1][0] != "string":
        return numpy.array(value, dtype=element[1][0])
    return [build_field(store, element, item) for item in value]


def main() -> None:
    """Encodes the messages from standard input."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("package", type=Path, help="the directory of evac_msgs, with msg and srv")
    store = load_types(parser.parse_args().package)
    encodings = []
    for request in json.load(sys.stdin):
        name = stored_name(request["type"])
        message = build(store, name, request["value"])
        encodings.append(bytes(store.serialize_cdr(message, name, little_endian=True)).hex())
    json.dump(encodings, sys.stdout)


if __name__ == "__main__":
    main()
