//! One file per request. A handler takes a snapshot, the document and the parameters, asks
//! analysis, and converts the answer; it runs on the blocking pool and may be cancelled or panic.
//!
//! To add a request: write `handlers/<name>.rs`, add a method to `backend` that hands it to the
//! dispatcher, and announce it in `caps`.

pub(crate) mod call_hierarchy;
pub(crate) mod code_action;
pub(crate) mod code_lens;
pub(crate) mod codels;
pub(crate) mod completion;
pub(crate) mod diagnostic;
pub(crate) mod diagram;
pub(crate) mod document_highlight;
pub(crate) mod document_link;
pub(crate) mod document_symbol;
pub(crate) mod folding_range;
pub(crate) mod formatting;
pub(crate) mod goto;
pub(crate) mod hover;
pub(crate) mod inlay_hint;
pub(crate) mod inspect;
pub(crate) mod references;
pub(crate) mod rename;
pub(crate) mod scenario;
pub(crate) mod selection_range;
pub(crate) mod semantic_tokens;
pub(crate) mod signature_help;
pub(crate) mod verification;
pub(crate) mod workspace_symbol;
