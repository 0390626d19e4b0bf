//! Values in the Common Data Representation (CDR) of ROS 2, DDS and MCAP.
//!
//! Numbers are aligned to their size, counted from the end of the four bytes of the header (OMG, DDS-XTypes
//! 1.3, 7.4 and 7.6.3.1.2). The plain representation of version 1 in little-endian order is written. The
//! plain representations of both versions are read, in either order of bytes. An `optional` is a sequence of
//! at most one element, because ROS 2 has no optional values. [`Unions`] says how a union is represented.

use dotgen_analysis::model::{TypeId, TypeKind};

use super::value::{DEPTH, Reader, ValueError, Values, wrong};

/// Plain CDR of version 1, little-endian.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Converts the bytes of the [glue](super::glue) to CDR.
///
/// # Errors
/// The bytes are not a value of the type.
pub fn to_cdr(values: Values<'_>, ty: TypeId, bytes: &[u8]) -> Result<Vec<u8>, ValueError> {
    let mut to = CdrWriter::new(Unions::Plain);
    to.value(values, ty, &mut Reader::new(bytes))?;
    Ok(to.bytes)
}

/// Converts CDR to the bytes of the [glue](super::glue). Bytes after the value (padding) are ignored.
///
/// # Errors
/// The bytes are not a value of the type, or the representation is not supported.
pub fn from_cdr(values: Values<'_>, ty: TypeId, bytes: &[u8]) -> Result<Vec<u8>, ValueError> {
    let mut to = Vec::new();
    CdrReader::new(bytes, Unions::Plain)?.value(values, ty, &mut to)?;
    Ok(to)
}

/// The representation of a union in CDR.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unions {
    /// The discriminator and the selected branch: that of the standard.
    Plain,
    /// A structure of the discriminator and a sequence of at most one element for each branch, because ROS 2
    /// has no unions. Likewise, a structure without members has one byte.
    Branches,
}

/// The source of a value.
trait ValueReader {
    fn number<const N: usize>(&mut self) -> Result<[u8; N], ValueError>;
    /// A string, without its terminator.
    fn text(&mut self) -> Result<&[u8], ValueError>;
    /// True if an optional has a value.
    fn presence(&mut self) -> Result<bool, ValueError>;
    /// Passes the mark of a branch of a union, which must say whether the branch is selected.
    fn branch(&mut self, is_selected: bool) -> Result<(), ValueError>;
    /// Passes a structure without members.
    fn nothing(&mut self) -> Result<(), ValueError>;
    /// Number of remaining bytes.
    fn left(&self) -> usize;
}

/// The destination of a value.
trait ValueWriter {
    fn number<const N: usize>(&mut self, bytes: [u8; N]);
    fn text(&mut self, text: &[u8]);
    fn presence(&mut self, is_there: bool);
    /// Marks a branch of a union.
    fn branch(&mut self, is_selected: bool);
    /// Writes a structure without members.
    fn nothing(&mut self);
}

impl ValueReader for Reader<'_> {
    fn number<const N: usize>(&mut self) -> Result<[u8; N], ValueError> {
        self.take()
    }

    fn text(&mut self) -> Result<&[u8], ValueError> {
        let length = u32::from_ne_bytes(self.take()?);
        self.some(length as usize)
    }

    fn presence(&mut self) -> Result<bool, ValueError> {
        Ok(self.take::<1>()?[0] != 0)
    }

    fn branch(&mut self, _: bool) -> Result<(), ValueError> {
        Ok(())
    }

    fn nothing(&mut self) -> Result<(), ValueError> {
        Ok(())
    }

    fn left(&self) -> usize {
        Reader::left(self)
    }
}

/// Bytes of the glue to write: in the order of this machine, without padding.
struct GlueWriter<'o>(&'o mut Vec<u8>);

impl ValueWriter for GlueWriter<'_> {
    fn number<const N: usize>(&mut self, bytes: [u8; N]) {
        self.0.extend(bytes);
    }

    fn text(&mut self, text: &[u8]) {
        // A length that was read from 32 bits.
        self.number(u32::try_from(text.len()).unwrap_or(u32::MAX).to_ne_bytes());
        self.0.extend(text);
    }

    fn presence(&mut self, is_there: bool) {
        self.0.push(u8::from(is_there));
    }

    fn branch(&mut self, _: bool) {}

    fn nothing(&mut self) {}
}

/// CDR to write, with its header.
#[derive(Debug, Clone)]
pub struct CdrWriter {
    bytes: Vec<u8>,
    unions: Unions,
}

impl CdrWriter {
    /// A stream without values.
    pub fn new(unions: Unions) -> Self {
        CdrWriter { bytes: HEADER.to_vec(), unions }
    }

