//! `dotgen mcp`: the commands of dotgen as tools of the Model Context Protocol.
//!
//! A tool runs this program with the arguments of a command, so that an assistant reads what people read.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use dotgen_codegen::process::{Channels, Processes, Program, Resources};
use rmcp::handler::server::wrapper::Parameters;
use rmcp::model::{CallToolResult, ContentBlock, ServerCapabilities, ServerConfig};
use rmcp::service::RequestContext;
use rmcp::{RoleServer, ServerHandler, ServiceExt, schemars, tool, tool_handler, tool_router};
use serde::Deserialize;
use std::ffi::OsString;
use tokio::sync::Mutex;

use super::{CommandExit, logging};
use dotgen_platform::process;

/// Maximum length of the output in an answer, and of the messages after it, in bytes. Together they are about
/// 2,000 tokens.
const MAX_OUTPUT_BYTES: usize = 5_500;
const MAX_MESSAGE_BYTES: usize = 1_300;
/// Time after which a command is ended.
const TIMEOUT: Duration = Duration::from_mins(2);
/// Time limit of a verification, in seconds: what is answered by then is printed.
const VERIFY_SECONDS: &str = "100";

/// A request, which can be cancelled.
type Context = RequestContext<RoleServer>;

/// Serve commands as tools of the Model Context Protocol on standard input and output
///
/// For assistants. Tools: look_up, check, fix, codels, verify, simulate, draw, explain. Only `fix` and
/// `codels` change files.
#[derive(Debug, Args)]
pub(super) struct Arguments {}

pub(super) fn run() -> anyhow::Result<CommandExit> {
    let log = logging::install("warn");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(async {
        let service = Tools::default().serve(rmcp::transport::stdio()).await?;
        service.waiting().await?;
        anyhow::Ok(())
    })?;
    runtime.shutdown_background();
    log.wait();
    Ok(CommandExit::Fine)
}

/// The tools. One command runs at a time, so that commands do not edit the same files.
#[derive(Debug, Clone, Default)]
struct Tools {
    turn: Arc<Mutex<()>>,
}

/// A name to look up.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Name {
    /// Name of a declaration: `fill`, `pump.fill.start`
    name: String,
    /// Specification, or folder of specifications
    #[serde(default = "here")]
    path: String,
}

/// Specifications.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Specifications {
    /// Specification (.gen), scenario (.scn), or a folder of them
    #[serde(default = "here")]
    path: String,
}

/// Specifications to fix.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Fixes {
    /// Specification (.gen), scenario (.scn), or a folder of them, all of which may be changed
    path: String,
    /// Also apply the first fix of errors that could be meant in another way
    #[serde(default)]
    unsafe_fixes: bool,
}

/// What to do with codels.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Codels {
    /// Specification, or folder of specifications; required for `sync` and `stub`
    #[serde(default)]
    path: Option<String>,
    /// What to do
    #[serde(default)]
    action: CodelAction,
}

#[derive(Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum CodelAction {
    /// Report C and C++ functions that disagree with the specification
    #[default]
    Check,
    /// Make both agree: edits the sources of codels
    Sync,
    /// Write stubs of missing codels
    Stub,
}

/// A run.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Simulation {
    /// Scenario (.scn) or specification (.gen)
    path: String,
    /// Simulated time: `500ms`, `10s`
    #[serde(default = "ten_seconds")]
    duration: String,
}

/// A picture.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Picture {
    /// Specification, or several files of a system
    path: String,
    /// What to draw
    #[serde(default)]
    of: PictureKind,
}

#[derive(Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum PictureKind {
    /// The state machines of all services and tasks
    #[default]
    Fsm,
    /// Components, ports and their connections
    System,
    /// Codels that exclude each other
    Locks,
}

/// The code of a diagnostic.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Code {
    /// Code in brackets at the end of a finding: `fsm/busy-loop`
    code: String,
}

fn here() -> String {
    ".".to_owned()
}

fn ten_seconds() -> String {
    "10s".to_owned()
}

