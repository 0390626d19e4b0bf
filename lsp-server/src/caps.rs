//! Capabilities: what the client can do, what this server offers. Every decision that depends on
//! the client is made here.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use serde_json::{Value, json};

use crate::convert::Encoding;
use crate::convert::semantic_tokens::legend;
use crate::handlers::codels::actions;
use crate::proto::*;

/// What matters of the client's capabilities.
#[derive(Debug, Clone, Default)]
pub struct ClientCaps {
    /// Unit of `character` in positions.
    pub encoding: Encoding,
    /// The client asks for diagnostics, so none are pushed.
    pub pull_diagnostics: bool,
    /// `workspace/diagnostic/refresh`.
    pub diagnostic_refresh: bool,
    /// `workspace/semanticTokens/refresh`.
    pub semantic_tokens_refresh: bool,
    /// Semantic tokens come on top of a grammar's colours: those that say no more are not wanted.
    pub augments_syntax_tokens: bool,
    /// Related information in diagnostics.
    pub related_information: bool,
    /// `codeDescription` in diagnostics.
    pub code_description: bool,
    /// Nested document symbols.
    pub hierarchical_symbols: bool,
    /// `LocationLink` as the answer to definition, declaration, type definition.
    pub definition_link: bool,
    /// Folding by whole lines only.
    pub line_folding_only: bool,
    /// Hover in Markdown.
    pub markdown_hover: bool,
    /// Snippets in completion.
    pub snippets: bool,
    /// Offsets in the labels of parameters.
    pub label_offsets: bool,
    /// Answers `dotgen/documentText` (`initializationOptions.documentText`).
    pub document_text: bool,
    /// Images in hovers, with a size after `|` (`initializationOptions.hoverImages`).
    pub hover_images: bool,
    /// Wants to be told where verifications stand (`initializationOptions.verificationStatus`).
    pub verification_status: bool,
    /// Pictures between the lines of the text (`initializationOptions.inlineDiagrams`).
    pub inline_diagrams: bool,
    /// `CodeAction` literals.
    pub code_action_literals: bool,
    /// Versioned document changes in workspace edits.
    pub document_changes: bool,
    /// clangd's notification `textDocument/inactiveRegions`.
    pub inactive_regions: bool,
    /// `workspace/configuration`.
    pub configuration: bool,
    /// Dynamic registration of watched files.
    pub watched_files: bool,
    /// Dynamic registration of configuration changes.
    pub configuration_registration: bool,
    /// Changes of workspace folders.
    pub workspace_folders: bool,
    /// `workspace/applyEdit`.
    pub applies_edits: bool,
    /// `window/workDoneProgress/create`.
    pub progress: bool,
    /// New files in workspace edits.
    pub creates_files: bool,
    /// Changes that are confirmed before they are made.
    pub change_annotations: bool,
    /// `codeAction/resolve` for edits.
    pub resolves_edits: bool,
    /// `workspace/codeLens/refresh`.
    pub code_lens_refresh: bool,
    /// `window/showDocument`.
    pub show_document: bool,
    /// Registration of what is offered for documents in other languages.
    pub documents_registration: bool,
}

