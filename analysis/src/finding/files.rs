//! Findings about files and the parts of them that are read.

use dotgen_syntax::findings;

use crate::{
    fixes::{FixSite, TextFix},
    model::Name,
};

findings! {
    /// A problem with reading a file.
    pub enum FileProblem {
        "pp-input" NoFile => "no such file";
        "pp-input" Directory => "this is a directory, not a specification";
        "pp-input" Unreadable { why: Name } => "this file cannot be read: {why}";
        "pp-input" TooLarge { size: u64, limit: u64 }
            => "this file is not read: it has {size} kB, more than the {limit} kB of the setting \
                `max-file-size`",
               "raise the setting, or split the file";
        "not-utf8" NotUtf8 => "this file is not UTF-8 from here on", "save it as UTF-8";
        "pp-include-place" MisplacedInclude
            => "a file cannot be included in the middle of a declaration",
               "include it between two declarations, or write its text here";
        "inactive-code" Inactive
            => "left out by the preprocessor: the condition above does not hold";
    }
}

impl FileProblem {
    /// The fixes, made from the text around.
    pub(crate) fn fixes(&self, _: &FixSite<'_>) -> Vec<TextFix> {
        Vec::new()
    }
}
