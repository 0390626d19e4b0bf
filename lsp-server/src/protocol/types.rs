//! The only module that imports protocol types.
//!
//! Other modules use `types::Range`, `types::Uri` and so on. A move to another version of the protocol
//! library changes only this file and `convert/`.

pub use tower_lsp::jsonrpc::{Error, ErrorCode, Result};
pub use tower_lsp::ls_types::notification::{self, Notification};
pub use tower_lsp::ls_types::request::{
    self, GotoDeclarationParams, GotoDeclarationResponse, GotoImplementationParams,
    GotoImplementationResponse, GotoTypeDefinitionParams, GotoTypeDefinitionResponse,
};
pub use tower_lsp::ls_types::*;
pub use tower_lsp::{Client, ClientSocket, LanguageServer, LspService};

/// Shown as the source of every diagnostic.
pub const SOURCE: &str = "dotgen";
