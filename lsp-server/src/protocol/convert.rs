//! Between the plain data of analysis (absolute paths, byte offsets) and protocol types (URIs,
//! positions in the negotiated encoding). The only place where either becomes the other.

pub mod position;
pub mod semantic_tokens;
pub mod symbol;
pub mod uri;

pub use position::{Encoding, Lines};