impl ClientCaps {
    /// From the parameters of `initialize`. `raw` is the same message before it became typed: it
    /// still has what the protocol types do not know.
    pub fn new(params: &InitializeParams, raw: &Value) -> ClientCaps {
        let capabilities = &params.capabilities;
        let text = capabilities.text_document.clone().unwrap_or_default();
        let workspace = capabilities.workspace.clone().unwrap_or_default();
        let window = capabilities.window.clone().unwrap_or_default();
        let diagnostics = text.publish_diagnostics.clone().unwrap_or_default();
        let links = |link_support: Option<bool>| link_support.unwrap_or(false);
        ClientCaps {
            encoding: Encoding::negotiate(
                capabilities
                    .general
                    .as_ref()
                    .and_then(|it| it.position_encodings.as_deref()),
            ),
            pull_diagnostics: text.diagnostic.is_some(),
            // ls-types calls the capability `diagnostic`; the protocol says `diagnostics`.
            diagnostic_refresh: flag(raw, "/capabilities/workspace/diagnostics/refreshSupport")
                || flag(raw, "/capabilities/workspace/diagnostic/refreshSupport"),
            semantic_tokens_refresh: flag(
                raw,
                "/capabilities/workspace/semanticTokens/refreshSupport",
            ),
            augments_syntax_tokens: flag(
                raw,
                "/capabilities/textDocument/semanticTokens/augmentsSyntaxTokens",
            ),
            related_information: diagnostics.related_information.unwrap_or(false)
                || flag(
                    raw,
                    "/capabilities/textDocument/diagnostic/relatedInformation",
                )
                || text.diagnostic.is_some(),
            code_description: diagnostics.code_description_support.unwrap_or(false)
                || text.diagnostic.is_some(),
            hierarchical_symbols: text
                .document_symbol
                .and_then(|it| it.hierarchical_document_symbol_support)
                .unwrap_or(false),
            definition_link: links(text.definition.and_then(|it| it.link_support)),
            line_folding_only: text
                .folding_range
                .and_then(|it| it.line_folding_only)
                .unwrap_or(false),
            markdown_hover: text
                .hover
                .and_then(|it| it.content_format)
                .is_none_or(|it| it.contains(&MarkupKind::Markdown)),
            snippets: flag(
                raw,
                "/capabilities/textDocument/completion/completionItem/snippetSupport",
            ),
            label_offsets: flag(
                raw,
                "/capabilities/textDocument/signatureHelp/signatureInformation/parameterInformation/labelOffsetSupport",
            ),
            document_text: flag(raw, "/initializationOptions/documentText"),
            hover_images: flag(raw, "/initializationOptions/hoverImages"),
            verification_status: flag(raw, "/initializationOptions/verificationStatus"),
            inline_diagrams: flag(raw, "/initializationOptions/inlineDiagrams"),
            code_action_literals: text
                .code_action
                .is_some_and(|it| it.code_action_literal_support.is_some()),
            document_changes: workspace
                .workspace_edit
                .and_then(|it| it.document_changes)
                .unwrap_or(false),
            inactive_regions: flag(
                raw,
                "/capabilities/textDocument/inactiveRegionsCapabilities/inactiveRegions",
            ),
            configuration: workspace.configuration.unwrap_or(false),
            watched_files: workspace
                .did_change_watched_files
                .and_then(|it| it.dynamic_registration)
                .unwrap_or(false),
            configuration_registration: workspace
                .did_change_configuration
                .and_then(|it| it.dynamic_registration)
                .unwrap_or(false),
            workspace_folders: workspace.workspace_folders.unwrap_or(false),
            applies_edits: flag(raw, "/capabilities/workspace/applyEdit"),
            progress: window.work_done_progress.unwrap_or(false),
            creates_files: operations(raw, "create"),
            change_annotations: raw
                .pointer("/capabilities/workspace/workspaceEdit/changeAnnotationSupport")
                .is_some_and(Value::is_object),
            resolves_edits: flag(raw, "/capabilities/textDocument/codeAction/dataSupport")
                && raw
                    .pointer("/capabilities/textDocument/codeAction/resolveSupport/properties")
                    .and_then(Value::as_array)
                    .is_some_and(|it| it.iter().any(|it| it == "edit")),
            code_lens_refresh: flag(raw, "/capabilities/workspace/codeLens/refreshSupport"),
            show_document: flag(raw, "/capabilities/window/showDocument/support"),
            documents_registration: ["synchronization", "codeAction", "codeLens", "references"]
                .iter()
                .all(|it| {
                    flag(
                        raw,
                        &format!("/capabilities/textDocument/{it}/dynamicRegistration"),
                    )
                }),
        }
    }
}

