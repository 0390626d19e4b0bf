//! Hashes of types, checked against those that `rosidl` has computed.

use dotgen_ros2::description::{Base, Count, Field, FieldType, Types};

/// Types with their fields in the words of `.msg` files; `---` divides the parts of services and actions.
const DEFINITIONS: &str = include_str!("fixtures/definitions.txt");
/// Names and hashes.
pub(crate) const HASHES: &str = include_str!("fixtures/hashes.txt");

fn field(line: &str) -> Field {
    let (ty, name) = line.split_once(' ').expect("type and name");
    let (base, count) = match ty.strip_suffix(']').and_then(|stem| stem.rsplit_once('[')) {
        None => (ty, Count::One),
        Some((base, "")) => (base, Count::Any),
        Some((base, number)) => match number.strip_prefix("<=") {
            Some(rest) => (base, Count::AtMost(rest.parse().expect("a number"))),
            None => (base, Count::Exactly(number.parse().expect("a number"))),
        },
    };
    let base = match base {
        "int8" => Base::Int8,
        "uint8" => Base::Uint8,
        "int16" => Base::Int16,
        "uint16" => Base::Uint16,
        "int32" => Base::Int32,
        "uint32" => Base::Uint32,
        "int64" => Base::Int64,
        "uint64" => Base::Uint64,
        "float32" => Base::Float32,
        "float64" => Base::Float64,
        "bool" => Base::Bool,
        "string" => Base::String,
        other => match other.strip_prefix("string<=") {
            Some(rest) => Base::BoundedString(rest.parse().expect("a number")),
            None => Base::Nested(other.replacen('/', "/msg/", 1)),
        },
    };
    Field::new(name, FieldType { base, count })
}

/// Adds types of a text: a line `= NAME` begins one.
pub(crate) fn add(text: &str, to: &mut Types) {
    for definition in text.split("= ").skip(1) {
        let (name, rest) = definition.split_once('\n').expect("a name");
        let parts = rest.split("---\n").map(|part| {
            let lines = part.lines().filter(|line| !line.is_empty());
            lines.map(field).collect::<Vec<_>>()
        });
        match <[Vec<Field>; 1]>::try_from(parts.collect::<Vec<_>>()) {
            Ok([fields]) => to.add(name, fields),
            Err(parts) => match <[Vec<Field>; 2]>::try_from(parts) {
                Ok([request, response]) => to.service(name, request, response),
                Err(parts) => {
                    let [goal, result, feedback] = parts.try_into().expect("an action");
                    to.action(name, goal, result, feedback);
                }
            },
        }
    }
}

#[test]
fn hashes_are_those_of_rosidl() {
    let mut types = Types::standard();
    add(DEFINITIONS, &mut types);
    let (mut wrong, mut checked) = (Vec::new(), 0);
    for line in HASHES.lines() {
        let (name, hash) = line.split_once(' ').expect("name and hash");
        // Types of GenoM3 have no definition here.
        if types.fields(name).is_some() {
            checked += 1;
            if types.hash(name) != hash {
                wrong.push(name);
            }
        }
    }
    assert!(wrong.is_empty(), "other hashes: {wrong:#?}");
    assert_eq!(checked, 86);
}
