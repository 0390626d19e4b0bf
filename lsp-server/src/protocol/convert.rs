//! Conversions between the plain data of analysis (absolute paths, byte offsets) and protocol types (URIs,
//! positions in the negotiated encoding). No other module converts between them.

pub mod position;
pub mod semantic_tokens;
pub mod symbol;
pub mod uri;

pub use position::{Encoding, Lines};
