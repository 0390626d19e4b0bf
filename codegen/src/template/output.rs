//! Files that templates write: modes, merging, permissions, and where the bytes go.

use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;

use super::console::Console;
use super::merge::{self, Choice, Conflict};
use super::tcl;
use super::{Confined, Failure, reach};
use crate::process::{Channels, Processes, Program, Resources};

/// A file as a template wants it, in a run that writes nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PreviewFile {
    /// The bytes there now; `None` when there is no such file.
    pub before: Option<Vec<u8>>,
    /// The bytes there would be.
    pub after: Vec<u8>,
    /// Unix permissions, when the template gives any.
    pub mode: Option<u32>,
}

/// Where the files of a template go.
#[derive(Debug)]
pub enum OutputSink {
    /// To their places.
    Direct,
    /// Into memory, by absolute path; later reads see them.
    Preview(BTreeMap<PathBuf, PreviewFile>),
}

impl OutputSink {
    /// A sink that writes nothing.
    pub fn preview() -> OutputSink {
        OutputSink::Preview(BTreeMap::new())
    }

    /// Bytes of a file, `None` when it does not exist.
    fn read(&self, path: &Path) -> io::Result<Option<Vec<u8>>> {
        if let OutputSink::Preview(files) = self
            && let Some(file) = files.get(&plain(path))
        {
            return Ok(Some(file.after.clone()));
        }
        match std::fs::read(path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn exists(&self, path: &Path) -> bool {
        match self {
            OutputSink::Preview(files) if files.contains_key(&plain(path)) => true,
            _ => path.exists(),
        }
    }

    fn write(&mut self, path: &Path, bytes: &[u8], temporary: &Path) -> io::Result<()> {
        match self {
            OutputSink::Direct => {
                if let Some(dir) = path.parent() {
                    std::fs::create_dir_all(dir)?;
                }
                // Copied from a fresh file: the result has its permissions, whatever was there.
                std::fs::write(temporary, bytes)?;
                let copied = std::fs::copy(temporary, path).map(|_| ());
                let _ = std::fs::remove_file(temporary);
                copied
            }
            OutputSink::Preview(files) => {
                let path = plain(path);
                let before = match files.get(&path) {
                    Some(file) => file.before.clone(),
                    None => std::fs::read(&path).ok(),
                };
                files.insert(
                    path,
                    PreviewFile {
                        before,
                        after: bytes.to_vec(),
                        mode: None,
                    },
                );
                Ok(())
            }
        }
    }

    /// Writes the files that were kept.
    ///
    /// # Errors
    /// The first that cannot be written, and why.
    pub(crate) fn write_out(self) -> Result<(), (PathBuf, io::Error)> {
        let OutputSink::Preview(files) = self else {
            return Ok(());
        };
        for (path, file) in files {
            let write = || {
                if let Some(dir) = path.parent() {
                    std::fs::create_dir_all(dir)?;
                }
                if file.before.as_ref() != Some(&file.after) {
                    OutputSink::Direct.put(&path, &file.after)?;
                }
                file.mode.map_or(Ok(()), |mode| set_unix_mode(&path, mode))
            };
            write().map_err(|error| (path.clone(), error))?;
        }
        Ok(())
    }

    /// Puts bytes where they belong, whatever is there.
    pub(crate) fn put(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        match self {
            OutputSink::Direct => std::fs::write(path, bytes),
            OutputSink::Preview(_) => self.write(path, bytes, Path::new("")),
        }
    }

    fn set_permissions(&mut self, path: &Path, permissions: &str) -> Result<(), Failure> {
        let invalid = || {
            Failure::Error(format!(
                "unknown permission string format \"{permissions}\""
            ))
        };
        match self {
            OutputSink::Direct => {
                let current = unix_mode(path);
                let mode = parse_permissions(permissions, current).ok_or_else(invalid)?;
                set_unix_mode(path, mode).map_err(|error| {
                    Failure::Error(format!(
                        "could not set permissions for file \"{}\": {}",
                        path.display(),
                        posix(&error)
                    ))
                })
            }
            OutputSink::Preview(files) => {
                let file = files.get_mut(&plain(path));
                let current = file.as_ref().and_then(|it| it.mode);
                let current = current.unwrap_or_else(|| match unix_mode(path) {
                    0 => 0o644,
                    mode => mode,
                });
                let mode = parse_permissions(permissions, current).ok_or_else(invalid)?;
                if let Some(file) = file {
                    file.mode = Some(mode);
                }
                Ok(())
            }
        }
    }
}

/// The path without `.` and `..`, absolute.
pub(crate) fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in super::discover::absolute(path).components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

/// Switches of the engine that say what happens to files that exist.
#[derive(Debug, Clone)]
pub struct Modes {
    /// In the order in which templates see them.
    values: [(&'static str, bool); 5],
}

impl Modes {
    /// As at the start of a run.
    pub fn new(debug: bool) -> Modes {
        Modes {
            values: [
                ("overwrite", false),
                ("move-if-change", true),
                ("merge-if-change", false),
                ("silent", false),
                ("debug", debug),
            ],
        }
    }

    /// Whether a mode is on.
    pub fn is_on(&self, name: &str) -> bool {
        self.values.iter().any(|(it, on)| *it == name && *on)
    }

    /// The settings, each as `MODE` or `-MODE`.
    pub fn show(&self) -> Vec<String> {
        let shown = |(name, on): &(&str, bool)| format!("{}{name}", if *on { "" } else { "-" });
        self.values.iter().map(shown).collect()
    }

    /// Sets one mode given as `MODE`, `+MODE` or `-MODE`; returns its name and value when that
    /// changed anything.
    pub(crate) fn set(&mut self, word: &str) -> Result<Option<(&'static str, bool)>, Failure> {
        let (name, value) = match word.split_at_checked(1) {
            Some(("+", name)) => (name, true),
            Some(("-", name)) => (name, false),
            _ => (word, true),
        };
        let Some((known, on)) = self.values.iter_mut().find(|(it, _)| *it == name) else {
            let names: Vec<&str> = self.values.iter().map(|(it, _)| *it).collect();
            return Err(Failure::Fatal(format!(
                "unknown mode {name}: should be {}",
                names.join(", ")
            )));
        };
        let changed = *on != value;
        *on = value;
        Ok(changed.then_some((known, value)))
    }
}

/// What committing a file needs from the running session.
pub(crate) trait Environment {
    /// The standard channels.
    fn console(&mut self) -> &mut dyn Console;
    /// Prints a line on standard output.
    fn print(&mut self, line: &str) {
        self.console().out(format!("{line}\n").as_bytes());
    }
    /// Prints without a newline.
    fn prompt(&mut self, text: &str) {
        self.console().out(text.as_bytes());
    }
    /// A line of standard input.
    fn read_line(&mut self) -> Option<String> {
        self.console().read_line()
    }
    /// A name for a temporary file.
    fn temporary(&mut self) -> PathBuf;
    /// A time as Tcl's `clock format` shows it.
    fn format_time(&mut self, time: SystemTime) -> String;
    /// A message of verbose mode.
    fn message(&mut self, text: &str);
    /// Starts programs.
    fn processes(&self) -> &dyn Processes;
}

/// The state of the engine that concerns files.
#[derive(Debug)]
pub struct Output {
    /// See [`Modes`].
    pub modes: Modes,
    /// `interactive`, `auto`, or a program.
    pub merge_tool: String,
    /// Output directory; empty when never set.
    pub dir: String,
    /// Directory where relative paths start; empty for the current one.
    pub base: PathBuf,
    /// Where bytes go.
    pub sink: OutputSink,
    /// Name of the template, for messages.
    pub template: String,
    /// Where results may be, and that no program may be started, if it is so.
    pub confined: Option<Confined>,
}

impl Output {
    /// The path of a file that a template names: below the output directory.
    pub fn path(&self, name: &str) -> String {
        join(&self.dir, name)
    }

    /// Chooses how files are merged: `interactive`, `auto`, or by a program.
    ///
    /// # Errors
    /// A confined template starts no program.
    pub(crate) fn set_merge_tool(&mut self, tool: &str) -> Result<(), Failure> {
        if self.confined.is_some() && !matches!(tool, "interactive" | "auto") {
            return Err(Failure::Error(format!(
                "the merge tool `{tool}` is a program, and a preview or a confined template starts none: choose \
                 `auto`, which leaves conflict markers, or run the template from the command line"
            )));
        }
        tool.clone_into(&mut self.merge_tool);
        Ok(())
    }

    /// Refuses a result that is not where the results of a confined template may be.
    fn check(&self, shown: &str, path: &Path) -> Result<(), Failure> {
        let Some(confined) = &self.confined else {
            return Ok(());
        };
        if reach::is_below(path, &confined.results) {
            return Ok(());
        }
        let folders: Vec<String> = confined
            .results
            .iter()
            .map(|it| it.display().to_string())
            .collect();
        Err(Failure::Error(format!(
            "{shown} is outside of {}: a preview or a confined template writes nothing there",
            folders.join(" and ")
        )))
    }

    /// Puts a text where a template wants it, by the modes in force.
    pub(crate) fn commit(
        &mut self,
        name: &str,
        permissions: &str,
        text: &str,
        env: &mut dyn Environment,
    ) -> Result<(), Failure> {
        let shown = self.path(name);
        let path = self.base.join(&shown);
        self.check(&shown, &path)?;
        let silent = self.modes.is_on("silent");
        let exists = self.sink.exists(&path);
        let say = |env: &mut dyn Environment, line: String| {
            if !silent {
                env.print(&line);
            }
        };
        let opening = |error: &io::Error| {
            Failure::Error(format!("couldn't open \"{shown}\": {}", posix(error)))
        };
        if exists && self.modes.is_on("move-if-change") {
            let old = self.sink.read(&path).map_err(|it| opening(&it))?;
            if old.as_deref() == Some(text.as_bytes()) {
                if !permissions.is_empty() {
                    self.sink.set_permissions(&path, permissions)?;
                }
                say(env, format!("{shown} is up-to-date"));
                return Ok(());
            }
        }
        if exists && self.modes.is_on("merge-if-change") {
            say(env, format!("merging {shown}"));
            if !self.merge(&shown, &path, text, env)? {
                return Err(Failure::Error(format!(
                    "stop: could not merge changes in {shown}"
                )));
            }
            if !permissions.is_empty() {
                self.sink.set_permissions(&path, permissions)?;
            }
            return Ok(());
        }
        if exists && !self.modes.is_on("overwrite") {
            return Err(Failure::Error(format!(
                "stop: file {shown} exists and would be overwritten.\nSee {} -h for available \
                 merge or overwrite modes.",
                self.template
            )));
        }
        let verb = if exists { "overwriting" } else { "creating" };
        say(env, format!("{verb} {shown}"));
        self.write(&shown, &path, text.as_bytes(), env)?;
        if !permissions.is_empty() {
            self.sink.set_permissions(&path, permissions)?;
        }
        Ok(())
    }

    fn write(
        &mut self,
        shown: &str,
        path: &Path,
        bytes: &[u8],
        env: &mut dyn Environment,
    ) -> Result<(), Failure> {
        let temporary = env.temporary();
        self.sink.write(path, bytes, &temporary).map_err(|error| {
            Failure::Error(format!("error copying to \"{shown}\": {}", posix(&error)))
        })
    }

    /// Merges by the tool in force; `false` when the tool fails.
    fn merge(
        &mut self,
        shown: &str,
        path: &Path,
        text: &str,
        env: &mut dyn Environment,
    ) -> Result<bool, Failure> {
        let tool = self.merge_tool.clone();
        let interactive = tool == "interactive";
        if !interactive && tool != "auto" {
            return self.merge_with(&tool, shown, path, text, env);
        }
        let old = self.sink.read(path).ok().flatten().unwrap_or_default();
        let old_text = tcl::decode(&old);
        let header = if interactive {
            let time = std::fs::metadata(path).and_then(|it| it.modified());
            let before = env.format_time(time.unwrap_or_else(|_| SystemTime::now()));
            let now = env.format_time(SystemTime::now());
            format!("--- {shown}\t{before}\n+++ {shown}\t{now}\n")
        } else {
            String::new()
        };
        let mut action = String::new();
        let merged = merge::merge(text, &old_text, &mut |conflict| {
            if interactive {
                ask(&header, conflict, &mut action, env)
            } else {
                Choice::Markers
            }
        });
        if merged.conflicts > 0 && merged.text.is_some() {
            env.message(&format!("CONFLICTS during merge of {shown}"));
        }
        let Some(text) = merged.text else {
            return Ok(true);
        };
        if self.modes.is_on("move-if-change") && text.as_bytes() == old {
            if !self.modes.is_on("silent") {
                env.print(&format!("{shown} was not modified"));
            }
            return Ok(true);
        }
        self.write(shown, path, text.as_bytes(), env)?;
        Ok(true)
    }

    /// Runs `TOOL NEW OLD`; the tool updates OLD itself.
    fn merge_with(
        &mut self,
        tool: &str,
        shown: &str,
        path: &Path,
        text: &str,
        env: &mut dyn Environment,
    ) -> Result<bool, Failure> {
        let new = env.temporary();
        let failed = |error: io::Error| Failure::Error(format!("{shown}: {}", posix(&error)));
        std::fs::write(&new, text).map_err(failed)?;
        // A preview gives the tool a copy to work on.
        let old = match &self.sink {
            OutputSink::Direct => path.to_owned(),
            OutputSink::Preview(_) => {
                let copy = env.temporary();
                let bytes = self.sink.read(path).map_err(failed)?.unwrap_or_default();
                std::fs::write(&copy, bytes).map_err(failed)?;
                copy
            }
        };
        let channels = match env.console().is_terminal() {
            true => Channels::Shared,
            // Who asks over pipes keeps them for himself: a tool that reads or writes there would break in on it.
            false => Channels::Pipes,
        };
        let process = env.processes().start(&Program {
            path: tool.into(),
            arguments: vec![new.clone().into(), old.clone().into()],
            directory: self.base.clone(),
            channels,
            resources: Resources::default(),
            access: None,
        });
        let status = process.and_then(|mut it| it.wait_with_output());
        let _ = std::fs::remove_file(&new);
        let problem = match status {
            Ok((status, _)) if status.success() => None,
            Ok(_) => Some("child process exited abnormally".to_owned()),
            Err(error) => Some(format!("couldn't execute \"{tool}\": {}", posix(&error))),
        };
        if let Some(problem) = problem {
            env.message(&format!("{tool}: {problem}"));
            return Ok(false);
        }
        if let OutputSink::Preview(_) = self.sink {
            let bytes = std::fs::read(&old).map_err(failed)?;
            let _ = std::fs::remove_file(&old);
            self.write(shown, path, &bytes, env)?;
        }
        Ok(true)
    }
}

/// Shows a conflict and asks what to do.
fn ask(
    header: &str,
    conflict: &Conflict<'_>,
    action: &mut String,
    env: &mut dyn Environment,
) -> Choice {
    let patch = format!("{header}{}", conflict.hunk());
    env.print(&patch);
    loop {
        env.prompt("Apply this patch [y,n,c,a,q,?]? ");
        if action == "a" {
            env.print("y");
        } else {
            *action = env.read_line().unwrap_or_else(|| "q".into());
        }
        match action.as_str() {
            "a" | "y" => return Choice::New,
            "n" => return Choice::Old,
            "c" => return Choice::Markers,
            "q" => return Choice::Leave,
            _ => {
                env.print(&patch);
                for line in [
                    "y - apply this patch",
                    "n - skip this patch",
                    "c - generate a conflict marker",
                    "a - answer y to all",
                    "q - leave this file unchanged",
                    "? - print help",
                ] {
                    env.print(line);
                }
            }
        }
    }
}

/// `file join`: an absolute name replaces the directory; repeated slashes are one.
pub(crate) fn join(dir: &str, name: &str) -> String {
    let joined = if dir.is_empty() || name.starts_with('/') {
        name.to_owned()
    } else {
        format!("{dir}/{name}")
    };
    let mut out = String::with_capacity(joined.len());
    for c in joined.chars() {
        if c != '/' || !out.ends_with('/') {
            out.push(c);
        }
    }
    if out.len() > 1 && out.ends_with('/') {
        out.pop();
    }
    out
}

/// The words of the system for an error, as Tcl gives them.
pub(crate) fn posix(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "no such file or directory".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "illegal operation on a directory".into(),
        io::ErrorKind::NotADirectory => "not a directory".into(),
        _ => error.to_string(),
    }
}

#[cfg(unix)]
fn unix_mode(path: &Path) -> u32 {
    use std::os::unix::fs::PermissionsExt;
    std::fs::metadata(path).map_or(0, |it| it.permissions().mode() & 0o7777)
}

#[cfg(not(unix))]
fn unix_mode(_: &Path) -> u32 {
    0
}

#[cfg(unix)]
fn set_unix_mode(path: &Path, mode: u32) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode))
}

