//! Parts of a model that have no form in ROS 2.

use dotgen_analysis::model::Src;

/// A part of a model that is not offered to ROS 2.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The part: ``port `demo.pose` ``.
    pub part: String,
    /// The reason and the remedy.
    pub why: String,
    /// The place of the reason in the model.
    pub src: Src,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} is not offered to ROS 2: {}", self.part, self.why)
    }
}

impl std::error::Error for Refusal {}
