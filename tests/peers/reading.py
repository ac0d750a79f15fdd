"""Readers and writers over loopback with CycloneDDS, an independent DDS implementation."""

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TypeVar

from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

LOOPBACK_ONLY = Path(__file__).with_name("loopback.xml").read_text()
RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))
Sample = TypeVar("Sample", bound=IdlStruct)


class Participant:
    """A participant in the domain given by ROS_DOMAIN_ID."""

    def __init__(self) -> None:
        self.domain_id = int(os.environ.get("ROS_DOMAIN_ID", "0"))
        # Kept alive, because the configuration is dropped with the object.
        self._domain = Domain(self.domain_id, LOOPBACK_ONLY)
        self.participant = DomainParticipant(self.domain_id)

    def reader(
        self, topic: str, kind: type[Sample], reliability: Policy = RELIABLE, prefix: str = "rt"
    ) -> DataReader[Sample]:
        """Creates a reader for a topic given by its ROS name, or DDS name if `prefix` is empty."""
        qos = Qos(reliability, Policy.History.KeepAll)
        named = Topic(self.participant, f"{prefix}{topic}", kind)
        return DataReader(self.participant, named, qos)

    def writer(self, topic: str, kind: type[Sample]) -> DataWriter[Sample]:
        """Creates a reliable writer for a topic given by its DDS name."""
        qos = Qos(RELIABLE, Policy.History.KeepAll)
        return DataWriter(self.participant, Topic(self.participant, topic, kind), qos)

    def samples(self, reader: DataReader[Sample], timeout_s: float) -> Iterator[Sample]:
        """Yields the samples that a reader receives before the timeout."""
        new = ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.NotRead)
        waiting = WaitSet(self.participant)
        waiting.attach(new)
        deadline = time.monotonic() + timeout_s
        while (remaining_s := deadline - time.monotonic()) > 0:
            waiting.wait(duration(seconds=remaining_s))
            for sample in reader.take(1, condition=new):
                # A departing publisher causes a sample without data.
                if isinstance(sample, IdlStruct):
                    yield sample