#[tool_router]
impl Tools {
    #[tool(
        description = "Find a declaration of GenoM3 specifications by name: place, documentation, uses, findings",
        annotations(read_only_hint = true)
    )]
    async fn look_up(
        &self,
        Parameters(parameter): Parameters<Name>,
        context: Context,
    ) -> CallToolResult {
        self.command(["query", "--", &parameter.name, &parameter.path], &context).await
    }

    #[tool(
        description = "Check GenoM3 specifications and scenarios: errors, warnings, and what would fix them",
        annotations(read_only_hint = true)
    )]
    async fn check(
        &self,
        Parameters(parameter): Parameters<Specifications>,
        context: Context,
    ) -> CallToolResult {
        self.command(["check", "--", &parameter.path], &context).await
    }

    #[tool(
        description = "Apply every unambiguous fix to specifications and report the rest; changes files",
        annotations(read_only_hint = false, destructive_hint = true, idempotent_hint = true)
    )]
    async fn fix(
        &self,
        Parameters(parameter): Parameters<Fixes>,
        context: Context,
    ) -> CallToolResult {
        if parameter.unsafe_fixes {
            let words = ["check", "--fix", "--unsafe-fixes", "--", &parameter.path];
            self.command(words, &context).await
        } else {
            self.command(["check", "--fix", "--", &parameter.path], &context).await
        }
    }

    #[tool(
        description = "Compare, repair or write the C and C++ functions (codels) of a specification",
        annotations(read_only_hint = false, destructive_hint = true)
    )]
    async fn codels(
        &self,
        Parameters(parameter): Parameters<Codels>,
        context: Context,
    ) -> CallToolResult {
        let action = match parameter.action {
            CodelAction::Check => "check",
            CodelAction::Sync => "sync",
            CodelAction::Stub => "stub",
        };
        let path = match (parameter.path, parameter.action) {
            (Some(path), _) => path,
            (None, CodelAction::Check) => here(),
            (None, _) => {
                return failure(&format!(
                    "`path` is missing: `{action}` changes files, so name them"
                ));
            }
        };
        self.command(["codels", action, "--", &path], &context).await
    }

    #[tool(
        description = "Verify deadlines, response times and properties; a failure comes with its cause and remedy",
        annotations(read_only_hint = true)
    )]
    async fn verify(
        &self,
        Parameters(parameter): Parameters<Specifications>,
        context: Context,
    ) -> CallToolResult {
        self.command(["verify", "--timeout", VERIFY_SECONDS, "--", &parameter.path], &context).await
    }

    #[tool(
        description = "Run components on the virtual clock with simulated codels, and report times and violations",
        annotations(read_only_hint = true)
    )]
    async fn simulate(
        &self,
        Parameters(parameter): Parameters<Simulation>,
        context: Context,
    ) -> CallToolResult {
        self.command(
            ["run", "--simulate", "all", "--until", &parameter.duration, "--", &parameter.path],
            &context,
        )
        .await
    }

    #[tool(
        description = "Draw state machines, a system or locks, as Mermaid",
        annotations(read_only_hint = true)
    )]
    async fn draw(
        &self,
        Parameters(parameter): Parameters<Picture>,
        context: Context,
    ) -> CallToolResult {
        let of = match parameter.of {
            PictureKind::Fsm => "fsm",
            PictureKind::System => "system",
            PictureKind::Locks => "locks",
        };
        self.command(["diagram", of, "--format", "mermaid", "--", &parameter.path], &context).await
    }

    #[tool(
        description = "Explain a diagnostic by its code: meaning, reason, and how to mend it",
        annotations(read_only_hint = true)
    )]
    async fn explain(
        &self,
        Parameters(parameter): Parameters<Code>,
        context: Context,
    ) -> CallToolResult {
        self.command(["explain", "--", &parameter.code], &context).await
    }
}

#[tool_handler]
impl ServerHandler for Tools {
    fn get_info(&self) -> ServerConfig {
        let mut info = ServerConfig::new(ServerCapabilities::builder().enable_tools().build());
        info.server_info.name = "dotgen".into();
        info.server_info.version = env!("CARGO_PKG_VERSION").into();
        info.with_instructions(
            "GenoM3 components: specifications (.gen), verification scenarios (.scn) and codels in C or C++. \
             Check after every edit. Address declarations by name (look_up), not by position.",
        )
    }
}