    /// Writes the next value of the glue.
    ///
    /// # Errors
    /// The bytes are not a value of the type.
    pub fn value(
        &mut self,
        values: Values<'_>,
        ty: TypeId,
        from: &mut Reader<'_>,
    ) -> Result<(), ValueError> {
        recode(values, ty, from, self, DEPTH).map(|_| ())
    }

    /// Writes a number, from bytes in the order of this machine.
    pub fn number<const N: usize>(&mut self, mut bytes: [u8; N]) {
        let length = self.bytes.len() - HEADER.len();
        self.bytes.resize(HEADER.len() + length.next_multiple_of(N), 0);
        if cfg!(target_endian = "big") {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    /// Writes a string.
    pub fn text(&mut self, text: &[u8]) {
        let length = u32::try_from(text.len() + 1).unwrap_or(u32::MAX);
        self.number(length.to_ne_bytes());
        self.bytes.extend(text);
        self.bytes.push(0);
    }

    /// Returns the stream.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

impl ValueWriter for CdrWriter {
    fn number<const N: usize>(&mut self, bytes: [u8; N]) {
        CdrWriter::number(self, bytes);
    }

    fn text(&mut self, text: &[u8]) {
        CdrWriter::text(self, text);
    }

    fn presence(&mut self, is_there: bool) {
        self.number(u32::from(is_there).to_ne_bytes());
    }

    fn branch(&mut self, is_selected: bool) {
        if self.unions == Unions::Branches {
            self.presence(is_selected);
        }
    }

    fn nothing(&mut self) {
        if self.unions == Unions::Branches {
            self.number([0]);
        }
    }
}

/// CDR to read, after its header.
#[derive(Debug, Clone)]
pub struct CdrReader<'b> {
    bytes: &'b [u8],
    at: usize,
    big: bool,
    /// Maximum alignment of numbers, in bytes.
    widest: usize,
    unions: Unions,
}

impl<'b> CdrReader<'b> {
    /// Reads a stream of either version and order of bytes.
    ///
    /// # Errors
    /// The header is that of another representation, or missing.
    pub fn new(bytes: &'b [u8], unions: Unions) -> Result<Self, ValueError> {
        let (big, widest) = match bytes {
            [0, 0, _, _, ..] => (true, 8),
            [0, 1, _, _, ..] => (false, 8),
            [0, 6, _, _, ..] => (true, 4),
            [0, 7, _, _, ..] => (false, 4),
            _ => return wrong("", "plain CDR"),
        };
        Ok(CdrReader { bytes: &bytes[4..], at: 0, big, widest, unions })
    }

    /// Reads the next value, and appends it to bytes of the glue.
    ///
    /// # Errors
    /// The next bytes are not a value of the type.
    pub fn value(
        &mut self,
        values: Values<'_>,
        ty: TypeId,
        to: &mut Vec<u8>,
    ) -> Result<(), ValueError> {
        recode(values, ty, self, &mut GlueWriter(to), DEPTH).map(|_| ())
    }

    /// Reads a number, as bytes in the order of this machine.
    ///
    /// # Errors
    /// The stream ends before.
    pub fn number<const N: usize>(&mut self) -> Result<[u8; N], ValueError> {
        self.at = self.at.next_multiple_of(N.min(self.widest));
        let foreign = self.big != cfg!(target_endian = "big");
        let mut number = [0; N];
        number.copy_from_slice(self.some(N)?);
        if foreign {
            number.reverse();
        }
        Ok(number)
    }

    fn some(&mut self, count: usize) -> Result<&'b [u8], ValueError> {
        let end = self.at.checked_add(count);
        let Some(found) = end.and_then(|end| self.bytes.get(self.at..end)) else {
            return wrong("", "a value that does not break off");
        };
        self.at += count;
        Ok(found)
    }

    /// Reads a string, without its terminator.
    ///
    /// # Errors
    /// The stream ends before, or the string has no terminator or several.
    pub fn text(&mut self) -> Result<&'b [u8], ValueError> {
        let length = u32::from_ne_bytes(self.number()?);
        let text = self.some(length as usize)?;
        match text.split_last() {
            // Some implementations write an empty string without its terminator.
            None => Ok(text),
            Some((0, text)) if !text.contains(&0) => Ok(text),
            _ => wrong("", "a string that ends with its zero"),
        }
    }
}