#[cfg(not(unix))]
fn set_unix_mode(_: &Path, _: u32) -> io::Result<()> {
    Ok(())
}

/// Reads permissions in the forms of Tcl's `file attributes -permissions`: octal, `rwxr-xr-x`,
/// or `chmod` words.
fn parse_permissions(text: &str, current: u32) -> Option<u32> {
    let text = text.trim();
    let digits = text.strip_prefix("0o").unwrap_or(text);
    if !digits.is_empty() && digits.chars().all(|c| c.is_digit(8)) {
        return u32::from_str_radix(digits, 8).ok().map(|it| it & 0o7777);
    }
    if text.len() == 9 && text.chars().all(|c| "rwxstST-".contains(c)) {
        return parse_listing(text);
    }
    let mut mode = current;
    for clause in text.split(',') {
        mode = parse_clause(clause, mode)?;
    }
    Some(mode)
}

/// `rwxr-xr-x`.
fn parse_listing(text: &str) -> Option<u32> {
    let mut mode = 0;
    for (index, c) in text.chars().enumerate() {
        let bit = 0o400 >> index;
        let (expected, special) = match index {
            2 => ('x', 0o4000),
            5 => ('x', 0o2000),
            8 => ('x', 0o1000),
            _ if index % 3 == 0 => ('r', 0),
            _ => ('w', 0),
        };
        match c {
            '-' => {}
            c if c == expected => mode |= bit,
            's' | 't' if special != 0 => mode |= bit | special,
            'S' | 'T' if special != 0 => mode |= special,
            _ => return None,
        }
    }
    Some(mode)
}