impl Tools {
    /// Runs a command of this program, unless the request is cancelled. The exit statuses 0, 1 (something was
    /// found) and 3 (not finished within the limits) are answers; others are errors.
    async fn command<const N: usize>(
        &self,
        arguments: [&str; N],
        context: &Context,
    ) -> CallToolResult {
        // Every command but `explain` ends with its path.
        if arguments[0] != "explain"
            && let Some(path) = arguments.last()
            && let Err(error) = inside(Path::new(path))
        {
            return failure(&error);
        }
        let is_drawing = arguments[0] == "diagram";
        let arguments = arguments.map(Into::into).to_vec();
        let cancelled = context.ct.clone();
        let _turn = self.turn.lock().await;
        let answer =
            tokio::task::spawn_blocking(move || run_self(arguments, &|| cancelled.is_cancelled()))
                .await;
        let (code, output, errors) = match answer {
            Ok(Ok(answer)) => answer,
            Ok(Err(error)) => return failure(&format!("dotgen does not start: {error}")),
            Err(error) => return failure(&format!("the command was lost: {error}")),
        };
        if is_drawing && output.len() > MAX_OUTPUT_BYTES {
            return failure(&format!(
                "the drawing has {} bytes, {MAX_OUTPUT_BYTES} are allowed: name one file",
                output.len()
            ));
        }
        let output = shortened(&output, MAX_OUTPUT_BYTES);
        let errors = shortened(&errors, MAX_MESSAGE_BYTES);
        let texts = [output, errors].into_iter().filter(|output| !output.is_empty());
        let content = texts.map(ContentBlock::text).collect();
        match code {
            Some(0 | 1 | 3) => CallToolResult::success(content),
            _ => CallToolResult::error(content),
        }
    }
}

/// Checks that a path is in the folder that the server was started in. Links are followed.
///
/// # Errors
/// The reason and the remedy.
fn inside(path: &Path) -> Result<(), String> {
    let folder = std::env::current_dir().and_then(|folder| folder.canonicalize());
    let folder = folder.map_err(|error| format!("the server's folder is not readable: {error}"))?;
    let whole = folder.join(path);
    // The command reports a file that does not exist. Its place is that of the nearest folder that does.
    let existing = whole.ancestors().find_map(|ancestor| ancestor.canonicalize().ok());
    let climbs = path.components().any(|part| part == Component::ParentDir) && !whole.exists();
    if !climbs && existing.is_some_and(|existing| existing.starts_with(&folder)) {
        return Ok(());
    }
    Err(format!(
        "`{}` is outside of {}: start `dotgen mcp` in a folder that contains it",
        path.display(),
        folder.display()
    ))
}

fn failure(message: &str) -> CallToolResult {
    CallToolResult::error(vec![ContentBlock::text(message)])
}

/// Runs this program in a group of its own, which ends with this process. Returns its exit status and both
/// outputs.
fn run_self(
    arguments: Vec<OsString>,
    is_cancelled: &dyn Fn() -> bool,
) -> std::io::Result<(Option<i32>, String, String)> {
    let program = Program {
        path: std::env::current_exe()?,
        arguments,
        directory: PathBuf::new(),
        channels: Channels::Pipes,
        resources: Resources::default(),
        access: None,
        outlives: Duration::ZERO,
    };
    let mut child = process::System.start(&program)?;
    let started = Instant::now();
    let is_late = || started.elapsed() > TIMEOUT;
    let (status, output, errors) =
        child.wait_with_outputs_unless(&|| is_late() || is_cancelled())?;
    let mut errors = String::from_utf8_lossy(&errors).into_owned();
    if status.code().is_none() && is_late() {
        errors += &format!("ended after {} s: name a smaller part\n", TIMEOUT.as_secs());
    }
    Ok((status.code(), String::from_utf8_lossy(&output).into_owned(), errors))
}

/// The text, or its beginning of `limit` bytes up to the end of a line, with the number of further lines.
fn shortened(text: &str, limit: usize) -> String {
    if text.len() <= limit {
        return text.to_owned();
    }
    let starts = text.char_indices().map(|(at, _)| at);
    let end = starts.take_while(|at| *at <= limit).last().unwrap_or_default();
    let end = text[..end].rfind('\n').map_or(end, |at| at + 1);
    let left = text[end..].lines().count();
    format!("{}… {left} more lines: name one file or declaration\n", &text[..end])
}