impl ValueReader for CdrReader<'_> {
    fn number<const N: usize>(&mut self) -> Result<[u8; N], ValueError> {
        CdrReader::number(self)
    }

    fn text(&mut self) -> Result<&[u8], ValueError> {
        CdrReader::text(self)
    }

    fn presence(&mut self) -> Result<bool, ValueError> {
        match u32::from_ne_bytes(self.number()?) {
            0 => Ok(false),
            1 => Ok(true),
            _ => wrong("", "a list of at most one"),
        }
    }

    fn branch(&mut self, is_selected: bool) -> Result<(), ValueError> {
        if self.unions == Unions::Branches && self.presence()? != is_selected {
            return wrong("", "a union with the branch that its discriminator selects only");
        }
        Ok(())
    }

    fn nothing(&mut self) -> Result<(), ValueError> {
        match self.unions {
            Unions::Plain => Ok(()),
            Unions::Branches => self.some(1).map(|_| ()),
        }
    }

    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }
}

fn copy<const N: usize>(
    from: &mut impl ValueReader,
    to: &mut impl ValueWriter,
) -> Result<[u8; N], ValueError> {
    let number = from.number::<N>()?;
    to.number(number);
    Ok(number)
}

/// Copies a value. Returns the number if the value can be the discriminator of a union.
fn recode(
    values: Values<'_>,
    ty: TypeId,
    from: &mut impl ValueReader,
    to: &mut impl ValueWriter,
    depth: usize,
) -> Result<Option<i64>, ValueError> {
    let Some(depth) = depth.checked_sub(1) else {
        return wrong("", "a value that is less deep");
    };
    let kind = values.kind(ty);
    if let Some(number) = recode_integer(kind, from, to)? {
        return Ok(Some(number));
    }
    match kind {
        TypeKind::Float => {
            copy::<4>(from, to)?;
        }
        TypeKind::Double => {
            copy::<8>(from, to)?;
        }
        TypeKind::String { bound } => {
            let text = from.text()?;
            if bound.is_some_and(|bound| text.len() as u64 > bound) {
                return wrong("", "a string that fits its bound");
            }
            to.text(text);
        }
        TypeKind::Array { element, length } => {
            for _ in 0..*length {
                recode(values, *element, from, to, depth)?;
            }
        }
        TypeKind::Sequence { element, bound } => {
            let count = u32::from_ne_bytes(copy(from, to)?);
            // Each element needs at least one byte, so a larger count is invalid.
            if bound.is_some_and(|bound| u64::from(count) > bound) || count as usize > from.left() {
                return wrong("", "a list that fits its bound");
            }
            for _ in 0..count {
                recode(values, *element, from, to, depth)?;
            }
        }
        TypeKind::Optional { element } => {
            let is_there = from.presence()?;
            to.presence(is_there);
            if is_there {
                recode(values, *element, from, to, depth)?;
            }
        }
        TypeKind::Struct { members } | TypeKind::Exception { members } => {
            for &member in members {
                recode(values, member, from, to, depth)?;
            }
            if members.is_empty() {
                from.nothing()?;
                to.nothing();
            }
        }
        TypeKind::Union { switch, members } => {
            let number = recode(values, *switch, from, to, depth)?.unwrap_or(0);
            let selected = values.chosen(members, number);
            for &member in members {
                let is_selected = selected == Some(member);
                from.branch(is_selected)?;
                to.branch(is_selected);
                if is_selected {
                    recode(values, member, from, to, depth)?;
                }
            }
        }
        _ => {
            copy::<1>(from, to)?;
        }
    }
    Ok(None)
}

