//! The capabilities of this server.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use serde_json::{Value, json};

use crate::features::codels::actions;
use crate::features::commands;
use crate::protocol::client::ClientCaps;
use crate::protocol::convert::semantic_tokens::legend;
use crate::protocol::types::*;

fn strings(all: &[&str]) -> Vec<String> {
    all.iter().map(|text| (*text).to_owned()).collect()
}

pub(crate) fn server_capabilities(client: &ClientCaps) -> ServerCapabilities {
    ServerCapabilities {
        position_encoding: Some(client.encoding.kind()),
        text_document_sync: Some(TextDocumentSyncCapability::Options(TextDocumentSyncOptions {
            open_close: Some(true),
            change: Some(TextDocumentSyncKind::INCREMENTAL),
            save: Some(TextDocumentSyncSaveOptions::Supported(true)),
            ..TextDocumentSyncOptions::default()
        })),
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
                full: Some(SemanticTokensFullOptions::Bool(true)),
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
        code_lens_provider: Some(CodeLensOptions { resolve_provider: Some(true) }),
        inlay_hint_provider: Some(OneOf::Left(true)),
        call_hierarchy_provider: Some(CallHierarchyServerCapability::Simple(true)),
        execute_command_provider: Some(ExecuteCommandOptions {
            commands: [
                strings(&[
                    commands::CHOOSE_ROOT,
                    commands::MERMAID,
                    commands::DOT,
                    commands::SHOW_CODEL,
                ]),
                strings(&crate::features::generation::COMMANDS),
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
                    crate::features::specification::code_action::GENERATE,
                    CodeActionKind::SOURCE_FIX_ALL,
                    crate::features::specification::code_action::FIX_FINDINGS,
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
                        ("**/*.{gen,idl,h,hh,scn}", FileOperationPatternKind::File),
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

/// Extensions of the files whose changes on disk are watched.
const WATCHED_EXTENSIONS: [&str; 13] =
    ["gen", "idl", "scn", "wcet", "pc", "c", "cc", "cpp", "cxx", "h", "hh", "hpp", "hxx"];

/// Names of watched files with other extensions.
const WATCHED_NAMES: [&str; 3] = ["dotgen.toml", "Makefile.am", "template.tcl"];

/// True if changes of a file on disk are watched, by its name.
pub(crate) fn is_watched(path: &Utf8Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|extension| WATCHED_EXTENSIONS.contains(&extension))
        || path.file_name().is_some_and(|name| WATCHED_NAMES.contains(&name))
}

/// The registrations that are sent after `initialized`.
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
        // The deletion of a folder is reported for the folder alone, not for its files.
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

/// A registration for documents in other languages: its id and method.
type DocumentRegistration = (&'static str, &'static str);

/// Synchronization of documents. One registration covers codels and templates: a document that matches two
/// registrations may be sent twice.
const NOTIFICATION_REGISTRATIONS: [DocumentRegistration; 3] = [
    ("dotgen-documents-open", "textDocument/didOpen"),
    ("dotgen-documents-change", "textDocument/didChange"),
    ("dotgen-documents-close", "textDocument/didClose"),
];

/// Requests about sources of codels.
const REQUEST_REGISTRATIONS: [DocumentRegistration; 6] = [
    ("dotgen-codels-completion", "textDocument/completion"),
    ("dotgen-codels-action", "textDocument/codeAction"),
    ("dotgen-codels-lens", "textDocument/codeLens"),
    ("dotgen-codels-definition", "textDocument/definition"),
    ("dotgen-codels-hover", "textDocument/hover"),
    ("dotgen-codels-references", "textDocument/references"),
];

/// Languages of template files, in which markers are coloured. dotgen's own languages are absent: their
/// documents are sent in any case.
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

/// The documents in other languages that the client sends. Other features of those languages belong to the
/// editor's server for them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct ForeignDocuments {
    /// Folders with sources of codels, relative to their specifications.
    pub(crate) codels: BTreeSet<Utf8PathBuf>,
    /// Globs of the files of templates.
    pub(crate) templates: BTreeSet<String>,
}

impl ForeignDocuments {
    fn registered(&self) -> Vec<DocumentRegistration> {
        let asked =
            (!self.codels.is_empty()).then_some(REQUEST_REGISTRATIONS).into_iter().flatten();
        let sent = NOTIFICATION_REGISTRATIONS.into_iter().filter(|_| *self != Self::default());
        sent.chain(asked).collect()
    }

    /// The registrations for these documents.
    pub(crate) fn registrations(&self) -> Vec<Registration> {
        let selector = |language: &str, pattern: &str| json!({ "language": language, "scheme": "file", "pattern": pattern });
        let patterns = self.codels.iter().map(|folder| {
            // A pattern cannot contain the path above the folder.
            match folder.file_name() {
                Some(name) => format!("**/{name}/**"),
                None => "**/*".to_owned(),
            }
        });
        // Folders of different projects may have one name.
        let patterns: BTreeSet<String> = patterns.collect();
        let codels = patterns
            .iter()
            .flat_map(|pattern| ["c", "cpp"].map(|language| selector(language, pattern)));
        let codels: Vec<Value> = codels.collect();
        let templates = self
            .templates
            .iter()
            .flat_map(|glob| TEMPLATE_LANGUAGES.map(|language| selector(language, glob)));
        let sent: Vec<Value> = codels.iter().cloned().chain(templates).collect();
        let registration = |(id, method): DocumentRegistration| {
            let mut options = json!({ "documentSelector": codels });
            match method {
                "textDocument/codeAction" => {
                    options["codeActionKinds"] = json!(["quickfix", actions::SYNC]);
                    options["resolveProvider"] = json!(true);
                }
                "textDocument/completion" => {
                    options["resolveProvider"] = json!(false);
                    options["triggerCharacters"] = json!([" "]);
                }
                "textDocument/codeLens" => options["resolveProvider"] = json!(false),
                "textDocument/definition" | "textDocument/hover" | "textDocument/references" => {}
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

    /// Reverses [`ForeignDocuments::registrations`].
    pub(crate) fn unregistrations(&self) -> Vec<Unregistration> {
        let one = |(id, method): DocumentRegistration| Unregistration {
            id: id.to_owned(),
            method: method.to_owned(),
        };
        self.registered().into_iter().map(one).collect()
    }
}