/// Whether workspace edits may do something to files.
fn operations(raw: &Value, wanted: &str) -> bool {
    let all = raw.pointer("/capabilities/workspace/workspaceEdit/resourceOperations");
    let mut all = all.and_then(Value::as_array).into_iter().flatten();
    all.any(|it| it == wanted)
}

fn flag(raw: &Value, pointer: &str) -> bool {
    raw.pointer(pointer).and_then(Value::as_bool) == Some(true)
}

/// Command of the server: shows an included file in the unit of another root.
pub const CHOOSE_ROOT: &str = "dotgen.chooseRoot";

fn strings(all: &[&str]) -> Vec<String> {
    all.iter().map(|it| (*it).to_owned()).collect()
}

/// What this server offers to that client.
pub fn server_capabilities(client: &ClientCaps) -> ServerCapabilities {
    ServerCapabilities {
        position_encoding: Some(client.encoding.kind()),
        text_document_sync: Some(TextDocumentSyncCapability::Options(
            TextDocumentSyncOptions {
                open_close: Some(true),
                change: Some(TextDocumentSyncKind::INCREMENTAL),
                save: Some(TextDocumentSyncSaveOptions::Supported(true)),
                ..TextDocumentSyncOptions::default()
            },
        )),
        document_symbol_provider: Some(OneOf::Left(true)),
        workspace_symbol_provider: Some(OneOf::Left(true)),
        folding_range_provider: Some(FoldingRangeProviderCapability::Simple(true)),
        selection_range_provider: Some(SelectionRangeProviderCapability::Simple(true)),
        document_link_provider: Some(DocumentLinkOptions {
            resolve_provider: Some(false),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        }),
        semantic_tokens_provider: Some(SemanticTokensServerCapabilities::SemanticTokensOptions(
            SemanticTokensOptions {
                legend: legend(),
                range: Some(true),
                full: Some(SemanticTokensFullOptions::Delta { delta: Some(true) }),
                ..SemanticTokensOptions::default()
            },
        )),
        definition_provider: Some(OneOf::Left(true)),
        declaration_provider: Some(DeclarationCapability::Simple(true)),
        type_definition_provider: Some(TypeDefinitionProviderCapability::Simple(true)),
        implementation_provider: Some(ImplementationProviderCapability::Simple(true)),
        completion_provider: Some(CompletionOptions {
            resolve_provider: Some(true),
            trigger_characters: Some(strings(&[".", ":", "<", "\"", "/", "#", " "])),
            ..CompletionOptions::default()
        }),
        signature_help_provider: Some(SignatureHelpOptions {
            trigger_characters: Some(strings(&["(", ",", "{"])),
            ..SignatureHelpOptions::default()
        }),
        rename_provider: Some(OneOf::Right(RenameOptions {
            prepare_provider: Some(true),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        })),
        document_formatting_provider: Some(OneOf::Left(true)),
        document_range_formatting_provider: Some(OneOf::Left(true)),
        document_on_type_formatting_provider: Some(DocumentOnTypeFormattingOptions {
            first_trigger_character: ";".to_owned(),
            more_trigger_character: Some(strings(&["}", "\n"])),
        }),
        code_lens_provider: Some(CodeLensOptions {
            resolve_provider: Some(true),
        }),
        inlay_hint_provider: Some(OneOf::Left(true)),
        call_hierarchy_provider: Some(CallHierarchyServerCapability::Simple(true)),
        execute_command_provider: Some(ExecuteCommandOptions {
            commands: [
                strings(&[
                    CHOOSE_ROOT,
                    crate::handlers::diagram::MERMAID,
                    crate::handlers::diagram::DOT,
                    crate::handlers::codels::lenses::SHOW_CODEL,
                ]),
                strings(&crate::generation::COMMANDS),
            ]
            .concat(),
            ..ExecuteCommandOptions::default()
        }),
        references_provider: Some(OneOf::Left(true)),
        document_highlight_provider: Some(OneOf::Left(true)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        code_action_provider: client.code_action_literals.then(|| {
            CodeActionProviderCapability::Options(CodeActionOptions {
                code_action_kinds: Some(vec![
                    CodeActionKind::QUICKFIX,
                    CodeActionKind::REFACTOR_EXTRACT,
                    CodeActionKind::REFACTOR_INLINE,
                    CodeActionKind::new("refactor.move"),
                    CodeActionKind::REFACTOR_REWRITE,
                    CodeActionKind::SOURCE_ORGANIZE_IMPORTS,
                    crate::handlers::code_action::GENERATE,
                    CodeActionKind::SOURCE_FIX_ALL,
                    crate::handlers::code_action::FIX_FINDINGS,
                    actions::SYNC,
                ]),
                resolve_provider: Some(client.resolves_edits),
                ..CodeActionOptions::default()
            })
        }),
        diagnostic_provider: client.pull_diagnostics.then(|| {
            DiagnosticServerCapabilities::Options(DiagnosticOptions {
                identifier: Some("dotgen".to_owned()),
                inter_file_dependencies: true,
                workspace_diagnostics: true,
                ..DiagnosticOptions::default()
            })
        }),
        workspace: Some(WorkspaceServerCapabilities {
            workspace_folders: Some(WorkspaceFoldersServerCapabilities {
                supported: Some(true),
                change_notifications: Some(OneOf::Left(true)),
            }),
            file_operations: Some(WorkspaceFileOperationsServerCapabilities {
                will_rename: Some(FileOperationRegistrationOptions {
                    filters: [
                        ("**/*.{gen,idl,h,hh}", FileOperationPatternKind::File),
                        ("**/*", FileOperationPatternKind::Folder),
                    ]
                    .map(|(glob, matches)| FileOperationFilter {
                        scheme: Some("file".to_owned()),
                        pattern: FileOperationPattern {
                            glob: glob.to_owned(),
                            matches: Some(matches),
                            options: None,
                        },
                    })
                    .to_vec(),
                }),
                ..WorkspaceFileOperationsServerCapabilities::default()
            }),
        }),
        ..ServerCapabilities::default()
    }
}

/// Extensions of the files that matter on disk.
const WATCHED_EXTENSIONS: [&str; 12] = [
    "gen", "idl", "scn", "pc", "c", "cc", "cpp", "cxx", "h", "hh", "hpp", "hxx",
];

/// Names of others.
const WATCHED_NAMES: [&str; 3] = ["dotgen.toml", "Makefile.am", "template.tcl"];

/// Whether a change of a file on disk matters because of its name.
pub(crate) fn is_watched(path: &Utf8Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|it| WATCHED_EXTENSIONS.contains(&it))
        || path
            .file_name()
            .is_some_and(|it| WATCHED_NAMES.contains(&it))
}

