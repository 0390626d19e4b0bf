//! `dotgen mcp`: the commands of dotgen as tools of the Model Context Protocol.
//!
//! A tool runs this program with the arguments of a command, so that an assistant reads what people read.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use clap::Args;
use rmcp::handler::server::wrapper::Parameters;
use rmcp::model::{CallToolResult, ContentBlock, ServerCapabilities, ServerConfig};
use rmcp::{ServerHandler, ServiceExt, schemars, tool, tool_handler, tool_router};
use serde::Deserialize;

use super::{Outcome, logging};
use dotgen_platform::process;

/// Longest answer, in bytes: about 2,000 tokens.
const MAX_ANSWER_BYTES: usize = 7_000;
/// Time after which a command is ended.
const TIMEOUT: Duration = Duration::from_secs(120);

/// Serve dotgen's commands as tools of the Model Context Protocol, on standard input and output
///
/// For assistants. Tools: look_up, check, fix, codels, verify, simulate, draw, explain. Only `fix` and
/// `codels` change files.
#[derive(Debug, Args)]
pub(super) struct Arguments {}

pub(super) fn run() -> anyhow::Result<Outcome> {
    logging::install("warn");
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    runtime.block_on(async {
        let service = Tools.serve(rmcp::transport::stdio()).await?;
        service.waiting().await?;
        anyhow::Ok(())
    })?;
    runtime.shutdown_background();
    Ok(Outcome::Fine)
}

#[derive(Debug, Clone, Copy)]
struct Tools;

/// A name to look up.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
struct Name {
    /// Name of a declaration: `fill`, `pump.fill.start`
    name: String,
    /// Specification, or folder of specifications
    #[serde(default = "here")]
    path: String,
}

/// Specifications.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
struct Specifications {
    /// Specification (.gen), scenario (.scn), or a folder of them
    #[serde(default = "here")]
    path: String,
}

/// What to do with codels.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
struct Codels {
    /// Specification, or folder of specifications
    #[serde(default = "here")]
    path: String,
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
struct Simulation {
    /// Scenario (.scn) or specification (.gen)
    path: String,
    /// Simulated time: `500ms`, `10s`
    #[serde(default = "ten_seconds")]
    duration: String,
}

/// A picture.
#[derive(Debug, Deserialize, schemars::JsonSchema)]
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
        description = "Find a declaration of GenoM3 specifications by name: place, documentation, uses, findings"
    )]
    async fn look_up(&self, Parameters(it): Parameters<Name>) -> CallToolResult {
        command(["query", "--", &it.name, &it.path]).await
    }

    #[tool(
        description = "Check GenoM3 specifications and scenarios: errors, warnings, and what would fix them"
    )]
    async fn check(&self, Parameters(it): Parameters<Specifications>) -> CallToolResult {
        command(["check", "--", &it.path]).await
    }

    #[tool(
        description = "Apply every unambiguous fix to specifications and report the rest; changes files"
    )]
    async fn fix(&self, Parameters(it): Parameters<Specifications>) -> CallToolResult {
        command(["check", "--fix", "--", &it.path]).await
    }

    #[tool(
        description = "Compare, repair or write the C and C++ functions (codels) of a specification"
    )]
    async fn codels(&self, Parameters(it): Parameters<Codels>) -> CallToolResult {
        let action = match it.action {
            CodelAction::Check => "check",
            CodelAction::Sync => "sync",
            CodelAction::Stub => "stub",
        };
        command(["codels", action, "--", &it.path]).await
    }

    #[tool(
        description = "Verify deadlines, response times and properties; a failure comes with its cause and remedy"
    )]
    async fn verify(&self, Parameters(it): Parameters<Specifications>) -> CallToolResult {
        command(["verify", "--", &it.path]).await
    }

    #[tool(
        description = "Run components on the virtual clock with simulated codels, and report times and violations"
    )]
    async fn simulate(&self, Parameters(it): Parameters<Simulation>) -> CallToolResult {
        command([
            "run",
            "--simulate",
            "all",
            "--until",
            &it.duration,
            "--",
            &it.path,
        ])
        .await
    }

    #[tool(description = "Draw state machines, a system or locks, as Mermaid")]
    async fn draw(&self, Parameters(it): Parameters<Picture>) -> CallToolResult {
        let of = match it.of {
            PictureKind::Fsm => "fsm",
            PictureKind::System => "system",
            PictureKind::Locks => "locks",
        };
        command(["diagram", of, "--format", "mermaid", "--", &it.path]).await
    }

    #[tool(description = "Explain a diagnostic by its code: meaning, reason, and how to mend it")]
    async fn explain(&self, Parameters(it): Parameters<Code>) -> CallToolResult {
        command(["explain", "--", &it.code]).await
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

/// Runs a command of this program. Its exit status 0 or 1 (something was found) is an answer; others are
/// errors.
async fn command<const N: usize>(arguments: [&str; N]) -> CallToolResult {
    let arguments = arguments.map(OsString::from).to_vec();
    let answer = tokio::task::spawn_blocking(move || run_self(arguments)).await;
    match answer {
        Ok(Ok((code, text))) => {
            let content = vec![ContentBlock::text(shortened(&text))];
            match code {
                Some(0 | 1) => CallToolResult::success(content),
                _ => CallToolResult::error(content),
            }
        }
        Ok(Err(error)) => CallToolResult::error(vec![ContentBlock::text(format!(
            "dotgen does not start: {error}"
        ))]),
        Err(error) => CallToolResult::error(vec![ContentBlock::text(format!(
            "the command was lost: {error}"
        ))]),
    }
}

fn run_self(arguments: Vec<OsString>) -> std::io::Result<(Option<i32>, String)> {
    let own = std::env::current_exe()?;
    let environment = [("NO_COLOR", "1".to_owned()), ("COLUMNS", "100".to_owned())];
    let mut child = process::ask(&own.to_string_lossy(), arguments, &environment)?;
    let started = Instant::now();
    let late = || started.elapsed() > TIMEOUT;
    let (status, printed) = child.wait_with_output_unless(&late)?;
    let mut text = String::from_utf8_lossy(&printed).into_owned();
    if status.code().is_none() && late() {
        text += &format!("\nended after {} s: name a smaller part", TIMEOUT.as_secs());
    }
    Ok((status.code(), text))
}

/// The beginning of a long text, up to the end of a line, with the number of lines that are left out.
fn shortened(text: &str) -> String {
    if text.len() <= MAX_ANSWER_BYTES {
        return text.to_owned();
    }
    let starts = text.char_indices().map(|(at, _)| at);
    let end = starts
        .take_while(|at| *at <= MAX_ANSWER_BYTES)
        .last()
        .unwrap_or_default();
    let end = text[..end].rfind('\n').map_or(end, |at| at + 1);
    let left = text[end..].lines().count();
    format!(
        "{}… {left} more lines: name one file or declaration\n",
        &text[..end]
    )
}
