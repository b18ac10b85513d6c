//! The payload of Sparkplug B as protocol buffers: the fields that an edge node writes and reads (Sparkplug 3.0, 6.4.1). A receiver skips
//! fields that it does not know.

use prost::{Message, Oneof};

/// The numbers of the data types (Sparkplug 3.0, 6.4.16).
pub mod datatype {
    /// Signed, 32 bits.
    pub const INT32: u32 = 3;
    /// Signed, 64 bits.
    pub const INT64: u32 = 4;
    /// IEEE 754, 32 bits.
    pub const FLOAT: u32 = 9;
    /// IEEE 754, 64 bits.
    pub const DOUBLE: u32 = 10;
    /// True or false.
    pub const BOOLEAN: u32 = 11;
    /// UTF-8.
    pub const STRING: u32 = 12;
    /// Milliseconds since 1970, UTC.
    pub const DATE_TIME: u32 = 13;
}

/// A payload.
#[derive(Clone, PartialEq, Message)]
pub struct Payload {
    /// When it was made, in milliseconds since 1970.
    #[prost(uint64, optional, tag = "1")]
    pub timestamp: Option<u64>,
    /// The metrics.
    #[prost(message, repeated, tag = "2")]
    pub metrics: Vec<Metric>,
    /// The sequence number, 0 to 255.
    #[prost(uint64, optional, tag = "3")]
    pub seq: Option<u64>,
}

/// A metric.
#[derive(Clone, PartialEq, Message)]
pub struct Metric {
    /// The name, in births.
    #[prost(string, optional, tag = "1")]
    pub name: Option<String>,
    /// The alias that replaces the name in data.
    #[prost(uint64, optional, tag = "2")]
    pub alias: Option<u64>,
    /// The time of the value, in milliseconds since 1970.
    #[prost(uint64, optional, tag = "3")]
    pub timestamp: Option<u64>,
    /// The data type, in births.
    #[prost(uint32, optional, tag = "4")]
    pub datatype: Option<u32>,
    /// It is no present value.
    #[prost(bool, optional, tag = "5")]
    pub is_historical: Option<bool>,
    /// It has no value.
    #[prost(bool, optional, tag = "7")]
    pub is_null: Option<bool>,
    /// Unit, range, quality and the like.
    #[prost(message, optional, tag = "9")]
    pub properties: Option<PropertySet>,
    /// The value.
    #[prost(oneof = "MetricValue", tags = "10, 11, 12, 13, 14, 15")]
    pub value: Option<MetricValue>,
}

/// The value of a metric.
#[derive(Clone, PartialEq, Oneof)]
pub enum MetricValue {
    /// 32 bits; a signed number in two's complement.
    #[prost(uint32, tag = "10")]
    Int(u32),
    /// 64 bits; a signed number in two's complement.
    #[prost(uint64, tag = "11")]
    Long(u64),
    /// IEEE 754, 32 bits.
    #[prost(float, tag = "12")]
    Float(f32),
    /// IEEE 754, 64 bits.
    #[prost(double, tag = "13")]
    Double(f64),
    /// True or false.
    #[prost(bool, tag = "14")]
    Boolean(bool),
    /// UTF-8.
    #[prost(string, tag = "15")]
    String(String),
}

/// The properties of a metric: keys and values in the same order.
#[derive(Clone, PartialEq, Message)]
pub struct PropertySet {
    /// The keys.
    #[prost(string, repeated, tag = "1")]
    pub keys: Vec<String>,
    /// The values.
    #[prost(message, repeated, tag = "2")]
    pub values: Vec<PropertyValue>,
}

/// The value of a property.
#[derive(Clone, PartialEq, Message)]
pub struct PropertyValue {
    /// Its data type.
    #[prost(uint32, optional, tag = "1")]
    pub r#type: Option<u32>,
    /// It has no value.
    #[prost(bool, optional, tag = "2")]
    pub is_null: Option<bool>,
    /// The value.
    #[prost(oneof = "Property", tags = "3, 6, 7, 8")]
    pub value: Option<Property>,
}

/// A property.
#[derive(Clone, PartialEq, Oneof)]
pub enum Property {
    /// 32 bits; a signed number in two's complement.
    #[prost(uint32, tag = "3")]
    Int(u32),
    /// IEEE 754, 64 bits.
    #[prost(double, tag = "6")]
    Double(f64),
    /// True or false.
    #[prost(bool, tag = "7")]
    Boolean(bool),
    /// UTF-8.
    #[prost(string, tag = "8")]
    String(String),
}

impl PropertySet {
    /// Adds a property.
    pub fn push(&mut self, key: &str, value: Property) {
        let datatype = match value {
            Property::Int(_) => datatype::INT32,
            Property::Double(_) => datatype::DOUBLE,
            Property::Boolean(_) => datatype::BOOLEAN,
            Property::String(_) => datatype::STRING,
        };
        self.keys.push(key.to_owned());
        self.values.push(PropertyValue { r#type: Some(datatype), is_null: None, value: Some(value) });
    }
}