/// What is registered once the client is initialized.
pub(crate) fn registrations(client: &ClientCaps) -> Vec<Registration> {
    let mut registrations = Vec::new();
    if client.watched_files {
        let watcher = |glob: &str, kind| FileSystemWatcher {
            glob_pattern: GlobPattern::String(glob.to_owned()),
            kind,
        };
        let extensions = WATCHED_EXTENSIONS.join(",");
        let mut watchers = vec![watcher(&format!("**/*.{{{extensions}}}"), None)];
        watchers.extend(WATCHED_NAMES.map(|name| watcher(&format!("**/{name}"), None)));
        // Of a folder that goes, only its own end is told.
        watchers.push(watcher("**/*", Some(WatchKind::Delete)));
        registrations.push(Registration {
            id: "dotgen-watched-files".to_owned(),
            method: "workspace/didChangeWatchedFiles".to_owned(),
            register_options: serde_json::to_value(DidChangeWatchedFilesRegistrationOptions {
                watchers,
            })
            .ok(),
        });
    }
    if client.configuration_registration {
        registrations.push(Registration {
            id: "dotgen-configuration".to_owned(),
            method: "workspace/didChangeConfiguration".to_owned(),
            register_options: Some(json!({ "section": "dotgen" })),
        });
    }
    registrations
}

