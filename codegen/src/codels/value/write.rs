//! From JSON to the bytes of a value.

use dotgen_analysis::model::{TypeId, TypeKind};
use serde_json::{Map, Value};

use super::{ValueError, Values, wrong};

impl Values<'_> {
    /// Writes a value. `at` is its path in messages.
    pub(super) fn write(
        &self,
        ty: TypeId,
        value: &Value,
        at: &str,
        depth: usize,
        out: &mut Vec<u8>,
    ) -> Result<(), ValueError> {
        let Some(depth) = depth.checked_sub(1) else {
            return wrong(at, "a value that is less deep");
        };
        let kind = self.kind(ty);
        match kind {
            TypeKind::Boolean => match value {
                Value::Null => out.push(0),
                Value::Bool(byte) => out.push(u8::from(*byte)),
                _ => return wrong(at, "true or false"),
            },
            TypeKind::Octet => out.push(whole(value, at, "0 to 255")?),
            TypeKind::Char => out.extend(whole::<i8>(value, at, "-128 to 127")?.to_ne_bytes()),
            TypeKind::Short => {
                out.extend(whole::<i16>(value, at, "-32768 to 32767")?.to_ne_bytes());
            }
            TypeKind::UnsignedShort => {
                out.extend(whole::<u16>(value, at, "0 to 65535")?.to_ne_bytes());
            }
            TypeKind::Long => out.extend(whole::<i32>(value, at, "32 bits")?.to_ne_bytes()),
            TypeKind::UnsignedLong => {
                out.extend(whole::<u32>(value, at, "32 bits, not negative")?.to_ne_bytes());
            }
            TypeKind::LongLong => out.extend(whole::<i64>(value, at, "64 bits")?.to_ne_bytes()),
            TypeKind::UnsignedLongLong => {
                out.extend(whole::<u64>(value, at, "64 bits, not negative")?.to_ne_bytes());
            }
            TypeKind::Float => out.extend((number(value, at)? as f32).to_ne_bytes()),
            TypeKind::Double => out.extend(number(value, at)?.to_ne_bytes()),
            TypeKind::Enum { enumerators } => self.write_enumerator(enumerators, value, at, out)?,
            TypeKind::String { bound } => write_text(*bound, value, at, out)?,
            TypeKind::Array { element, length } => {
                let given = list(value, at)?;
                if !given.is_empty() && given.len() as u64 != *length {
                    return wrong(at, format!("a list of {length}"));
                }
                for i in 0..usize::try_from(*length).unwrap_or(0) {
                    let value = given.get(i).unwrap_or(&Value::Null);
                    self.write(*element, value, &format!("{at}[{i}]"), depth, out)?;
                }
            }
            TypeKind::Sequence { element, bound } => {
                let given = list(value, at)?;
                if let Some(bound) = bound
                    && given.len() as u64 > *bound
                {
                    return wrong(at, format!("a list of at most {bound}"));
                }
                length(given.len(), at, out)?;
                for (i, value) in given.iter().enumerate() {
                    self.write(*element, value, &format!("{at}[{i}]"), depth, out)?;
                }
            }
            TypeKind::Optional { element } => match value {
                Value::Null => out.push(0),
                value => {
                    out.push(1);
                    self.write(*element, value, at, depth, out)?;
                }
            },
            TypeKind::Struct { members } | TypeKind::Exception { members } => {
                self.write_members(members, value, at, depth, out)?;
            }
            TypeKind::Union { switch, members } => {
                self.write_union(*switch, members, value, at, depth, out)?;
            }
            _ => out.push(0),
        }
        Ok(())
    }

    /// Writes the number of an enumerator, which is given by name or number.
    fn write_enumerator(
        &self,
        enumerators: &[TypeId],
        value: &Value,
        at: &str,
        out: &mut Vec<u8>,
    ) -> Result<(), ValueError> {
        let named =
            |name: &str| enumerators.iter().position(|&enumerator| self.name(enumerator) == name);
        let found = match value {
            Value::Null => Some(0),
            Value::String(name) => named(name.rsplit("::").next().unwrap_or(name)),
            value => value
                .as_u64()
                .and_then(|number| usize::try_from(number).ok())
                .filter(|&number| number < enumerators.len()),
        };
        let Some(found) = found.and_then(|number| u32::try_from(number).ok()) else {
            let names: Vec<String> =
                enumerators.iter().map(|&enumerator| self.name(enumerator)).collect();
            return wrong(at, format!("one of {}", names.join(", ")));
        };
        out.extend(found.to_ne_bytes());
        Ok(())
    }

    /// Writes all members; those that are not given are zero.
    fn write_members(
        &self,
        members: &[TypeId],
        value: &Value,
        at: &str,
        depth: usize,
        out: &mut Vec<u8>,
    ) -> Result<(), ValueError> {
        let given = object(value, at)?;
        let known = |key: &&String| members.iter().any(|&member| self.name(member) == **key);
        if let Some(unknown) = given.and_then(|given| given.keys().find(|key| !known(key))) {
            let names: Vec<String> = members.iter().map(|&member| self.name(member)).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let place = format!("{at}.{unknown}");
            return super::unknown(&place, "a member of the structure", unknown, &names);
        }
        for &member in members {
            let name = self.name(member);
            let value = given.and_then(|given| given.get(&name)).unwrap_or(&Value::Null);
            self.write(member, value, &format!("{at}.{name}"), depth, out)?;
        }
        Ok(())
    }

    /// Writes the discriminator and the member that it selects.
    fn write_union(
        &self,
        switch: TypeId,
        members: &[TypeId],
        value: &Value,
        at: &str,
        depth: usize,
        out: &mut Vec<u8>,
    ) -> Result<(), ValueError> {
        let given = object(value, at)?;
        let chooses = given.and_then(|given| given.get("_d")).unwrap_or(&Value::Null);
        self.write(switch, chooses, &format!("{at}._d"), depth, out)?;
        let number = self.discriminator(switch, chooses);
        if let Some(member) = self.chosen(members, number) {
            let name = self.name(member);
            let value = given.and_then(|given| given.get(&name)).unwrap_or(&Value::Null);
            self.write(member, value, &format!("{at}.{name}"), depth, out)?;
        }
        Ok(())
    }
}

