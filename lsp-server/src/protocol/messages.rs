//! Messages beyond the protocol. `docs/protocol.md` describes them for clients.

use serde::{Deserialize, Serialize};

use crate::protocol::types::{
    Notification, Position, ProgressToken, Range, TextDocumentIdentifier, Uri,
    VersionedTextDocumentIdentifier, WorkspaceDiagnosticReport,
};

/// clangd's `textDocument/inactiveRegions`: the regions of an open document that conditionals leave
/// out.
#[derive(Debug)]
pub enum InactiveRegions {}

impl Notification for InactiveRegions {
    type Params = InactiveRegionsParams;
    const METHOD: &'static str = "textDocument/inactiveRegions";
}

/// See [`InactiveRegions`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[allow(missing_docs, reason = "named by clangd's extension")]
pub struct InactiveRegionsParams {
    pub text_document: VersionedTextDocumentIdentifier,
    pub regions: Vec<Range>,
}

/// `dotgen/documentText`, a request of the server: the text of an open document as its client has it.
#[derive(Debug)]
pub enum DocumentTextRequest {}

impl crate::protocol::types::request::Request for DocumentTextRequest {
    type Params = TextDocumentIdentifier;
    type Result = Option<DocumentText>;
    const METHOD: &'static str = "dotgen/documentText";
}

/// Answer of [`DocumentTextRequest`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DocumentText {
    /// Version of the document.
    pub version: i32,
    /// All of its text.
    pub text: String,
}

/// Parameters of requests about a document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DocumentParams {
    /// The document.
    pub text_document: TextDocumentIdentifier,
}

/// Parameters of requests about a place in a document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct PositionParams {
    /// The document.
    pub text_document: TextDocumentIdentifier,
    /// The place.
    pub position: Position,
}

/// Answer of `dotgen/expandMacro`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct MacroExpansion {
    /// Name of the macro.
    pub name: String,
    /// What the call stands for.
    pub expansion: String,
    /// The call.
    pub range: Range,
}

/// Answer of `dotgen/includingRoots`: as included by whom a document may be shown.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct IncludingRoots {
    /// The root whose unit shows the document.
    pub current: Option<Uri>,
    /// All roots that include it, the current one first; the document itself if nobody does.
    pub roots: Vec<Uri>,
}

/// Answer of `dotgen/release`: the release of GenoM3 that a document is read as.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ReleaseInfo {
    /// Its number.
    pub release: String,
    /// Whether dotgen was compared with it.
    pub verified: bool,
    /// Who chose it, in words.
    pub origin: String,
}

/// Argument of the command `dotgen.chooseRoot`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ChooseRoot {
    /// The included document.
    pub uri: Uri,
    /// The root to show it in; without it dotgen chooses.
    #[serde(default)]
    pub root: Option<Uri>,
}

/// `$/progress` with a part of the answer to `workspace/diagnostic`.
#[derive(Debug)]
pub(crate) enum PartialDiagnostics {}

impl Notification for PartialDiagnostics {
    type Params = PartialDiagnosticsParams;
    const METHOD: &'static str = "$/progress";
}

/// See [`PartialDiagnostics`].
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct PartialDiagnosticsParams {
    /// As the request has it.
    pub(crate) token: ProgressToken,
    /// The part.
    pub(crate) value: WorkspaceDiagnosticReport,
}

/// `dotgen/verificationStatus`: where the verification of a document stands.
#[derive(Debug)]
pub enum VerificationStatus {}

impl Notification for VerificationStatus {
    type Params = VerificationStatusParams;
    const METHOD: &'static str = "dotgen/verificationStatus";
}

/// See [`VerificationStatus`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct VerificationStatusParams {
    /// The scenario, or the specification that is verified without one.
    pub uri: Uri,
    /// Version of the document it holds for; none if that is not open.
    pub version: Option<i32>,
    /// Where it stands.
    pub status: crate::verification::results::Status,
    /// Name of the scenario.
    pub scenario: String,
    /// Whether the scenario is written in a file.
    pub written: bool,
    /// Checks that are answered for this version; while it is at work, these answers are final.
    pub answered: Option<usize>,
    /// Checks that there are.
    pub checks: Option<usize>,
    /// The least number of cores with which no deadline is missed, once it is known.
    pub minimum_cores: Option<u32>,
    /// States of the answer, if it is of this version.
    pub states: Option<usize>,
    /// How long it took.
    pub seconds: Option<f64>,
}