/// Copies an integer, boolean or enumerator; `None` for a value of another type.
fn recode_integer(
    kind: &TypeKind,
    from: &mut impl ValueReader,
    to: &mut impl ValueWriter,
) -> Result<Option<i64>, ValueError> {
    Ok(Some(match kind {
        TypeKind::Boolean => {
            let byte = u8::from(from.number::<1>()? != [0]);
            to.number([byte]);
            i64::from(byte)
        }
        TypeKind::Octet => i64::from(u8::from_ne_bytes(copy(from, to)?)),
        TypeKind::Char => i64::from(i8::from_ne_bytes(copy(from, to)?)),
        TypeKind::Short => i64::from(i16::from_ne_bytes(copy(from, to)?)),
        TypeKind::UnsignedShort => i64::from(u16::from_ne_bytes(copy(from, to)?)),
        TypeKind::Long => i64::from(i32::from_ne_bytes(copy(from, to)?)),
        TypeKind::UnsignedLong => i64::from(u32::from_ne_bytes(copy(from, to)?)),
        TypeKind::LongLong => i64::from_ne_bytes(copy(from, to)?),
        TypeKind::UnsignedLongLong => {
            i64::try_from(u64::from_ne_bytes(copy(from, to)?)).unwrap_or(i64::MAX)
        }
        TypeKind::Enum { enumerators } => {
            let byte = u32::from_ne_bytes(copy(from, to)?);
            if byte as usize >= enumerators.len() {
                return wrong("", "one of the enumerators");
            }
            i64::from(byte)
        }
        _ => return Ok(None),
    }))
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    const TYPES: &str = "
        enum mode { OFF, ON, AUTO };
        union either switch (mode) { case ON: double d; default: octet o; };
        struct inner { octet a; double b; };
        struct all {
            boolean flag; long n; string text; sequence<short> list; double many[2];
            mode m; either e; optional<long long> maybe; inner i; char c; string<4> brief;
        };";

    fn with(check: impl Fn(Values<'_>, TypeId)) {
        let unit = dotgen_loaders::unit(TYPES).expect("it is right");
        let spec = &unit.spec;
        let all = spec.types.keys();
        let mut named = all.filter(|&ty| spec.ty(ty).name.as_deref() == Some("all"));
        check(Values::new(spec), named.next().expect("it is declared"));
    }

    fn value() -> Value {
        json!({
            "flag": true, "n": -2, "text": "hi", "list": [1, 2, 3], "many": [0.5, -1.0], "m": "AUTO",
            "e": {"_d": "ON", "d": 2.0}, "maybe": 7, "i": {"a": 9, "b": 4.0}, "c": 65, "brief": "",
        })
    }

    #[test]
    fn bytes_are_those_of_the_standard() {
        with(|values, ty| {
            let packed = values.encode(ty, &value()).expect("it is a value");
            let cdr = to_cdr(values, ty, &packed).expect("it is a value");
            let mut expected = HEADER.to_vec();
            expected.extend([1, 0, 0, 0]);
            expected.extend((-2i32).to_le_bytes());
            expected.extend([3, 0, 0, 0, b'h', b'i', 0, 0]);
            expected.extend([3, 0, 0, 0, 1, 0, 2, 0, 3, 0]);
            // Padding to a multiple of eight.
            expected.extend([0; 6]);
            expected.extend(0.5f64.to_le_bytes());
            expected.extend((-1f64).to_le_bytes());
            expected.extend([2, 0, 0, 0, 1, 0, 0, 0]);
            expected.extend(2f64.to_le_bytes());
            expected.extend([1, 0, 0, 0, 0, 0, 0, 0]);
            expected.extend(7i64.to_le_bytes());
            expected.extend([9, 0, 0, 0, 0, 0, 0, 0]);
            expected.extend(4f64.to_le_bytes());
            expected.extend([65, 0, 0, 0, 1, 0, 0, 0, 0]);
            assert_eq!(cdr, expected);
            assert_eq!(from_cdr(values, ty, &cdr).as_ref(), Ok(&packed));
        });
    }

    #[test]
    fn other_orders_and_alignments_are_read() {
        let unit = dotgen_loaders::unit("struct two { long a; double b; };").expect("it is right");
        let spec = &unit.spec;
        let all = spec.types.keys();
        let mut named = all.filter(|&ty| spec.ty(ty).name.as_deref() == Some("two"));
        let ty = named.next().expect("it is declared");
        let values = Values::new(spec);
        let wanted = values.encode(ty, &json!({"a": 3, "b": 0.25})).ok();
        let (a, b) = (3i32.to_be_bytes(), 0.25f64.to_be_bytes());
        let big = [&[0, 0, 0, 0], &a[..], &[0; 4], &b].concat();
        assert_eq!(from_cdr(values, ty, &big).ok(), wanted);
        let (a, b) = (3i32.to_le_bytes(), 0.25f64.to_le_bytes());
        let second = [&[0, 7, 0, 0], &a[..], &b].concat();
        assert_eq!(from_cdr(values, ty, &second).ok(), wanted);
        let padded = [&[0, 1, 0, 0], &a[..], &[0; 4], &b, &[0; 3]].concat();
        assert_eq!(from_cdr(values, ty, &padded).ok(), wanted);
    }

    #[test]
    fn whatever_comes_is_read_or_refused() {
        with(|values, ty| {
            let packed = values.encode(ty, &value()).expect("it is a value");
            let cdr = to_cdr(values, ty, &packed).expect("it is a value");
            for end in 0..cdr.len() {
                assert!(from_cdr(values, ty, &cdr[..end]).is_err(), "{end} bytes");
            }
            let mut random = fastrand::Rng::with_seed(1);
            for _ in 0..20_000 {
                let mut other = cdr.clone();
                for _ in 0..random.usize(1..4) {
                    let at = random.usize(0..other.len());
                    other[at] = random.u8(..);
                }
                if let Ok(read) = from_cdr(values, ty, &other) {
                    let again = to_cdr(values, ty, &read).expect("what was read is a value");
                    assert_eq!(from_cdr(values, ty, &again), Ok(read));
                }
            }
        });
    }
}
