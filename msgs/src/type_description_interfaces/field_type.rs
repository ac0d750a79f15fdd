use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `type_description_interfaces/msg/FieldType`: the type of a field.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FieldType {
    /// Which type: one of the constants, or the sum of the constant of an element and
    /// [`FieldType::ARRAY`], [`FieldType::BOUNDED_SEQUENCE`] or [`FieldType::UNBOUNDED_SEQUENCE`].
    pub type_id: u8,
    /// The length of an array, the greatest length of a bounded sequence; otherwise 0.
    pub capacity: u64,
    /// The greatest length of a bounded string; otherwise 0.
    pub string_capacity: u64,
    /// The full name of a nested type, such as `std_msgs/msg/Header`; otherwise empty.
    pub nested_type_name: String,
}

impl FieldType {
    /// No type.
    pub const FIELD_TYPE_NOT_SET: u8 = 0;
    /// Another message.
    pub const FIELD_TYPE_NESTED_TYPE: u8 = 1;
    /// `int8`.
    pub const FIELD_TYPE_INT8: u8 = 2;
    /// `uint8`, and `char`.
    pub const FIELD_TYPE_UINT8: u8 = 3;
    /// `int16`.
    pub const FIELD_TYPE_INT16: u8 = 4;
    /// `uint16`.
    pub const FIELD_TYPE_UINT16: u8 = 5;
    /// `int32`.
    pub const FIELD_TYPE_INT32: u8 = 6;
    /// `uint32`.
    pub const FIELD_TYPE_UINT32: u8 = 7;
    /// `int64`.
    pub const FIELD_TYPE_INT64: u8 = 8;
    /// `uint64`.
    pub const FIELD_TYPE_UINT64: u8 = 9;
    /// `float32`.
    pub const FIELD_TYPE_FLOAT: u8 = 10;
    /// `float64`.
    pub const FIELD_TYPE_DOUBLE: u8 = 11;
    /// `long double`, in IDL only.
    pub const FIELD_TYPE_LONG_DOUBLE: u8 = 12;
    /// `char`, in IDL only.
    pub const FIELD_TYPE_CHAR: u8 = 13;
    /// `wchar`, in IDL only.
    pub const FIELD_TYPE_WCHAR: u8 = 14;
    /// `bool`.
    pub const FIELD_TYPE_BOOLEAN: u8 = 15;
    /// `byte`.
    pub const FIELD_TYPE_BYTE: u8 = 16;
    /// `string`.
    pub const FIELD_TYPE_STRING: u8 = 17;
    /// `wstring`.
    pub const FIELD_TYPE_WSTRING: u8 = 18;
    /// A string of a fixed length, which no definition can write.
    pub const FIELD_TYPE_FIXED_STRING: u8 = 19;
    /// As [`FieldType::FIELD_TYPE_FIXED_STRING`], of wide characters.
    pub const FIELD_TYPE_FIXED_WSTRING: u8 = 20;
    /// `string<=N`.
    pub const FIELD_TYPE_BOUNDED_STRING: u8 = 21;
    /// `wstring<=N`.
    pub const FIELD_TYPE_BOUNDED_WSTRING: u8 = 22;

    /// From a type to an array of it, `TYPE[N]`: ROS has a constant for each sum.
    pub const ARRAY: u8 = 48;
    /// From a type to a sequence with a greatest length, `TYPE[<=N]`.
    pub const BOUNDED_SEQUENCE: u8 = 96;
    /// From a type to a sequence of any length, `TYPE[]`.
    pub const UNBOUNDED_SEQUENCE: u8 = 144;
}

impl Message for FieldType {}

impl RosMessage for FieldType {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "FieldType";
}