/// What is registered for documents in other languages: its id and method.
type Registered = (&'static str, &'static str);

/// Documents are sent, those of codels and of templates by one registration: one that two
/// registrations match may be sent twice.
const SENT: [Registered; 3] = [
    ("dotgen-documents-open", "textDocument/didOpen"),
    ("dotgen-documents-change", "textDocument/didChange"),
    ("dotgen-documents-close", "textDocument/didClose"),
];

/// What is asked about sources of codels.
const ASKED: [Registered; 3] = [
    ("dotgen-codels-action", "textDocument/codeAction"),
    ("dotgen-codels-lens", "textDocument/codeLens"),
    ("dotgen-codels-references", "textDocument/references"),
];

/// Languages of the files that templates are made of: those whose markers are coloured. Not ours:
/// these documents are sent anyway.
const TEMPLATE_LANGUAGES: [&str; 18] = [
    "asciidoc",
    "c",
    "cmake",
    "cpp",
    "dockerfile",
    "html",
    "ini",
    "java",
    "json",
    "makefile",
    "markdown",
    "plaintext",
    "properties",
    "python",
    "shellscript",
    "tcl",
    "xml",
    "yaml",
];

/// The documents in other languages that a client is to send, and nothing else of the server: the
/// editor's server for those languages keeps the rest.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct ForeignDocuments {
    /// Name of the folders with sources of codels.
    pub(crate) codels: Option<Utf8PathBuf>,
    /// Globs of the files of templates.
    pub(crate) templates: BTreeSet<String>,
}

impl ForeignDocuments {
    fn registered(&self) -> Vec<Registered> {
        let asked = self.codels.iter().flat_map(|_| ASKED);
        let sent = SENT.into_iter().filter(|_| *self != Self::default());
        sent.chain(asked).collect()
    }

    /// What is to be registered.
    pub(crate) fn registrations(&self) -> Vec<Registration> {
        let selector = |language: &str, pattern: &str| json!({ "language": language, "scheme": "file", "pattern": pattern });
        let codels = self.codels.iter().flat_map(|folder| {
            // What is above the folder cannot be told by a pattern.
            let pattern = match folder.file_name() {
                Some(name) => format!("**/{name}/**"),
                None => "**/*".to_owned(),
            };
            ["c", "cpp"].map(|it| selector(it, &pattern))
        });
        let codels: Vec<Value> = codels.collect();
        let templates = self
            .templates
            .iter()
            .flat_map(|glob| TEMPLATE_LANGUAGES.map(|it| selector(it, glob)));
        let sent: Vec<Value> = codels.iter().cloned().chain(templates).collect();
        let registration = |(id, method): Registered| {
            let mut options = json!({ "documentSelector": codels });
            match method {
                "textDocument/codeAction" => {
                    options["codeActionKinds"] = json!(["quickfix", actions::SYNC]);
                    options["resolveProvider"] = json!(true);
                }
                "textDocument/codeLens" => options["resolveProvider"] = json!(false),
                "textDocument/references" => {}
                _ => options["documentSelector"] = json!(sent),
            }
            if method == "textDocument/didChange" {
                options["syncKind"] = json!(2);
            }
            Registration {
                id: id.to_owned(),
                method: method.to_owned(),
                register_options: Some(options),
            }
        };
        self.registered().into_iter().map(registration).collect()
    }

    /// Takes [`ForeignDocuments::registrations`] back.
    pub(crate) fn unregistrations(&self) -> Vec<Unregistration> {
        let one = |(id, method): Registered| Unregistration {
            id: id.to_owned(),
            method: method.to_owned(),
        };
        self.registered().into_iter().map(one).collect()
    }
}
