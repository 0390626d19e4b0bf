//! The one place that imports protocol types.
//!
//! Everything else says `proto::Range`, `proto::Uri`, …, so that a move to another version of the
//! protocol library touches this file and `convert/`.

pub use tower_lsp::jsonrpc::{Error, ErrorCode, Result};
pub use tower_lsp::ls_types::notification::{self, Notification};
pub use tower_lsp::ls_types::request::{
    GotoDeclarationParams, GotoDeclarationResponse, GotoImplementationParams,
    GotoImplementationResponse, GotoTypeDefinitionParams, GotoTypeDefinitionResponse,
};
pub use tower_lsp::ls_types::*;
pub use tower_lsp::{Client, ClientSocket, LanguageServer, LspService};
