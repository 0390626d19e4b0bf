//! Words of other languages, with their equivalents in this one.

/// The equivalent of a type of C, C++ or ROS.
pub(super) fn type_of(name: &str) -> Option<&'static str> {
    Some(match name {
        "bool" | "Bool" | "Boolean" | "bool_t" | "BOOL" => "boolean",
        "int" | "Int" | "integer" | "int32" | "int32_t" | "i32" => "long",
        "uint" | "unsigned_int" | "uint32" | "uint32_t" | "u32" => "unsigned long",
        "byte" | "uchar" | "int8" | "int8_t" | "uint8" | "uint8_t" | "u8" | "i8" => "octet",
        "int16" | "int16_t" | "i16" => "short",
        "uint16" | "uint16_t" | "u16" | "ushort" => "unsigned short",
        "int64" | "int64_t" | "i64" => "long long",
        "uint64" | "uint64_t" | "u64" | "size_t" => "unsigned long long",
        "float32" | "float32_t" | "f32" => "float",
        "float64" | "float64_t" | "f64" | "real" => "double",
        "String" | "str" => "string",
        _ => return None,
    })
}

/// The equivalent of a type in `std` of C++.
pub(super) fn standard_type(name: &str) -> Option<&'static str> {
    Some(match name {
        "std::string" => "string",
        "std::vector" | "std::list" | "std::deque" => "sequence",
        "std::optional" => "optional",
        "std::int16_t" => "short",
        "std::uint16_t" => "unsigned short",
        "std::int32_t" => "long",
        "std::uint32_t" => "unsigned long",
        "std::int64_t" => "long long",
        "std::uint64_t" | "std::size_t" => "unsigned long long",
        "std::uint8_t" | "std::int8_t" => "octet",
        _ => return None,
    })
}

/// Types that are always available.
pub(super) const TYPES: [&str; 8] =
    ["boolean", "octet", "char", "string", "short", "long", "float", "double"];

/// The equivalent of a constant of other languages.
pub(super) fn constant_of(name: &str) -> Option<&'static str> {
    Some(match name {
        "true" | "True" => "TRUE",
        "false" | "False" => "FALSE",
        _ => return None,
    })
}
