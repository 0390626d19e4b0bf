//! Costs for large workspaces: whole commands, and a server driven in the form of an editor.

pub(super) mod workspace;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::client::{Document, Editor, result};
use super::measure::{Job, alternate, announce};
use super::{SECONDS, milliseconds};
use crate::chart::{Chart, Line};
use xtask::run::step;
use xtask::{root, target};

/// Characters typed in a component and in the shared file.
const TYPED: usize = 60;
/// Time without messages after which the server is taken to be idle.
const IDLE_TIME: Duration = Duration::from_millis(1500);

/// Measured values of a workspace by name, in the order of the table, in seconds or megabytes.
type Figures = Vec<(&'static str, f64)>;

const MEGABYTES: &[(f64, &str)] = &[(10.0, "10 MB"), (100.0, "100 MB"), (1000.0, "1 GB")];

/// Measures workspaces of growing size and draws the charts.
pub(super) fn size(dotgen: &Path, counts: &[usize], runs: usize) -> Result<()> {
    announce()?;
    let folder = target().join("size");
    let mut all: BTreeMap<usize, Figures> = BTreeMap::new();
    for &count in counts {
        step(&format!("{count} components of 1,000 lines"));
        let here = fresh(&folder, &format!("components-{count}"))?;
        workspace::write(&here, count)?;
        let mut figures = check(dotgen, &here, runs)?;
        figures.extend(serve(dotgen, &here, count)?);
        for (name, value) in &figures {
            println!("{name:<58} {value:>9.3}");
        }
        all.insert(count, figures);
        std::fs::remove_dir_all(&here)?;
    }
    table(&all);
    draw(&all)
}

/// Files of one line, from 1,000 to 10,000.
pub(super) fn tiny(dotgen: &Path, runs: usize) -> Result<()> {
    announce()?;
    let folder = target().join("size");
    println!("| files of one line | `dotgen check` |\n| --- | --- |");
    for count in [1_000, 3_000, 10_000] {
        let here = fresh(&folder, &format!("tiny-{count}"))?;
        workspace::write_tiny(&here, count)?;
        let figures = check(dotgen, &here, runs)?;
        let cells = figures.iter().map(|figure| format!("{:.2}", figure.1));
        println!("| {count} | {} |", cells.collect::<Vec<_>>().join(" · "));
        std::fs::remove_dir_all(&here)?;
    }
    Ok(())
}

fn fresh(folder: &Path, name: &str) -> Result<PathBuf> {
    let here = folder.join(name);
    if here.exists() {
        std::fs::remove_dir_all(&here)?;
    }
    std::fs::create_dir_all(&here)?;
    Ok(here)
}

/// `dotgen check` of a folder.
fn check(dotgen: &Path, folder: &Path, runs: usize) -> Result<Figures> {
    let job = Job {
        program: dotgen.to_str().unwrap_or("dotgen"),
        arguments: vec!["check".into(), ".".into()],
        directory: folder,
    };
    let taken = alternate(&[job], runs)?.pop().flatten();
    let taken = taken.context("`dotgen check` was given up")?;
    Ok(vec![
        ("check: elapsed", taken.elapsed),
        ("check: processor time", taken.seconds),
        ("check: peak memory, MB", taken.megabytes),
    ])
}

/// An editor in the workspace: the first file, typing, changes that affect all files, a rename, and the
/// memory for each.
fn serve(dotgen: &Path, folder: &Path, count: usize) -> Result<Figures> {
    let mut figures = Figures::new();
    let started = Instant::now();
    let mut session = Session::start(dotgen, folder)?;
    let text = workspace::component(count / 2);
    let mut component = session.editor.open(&workspace::name(count / 2), &text)?;
    session.pull(&component)?;
    figures.push(("first diagnostics of the opened file", seconds(started.elapsed())));
    let all = session.everything()?;
    figures.push(("first diagnostics of the workspace", seconds(all)));
    figures.push(("memory then, MB", session.memory()?));

    let line = line_of(&text, "  task slow {")?;
    figures.push((
        "keystroke to diagnostics in a component, p95",
        session.type_comment(&mut component, line)?,
    ));
    let text = workspace::shared();
    let mut shared = session.editor.open(workspace::SHARED, &text)?;
    session.pull(&shared)?;
    let line = line_of(&text, "// What all")?;
    figures.push((
        "keystroke to diagnostics in the shared file, p95",
        session.type_comment(&mut shared, line + 1)?,
    ));
    session.settle()?;

    // One more member: every component is checked again, and no finding changes.
    let line = line_of(&text, "  struct pose")?;
    let started = Instant::now();
    session.editor.edit(&mut shared, line, [16, 16], "undeclared more; ")?;
    let open = session.pull(&component)?;
    figures.push(("edit of the shared file to the open file", seconds(open)));
    session.everything()?;
    figures.push(("edit of the shared file to all", seconds(started.elapsed())));
    session.editor.edit(&mut shared, line, [16, 33], "")?;
    session.everything()?;

    // Every use in every file becomes an error.
    let line = line_of(&text, workspace::USED_BY_ALL)?;
    let started = Instant::now();
    session.editor.edit(&mut shared, line, [9, 12], "vek")?;
    session.everything()?;
    figures.push(("edit that makes all files wrong, to all", seconds(started.elapsed())));
    session.editor.edit(&mut shared, line, [9, 12], "vec")?;
    session.everything()?;
    figures.push(("memory then, MB", session.memory()?));

    let params = json!({ "textDocument": { "uri": shared.uri },
        "position": { "line": line, "character": 10 }, "newName": "vector" });
    let (time, edits) = session.editor.answer("textDocument/rename", params)?;
    let files = edits["changes"].as_object().map_or(0, serde_json::Map::len);
    let files = files.max(edits["documentChanges"].as_array().map_or(0, Vec::len));
    anyhow::ensure!(files == count + 1, "renamed in {files} files");
    figures.push(("rename of a type that all use", seconds(time)));
    let (peak, settled) = (session.peak()?, session.memory()?);
    figures.push(("peak memory of the server, MB", peak));
    figures.push(("memory after all that, MB", settled));
    let query = json!({ "query": "slow" });
    let (time, _) = session.editor.answer("workspace/symbol", query)?;
    figures.push(("symbols of the workspace", seconds(time)));
    figures.push(("memory after the symbols, MB", session.memory()?));
    session.editor.close(&shared)?;
    session.editor.close(&component)?;
    session.settle()?;
    figures.push(("memory with all closed, MB", session.memory()?));
    session.editor.end()?;
    Ok(figures)
}

fn line_of(text: &str, start: &str) -> Result<usize> {
    let found = text.lines().position(|line| line.starts_with(start));
    found.with_context(|| format!("no line begins with `{start}`"))
}

fn seconds(time: Duration) -> f64 {
    milliseconds(time) / 1e3
}

/// An editor that requests diagnostics as VS Code does: for the open document, and for the workspace.
pub(super) struct Session {
    pub(super) editor: Editor,
    /// The last result of each file.
    known: BTreeMap<String, String>,
    token: u64,
}

impl Session {
    pub(super) fn start(dotgen: &Path, folder: &Path) -> Result<Session> {
        let capabilities = json!({
            "textDocument": { "diagnostic": {}, "rename": { "prepareSupport": true } },
            "workspace": { "workspaceEdit": { "documentChanges": true } },
        });
        Ok(Session {
            editor: Editor::start(dotgen, folder, capabilities)?,
            known: BTreeMap::new(),
            token: 0,
        })
    }

    /// Requests the diagnostics of a document.
    pub(super) fn pull(&mut self, document: &Document) -> Result<Duration> {
        let params = json!({ "textDocument": { "uri": document.uri } });
        self.editor.request("textDocument/diagnostic", params)
    }

    /// As [`Session::everything`], for a client without results: it is answered even if nothing has changed.
    pub(super) fn everything_anew(&mut self) -> Result<Duration> {
        self.known.clear();
        self.everything()
    }

    /// Requests the diagnostics of the workspace until all files are reported. There must be changes, because
    /// the server waits for them. Returns the duration.
    pub(super) fn everything(&mut self) -> Result<Duration> {
        let method = "workspace/diagnostic";
        self.token += 1;
        let known = self.known.iter();
        let known: Vec<Value> =
            known.map(|(uri, value)| json!({ "uri": uri, "value": value })).collect();
        let started = Instant::now();
        let params = json!({ "previousResultIds": known, "partialResultToken": self.token });
        let id = self.editor.ask(method, params)?;
        loop {
            let mut message = self.editor.next()?;
            if message.content["id"] == id {
                let all = result(method, message.content)?;
                self.learn(&all["items"]);
                return Ok(message.at - started);
            }
            if message.content["method"] == "$/progress"
                && message.content["params"]["token"] == self.token
            {
                let part = message.content["params"]["value"].take();
                self.learn(&part["items"]);
            }
        }
    }

    fn learn(&mut self, items: &Value) {
        for json in items.as_array().into_iter().flatten() {
            if let (Some(uri), Some(id)) = (json["uri"].as_str(), json["resultId"].as_str()) {
                self.known.insert(uri.to_owned(), id.to_owned());
            }
        }
    }

    /// Types a comment, a character at a time, and requests diagnostics after each. Returns the 95th
    /// percentile in seconds.
    fn type_comment(&mut self, document: &mut Document, line: usize) -> Result<f64> {
        self.editor.edit(document, line, [0, 0], "// \n")?;
        self.pull(document)?;
        let mut times = Vec::with_capacity(TYPED);
        for i in 0..TYPED {
            let started = Instant::now();
            self.editor.edit(document, line, [3 + i, 3 + i], "x")?;
            self.pull(document)?;
            times.push(started.elapsed());
        }
        self.editor.remove_line(document, line)?;
        self.pull(document)?;
        times.sort_unstable();
        Ok(seconds(times[(times.len() - 1) * 95 / 100]))
    }

    /// Waits until the server is idle.
    fn settle(&mut self) -> Result<()> {
        while self.editor.next_within(IDLE_TIME)?.is_some() {}
        Ok(())
    }

    /// Resident memory of the idle server, in MB.
    fn memory(&mut self) -> Result<f64> {
        self.settle()?;
        self.resident()
    }

    /// Present resident memory, in MB.
    pub(super) fn resident(&self) -> Result<f64> {
        self.editor.memory("VmRSS")
    }

    fn peak(&self) -> Result<f64> {
        self.editor.memory("VmHWM")
    }
}

fn table(all: &BTreeMap<usize, Figures>) {
    let counts: Vec<String> = all.keys().map(ToString::to_string).collect();
    println!("\n| components | {} |", counts.join(" | "));
    println!("| --- |{}", " --- |".repeat(counts.len()));
    let names: Vec<_> = all.values().next().into_iter().flatten().map(|(name, _)| *name).collect();
    for (row, name) in names.iter().enumerate() {
        let cells = all.values().map(|sizes| match sizes[row].1 {
            value if name.ends_with("MB") => format!("{value:.0}"),
            value => super::show_time(value),
        });
        println!("| {name} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
}

/// Draws durations and memory over the number of components.
fn draw(all: &BTreeMap<usize, Figures>) -> Result<()> {
    let line = |name: &'static str, label: &'static str| Line {
        name: label,
        points: all
            .iter()
            .filter_map(|(&count, sizes)| {
                Some((count, sizes.iter().find(|size| size.0 == name)?.1))
            })
            .collect(),
    };
    let pictures = root().join("docs/charts");
    std::fs::create_dir_all(&pictures)?;
    let times = Chart {
        title: "Time against the number of components of 1,000 lines",
        across: "components",
        powers: SECONDS,
        ratios: true,
        lines: vec![
            line("check: elapsed", "dotgen check"),
            line("edit of the shared file to all", "idl edit, all files"),
            line("rename of a type that all use", "rename"),
            line("edit of the shared file to the open file", "idl edit, open file"),
        ],
    };
    std::fs::write(pictures.join("size-time.svg"), times.svg())?;
    let memory = Chart {
        title: "Memory against the number of components of 1,000 lines",
        across: "components",
        powers: MEGABYTES,
        ratios: true,
        lines: vec![
            line("check: peak memory, MB", "dotgen check"),
            line("peak memory of the server, MB", "server, peak"),
            line("memory after all that, MB", "server, after all"),
            line("memory with all closed, MB", "server, closed"),
        ],
    };
    std::fs::write(pictures.join("size-memory.svg"), memory.svg())?;
    step("Drew docs/charts/size-time.svg and size-memory.svg");
    Ok(())
}