/// `u+x`, `go-w`, `a=r`.
fn parse_clause(clause: &str, mode: u32) -> Option<u32> {
    let at = clause.find(['+', '-', '='])?;
    let (who, rest) = clause.split_at(at);
    let mut classes = 0;
    for c in who.chars() {
        classes |= match c {
            'u' => 0o4700,
            'g' => 0o2070,
            'o' => 0o1007,
            'a' => 0o7777,
            _ => return None,
        };
    }
    if who.is_empty() {
        classes = 0o7777;
    }
    let mut characters = rest.chars();
    let operator = characters.next()?;
    let mut bits = 0;
    for c in characters {
        bits |= match c {
            'r' => 0o444,
            'w' => 0o222,
            'x' => 0o111,
            's' => 0o6000,
            't' => 0o1000,
            _ => return None,
        };
    }
    let bits = bits & classes;
    Some(match operator {
        '+' => mode | bits,
        '-' => mode & !bits,
        _ => (mode & !classes) | bits,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_joined_as_tcl_does() {
        assert_eq!(join("", "a.txt"), "a.txt");
        assert_eq!(join(".", "a.txt"), "./a.txt");
        assert_eq!(join("out/", "sub//a.txt"), "out/sub/a.txt");
        assert_eq!(join("out", "/abs"), "/abs");
    }

    #[test]
    fn permissions_in_every_form() {
        for (text, mode) in [
            ("0755", 0o755),
            ("755", 0o755),
            ("a+x", 0o755),
            ("a+x,go-w", 0o755),
            ("u=rwx,g=rx,o=", 0o750),
            ("rwxr-x---", 0o750),
            ("+x", 0o755),
        ] {
            assert_eq!(parse_permissions(text, 0o644), Some(mode), "{text}");
        }
        assert_eq!(parse_permissions("q+x", 0o644), None);
        assert_eq!(parse_permissions("", 0o644), None);
    }

    #[test]
    fn modes() {
        let mut modes = Modes::new(false);
        assert_eq!(
            modes.show().join(" "),
            "-overwrite move-if-change -merge-if-change -silent -debug"
        );
        assert_eq!(modes.set("+overwrite"), Ok(Some(("overwrite", true))));
        assert_eq!(modes.set("overwrite"), Ok(None));
        assert_eq!(
            modes.set("-move-if-change"),
            Ok(Some(("move-if-change", false)))
        );
        assert!(matches!(modes.set("verbose"), Err(Failure::Fatal(_))));
    }
}
