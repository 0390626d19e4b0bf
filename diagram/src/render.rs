//! From a graph to bytes.

pub mod dot;
pub mod mermaid;
#[cfg(feature = "png")]
pub mod png;
pub mod svg;

#[cfg(test)]
mod hostile;
