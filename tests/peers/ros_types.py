"""The ROS 2 messages and services that the peers use, with their DDS type names."""

from dataclasses import dataclass

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float32, float64, int32, int64, sequence, uint8, uint32, uint64


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    """A time: seconds and nanoseconds."""

    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    """The stamp and coordinate frame of a message."""

    stamp: Time
    frame_id: str


@dataclass
class Image(IdlStruct, typename="sensor_msgs::msg::dds_::Image_"):
    """An uncompressed image in row-major order."""

    header: Header
    height: uint32
    width: uint32
    encoding: str
    is_bigendian: uint8
    step: uint32
    data: sequence[uint8]


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    """A diagnostic value with its name."""

    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    """The status of a component."""

    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    """The statuses of several components."""

    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class ParameterValue(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterValue_"):
    """The value of a parameter, in the field for its type."""

    type: uint8
    bool_value: bool
    integer_value: int64
    double_value: float64
    string_value: str
    byte_array_value: sequence[uint8]
    bool_array_value: sequence[bool]
    integer_array_value: sequence[int64]
    double_array_value: sequence[float64]
    string_array_value: sequence[str]


@dataclass
class Parameter(IdlStruct, typename="rcl_interfaces::msg::dds_::Parameter_"):
    """A parameter and its value."""

    name: str
    value: ParameterValue


@dataclass
class ParameterEvent(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterEvent_"):
    """The new, changed and deleted parameters of a node."""

    stamp: Time
    node: str
    new_parameters: sequence[Parameter]
    changed_parameters: sequence[Parameter]
    deleted_parameters: sequence[Parameter]


# Requests and responses start with the header of rmw_cyclonedds_cpp: client ID and sequence number.


@dataclass
class ResetRequest(IdlStruct, typename="evac_msgs::srv::dds_::Reset_Request_"):
    """Requests a new episode."""

    client: uint64
    sequence: int64
    request: uint64
    seed: uint64
    scenario: str


@dataclass
class ResetResponse(IdlStruct, typename="evac_msgs::srv::dds_::Reset_Response_"):
    """The new episode and its first image."""

    client: uint64
    sequence: int64
    success: bool
    status: uint8
    message: str
    episode: uint64
    image: Image


@dataclass
class StepRequest(IdlStruct, typename="evac_msgs::srv::dds_::Step_Request_"):
    """Requests a step."""

    client: uint64
    sequence: int64
    episode: uint64
    step: uint32
    action: uint8


@dataclass
class StepResponse(IdlStruct, typename="evac_msgs::srv::dds_::Step_Response_"):
    """The result of a step."""

    client: uint64
    sequence: int64
    success: bool
    status: uint8
    message: str
    image: Image
    reward: float32
    terminated: bool
    truncated: bool
    blocked: bool
    episode: uint64
    step: uint32