/// Writes a string with its length.
fn write_text(
    bound: Option<u64>,
    value: &Value,
    at: &str,
    out: &mut Vec<u8>,
) -> Result<(), ValueError> {
    let text = match value {
        Value::Null => "",
        Value::String(text) => text.as_str(),
        _ => return wrong(at, "a string"),
    };
    if let Some(bound) = bound
        && text.len() as u64 > bound
    {
        return wrong(at, format!("a string of at most {bound} bytes"));
    }
    length(text.len(), at, out)?;
    out.extend(text.as_bytes());
    Ok(())
}

fn length(count: usize, at: &str, out: &mut Vec<u8>) -> Result<(), ValueError> {
    match u32::try_from(count) {
        Ok(count) => out.extend(count.to_ne_bytes()),
        Err(_) => return wrong(at, "something shorter"),
    }
    Ok(())
}

fn whole<T: TryFrom<i128> + Default>(
    value: &Value,
    at: &str,
    range: &str,
) -> Result<T, ValueError> {
    let number = match value {
        Value::Null => return Ok(T::default()),
        value => value.as_i64().map(i128::from).or(value.as_u64().map(i128::from)),
    };
    let number = number.and_then(|number| T::try_from(number).ok());
    match number {
        Some(number) => Ok(number),
        None => wrong(at, format!("a whole number of {range}")),
    }
}

fn number(value: &Value, at: &str) -> Result<f64, ValueError> {
    match value {
        Value::Null => Ok(0.),
        value => value.as_f64().map_or_else(|| wrong(at, "a number"), Ok),
    }
}

fn list<'v>(value: &'v Value, at: &str) -> Result<&'v [Value], ValueError> {
    match value {
        Value::Null => Ok(&[]),
        Value::Array(array) => Ok(array),
        _ => wrong(at, "a list"),
    }
}

fn object<'v>(value: &'v Value, at: &str) -> Result<Option<&'v Map<String, Value>>, ValueError> {
    match value {
        Value::Null => Ok(None),
        Value::Object(object) => Ok(Some(object)),
        _ => wrong(at, "an object"),
    }
}
