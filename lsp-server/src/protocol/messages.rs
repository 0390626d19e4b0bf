//! Messages beyond the protocol. `docs/protocol.md` describes them for clients.

use serde::{Deserialize, Serialize};

use crate::protocol::types::{
    Notification, Position, ProgressToken, Range, TextDocumentIdentifier, Uri,
    VersionedTextDocumentIdentifier, WorkspaceDiagnosticReport,
};

/// clangd's `textDocument/inactiveRegions`: the regions of an open document that conditionals exclude.
#[derive(Debug)]
pub enum InactiveRegions {}

impl Notification for InactiveRegions {
    type Params = InactiveRegionsParams;
    const METHOD: &'static str = "textDocument/inactiveRegions";
}

/// See [`InactiveRegions`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct InactiveRegionsParams {
    pub text_document: VersionedTextDocumentIdentifier,
    pub regions: Vec<Range>,
}

/// `dotgen/documentText`, a request of the server: the client's text of an open document.
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
    /// The whole text.
    pub text: String,
}

/// Parameters of requests about a document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DocumentParams {
    pub text_document: TextDocumentIdentifier,
}

/// Parameters of requests about a place in a document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct PositionParams {
    pub text_document: TextDocumentIdentifier,
    /// The place.
    pub position: Position,
}

/// Answer of `dotgen/includingRoots`: the roots in whose units a document may be shown.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct IncludingRoots {
    /// The root whose unit shows the document.
    pub current: Option<Uri>,
    /// All roots that include it, the current one first; the document itself if there are none.
    pub roots: Vec<Uri>,
}

/// Answer of `dotgen/release`: the release of GenoM3 that a document is read as.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ReleaseInfo {
    /// Its number.
    pub release: String,
    /// True if dotgen was compared with this release.
    pub verified: bool,
    /// The source of the choice, as text.
    pub origin: String,
}

/// Argument of the command `dotgen.chooseRoot`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ChooseRoot {
    /// The included document.
    pub uri: Uri,
    /// The root to show it in; by default dotgen chooses.
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
    /// The token of the request.
    pub(crate) token: ProgressToken,
    /// The part.
    pub(crate) value: WorkspaceDiagnosticReport,
}

/// `dotgen/verificationStatus`: the status of the verification of a document.
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
    /// Version of the verified document; none if it is not open.
    pub version: Option<i32>,
    pub status: dotgen_views::verification::results::Status,
    /// Name of the scenario.
    pub scenario: String,
    /// True if the scenario is in a file.
    pub written: bool,
    /// Number of checks with a final answer for this version.
    pub answered: Option<usize>,
    /// Total number of checks.
    pub checks: Option<usize>,
    /// The minimum number of cores with which every deadline is met, if it is known.
    pub minimum_cores: Option<u32>,
    /// Number of explored states, if the answer is for this version.
    pub states: Option<usize>,
    /// Duration of the verification in seconds.
    pub seconds: Option<f64>,
}
