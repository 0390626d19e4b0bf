//! Files that templates write: modes, merging, permissions, and destinations.

mod concern;
mod permissions;
mod sink;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use dotgen_syntax::encoding;

use super::console::Console;
use super::merge::{self, Choice, Conflict};
use super::{Confinement, Confirmation, Failure, readable_files};
use crate::disk::{Disk, WriteError};
use crate::process::{Channels, Processes, Program, Resources};
pub use concern::Concern;
use concern::{concern, is_new_executable};
pub(crate) use permissions::Rights;
pub use sink::OutputSink;

/// A file written by a template in a run that writes nothing to disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PreviewFile {
    /// The current bytes; `None` if the file does not exist.
    pub before: Option<Vec<u8>>,
    /// The new bytes.
    pub after: Vec<u8>,
    /// Unix permissions, if the template sets any.
    pub mode: Option<u32>,
    /// The reason why the user must review the file: see [`Confirmation::Shown`].
    pub concern: Option<Concern>,
}

/// Switches of the engine for existing files.
#[derive(Debug, Clone)]
pub struct Modes {
    /// The modes, in the order in which templates see them.
    values: [(&'static str, bool); 5],
}

impl Modes {
    /// The modes at the start of a run.
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

    /// Returns true if a mode is on.
    pub(crate) fn is_on(&self, name: &str) -> bool {
        self.values.iter().any(|(text, on)| *text == name && *on)
    }

    /// The settings, each as `MODE` or `-MODE`.
    pub fn show(&self) -> Vec<String> {
        let shown = |(name, on): &(&str, bool)| format!("{}{name}", if *on { "" } else { "-" });
        self.values.iter().map(shown).collect()
    }

    /// Sets one mode given as `MODE`, `+MODE` or `-MODE`; returns its name and value if it changed.
    ///
    /// # Errors
    /// Fails for an unknown mode.
    pub(crate) fn set(&mut self, word: &str) -> Result<Option<(&'static str, bool)>, Failure> {
        let (name, value) = match word.split_at_checked(1) {
            Some(("+", name)) => (name, true),
            Some(("-", name)) => (name, false),
            _ => (word, true),
        };
        let Some((known, on)) = self.values.iter_mut().find(|(text, _)| *text == name) else {
            let names: Vec<&str> = self.values.iter().map(|(name, _)| *name).collect();
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

/// The part of the running session that committing a file needs.
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

/// The state of the engine for files.
#[derive(Debug)]
pub(crate) struct Output {
    /// See [`Modes`].
    pub(crate) modes: Modes,
    /// `interactive`, `auto`, or a program.
    pub(crate) merge_tool: String,
    /// Output directory; empty if never set.
    pub(crate) dir: String,
    /// Base directory of relative paths; empty for the current one.
    pub(crate) base: PathBuf,
    /// The files written so far.
    pub(crate) files: OutputSink,
    /// The disk before the run.
    pub(crate) disk: Arc<dyn Disk>,
    /// Name of the template, for messages.
    pub(crate) template: String,
    /// The folders for results, if the run is confined; a confined run starts no program.
    pub(crate) confined: Option<Confinement>,
    /// The rights of a template that is not confined.
    pub(crate) rights: Rights,
}

impl Output {
    /// The state at the start of a run of the template of that name.
    pub(crate) fn new(
        template: String,
        base: PathBuf,
        debug: bool,
        disk: Arc<dyn Disk>,
        sink: OutputSink,
    ) -> Output {
        Output {
            modes: Modes::new(debug),
            merge_tool: "interactive".into(),
            dir: String::new(),
            base,
            files: sink,
            disk,
            template,
            confined: None,
            rights: Rights::All,
        }
    }

    /// Ends the run. A failed run writes nothing.
    pub(crate) fn finish(self, failed: bool) -> (OutputSink, Result<(), WriteError>) {
        self.files.finish(&*self.disk, failed)
    }

    /// The path of a file that a template names: below the output directory.
    pub(crate) fn path(&self, name: &str) -> String {
        join(&self.dir, name)
    }

    /// Sets how files are merged: `interactive`, `auto`, or by a program.
    ///
    /// # Errors
    /// Fails for a program if the template is confined.
    pub(crate) fn set_merge_tool(&mut self, tool: &str) -> Result<(), Failure> {
        if self.confined.is_some() && !matches!(tool, "interactive" | "auto") {
            return Err(Failure::Error(format!(
                "the merge tool `{tool}` is a program, and a preview or a confined template starts none: \
                 choose `auto`, which leaves conflict markers, or run the template from the command line"
            )));
        }
        tool.clone_into(&mut self.merge_tool);
        Ok(())
    }

    /// Refuses a result outside the folders of a confined template, and a hidden or executable one that is
    /// not confirmed.
    fn check(&self, shown: &str, path: &Path, permissions: &str) -> Result<(), Failure> {
        let Some(confined) = &self.confined else {
            return self.check_free(shown, path, permissions);
        };
        if readable_files::is_below(&*self.disk, path, &confined.results) {
            let Confirmation::Only(confirmed) = &confined.confirmed else {
                return Ok(());
            };
            let mode = if permissions.is_empty() {
                None
            } else {
                Some(self.files.mode(&*self.disk, path, permissions)?)
            };
            let concern = concern(&*self.disk, path, mode, &confined.results);
            return match concern {
                Some(what) if !confirmed.contains(&readable_files::plain(&*self.disk, path)) => {
                    Err(Failure::Error(format!(
                        "{shown} is {what}, and a confined template writes such a file only if you name \
                         the file: --allow {shown}"
                    )))
                }
                _ => Ok(()),
            };
        }
        let folders: Vec<String> =
            confined.results.iter().map(|path| path.display().to_string()).collect();
        Err(Failure::Error(format!(
            "{shown} is outside of {}: a preview or a confined template writes nothing there",
            folders.join(" and ")
        )))
    }

    /// Refuses a result of a template that is not confined: one that a link leads out of the current
    /// directory or out of the output directory, one in a control folder, and an executable of a MiniJinja
    /// template.
    fn check_free(&self, shown: &str, path: &Path, permissions: &str) -> Result<(), Failure> {
        let disk = &*self.disk;
        let named = readable_files::plain(disk, path);
        let base =
            if self.base.as_os_str().is_empty() { PathBuf::from(".") } else { self.base.clone() };
        let around: Vec<PathBuf> = [base.join(&self.dir), base]
            .into_iter()
            .filter(|folder| named.starts_with(readable_files::plain(disk, folder)))
            .collect();
        for folder in &around {
            let folder = std::slice::from_ref(folder);
            if let Some(link) = readable_files::link_out(disk, path, folder) {
                return Err(Failure::Error(format!(
                    "{shown} is not written: the link {} leads out of {}; name the folder that the link \
                     leads to",
                    link.display(),
                    readable_files::plain(disk, &folder[0]).display()
                )));
            }
        }
        let (allowed, may_execute) = match &self.rights {
            Rights::All => return Ok(()),
            Rights::Tcl(allowed) => (allowed, true),
            Rights::MiniJinja(allowed) => (allowed, false),
        };
        if allowed.contains(&named) {
            return Ok(());
        }
        let root = [PathBuf::from("/")];
        let folders = if around.is_empty() { &root[..] } else { &around[..] };
        let mode = if permissions.is_empty() {
            None
        } else {
            Some(self.files.mode(disk, path, permissions)?)
        };
        let what = match () {
            () if readable_files::is_control(disk, path, folders) => {
                "in a folder that controls tools"
            }
            () if !may_execute && is_new_executable(disk, path, mode) => "executable",
            () => return Ok(()),
        };
        Err(Failure::Error(format!(
            "{shown} is {what}, and a template writes such a file only if you name the file: --allow {shown}"
        )))
    }

    /// Puts a text at the path given by a template, according to the current modes.
    ///
    /// # Errors
    /// Fails if the modes do not allow to change an existing file, if a merge fails, for unknown permissions,
    /// and for a path outside the folders of a confined template.
    pub(crate) fn commit(
        &mut self,
        name: &str,
        permissions: &str,
        text: &str,
        env: &mut dyn Environment,
    ) -> Result<(), Failure> {
        let shown = self.path(name);
        let path = self.base.join(&shown);
        self.check(&shown, &path, permissions)?;
        self.put(&shown, &path, permissions, text, env)?;
        if let Some(confined) = &self.confined
            && confined.confirmed == Confirmation::Shown
        {
            self.files.mark(&*self.disk, &path, &confined.results);
        }
        Ok(())
    }

    fn put(
        &mut self,
        shown: &str,
        path: &Path,
        permissions: &str,
        text: &str,
        env: &mut dyn Environment,
    ) -> Result<(), Failure> {
        let silent = self.modes.is_on("silent");
        let exists = self.files.exists(&*self.disk, path);
        let say = |env: &mut dyn Environment, line: String| {
            if !silent {
                env.print(&line);
            }
        };
        let opening = |error: &io::Error| {
            Failure::Error(format!("couldn't open \"{shown}\": {}", posix(error)))
        };
        if exists && self.modes.is_on("move-if-change") {
            let old = self.files.read(&*self.disk, path).map_err(|error| opening(&error))?;
            if old.as_deref() == Some(text.as_bytes()) {
                if !permissions.is_empty() {
                    self.files.set_permissions(&*self.disk, path, permissions)?;
                }
                say(env, format!("{shown} is up-to-date"));
                return Ok(());
            }
        }
        let reviewed = self.confined.as_ref().is_some_and(|confined| confined.reviewed);
        let merges = self.modes.is_on("merge-if-change");
        if exists && (merges || (reviewed && !self.modes.is_on("overwrite"))) {
            say(env, format!("merging {shown}"));
            if !self.merge(shown, path, text, env)? {
                return Err(Failure::Error(format!("stop: could not merge changes in {shown}")));
            }
            if !permissions.is_empty() {
                self.files.set_permissions(&*self.disk, path, permissions)?;
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
        self.write(shown, path, text.as_bytes())?;
        if !permissions.is_empty() {
            self.files.set_permissions(&*self.disk, path, permissions)?;
        }
        Ok(())
    }

    fn write(&mut self, shown: &str, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        self.files.write(&*self.disk, path, bytes).map_err(|error| {
            Failure::Error(format!("error copying to \"{shown}\": {}", posix(&error)))
        })
    }

    /// Merges with the current tool; `false` if the tool fails.
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
        let old = self.files.read(&*self.disk, path).ok().flatten().unwrap_or_default();
        // Text that only the file has is passed through unchanged, for any encoding.
        let old_text = encoding::decode(old.clone());
        let new_text = encoding::escape(text);
        let header = if interactive {
            let time = self.disk.status(path).and_then(|status| status.modified);
            let before = env.format_time(time.unwrap_or_else(SystemTime::now));
            let now = env.format_time(SystemTime::now());
            format!("--- {shown}\t{before}\n+++ {shown}\t{now}\n")
        } else {
            String::new()
        };
        let mut action = String::new();
        let merged = merge::merge(&new_text, &old_text, &mut |conflict| {
            if interactive { ask(&header, conflict, &mut action, env) } else { Choice::Markers }
        });
        if merged.conflicts > 0 && merged.text.is_some() {
            env.message(&format!("CONFLICTS during merge of {shown}"));
        }
        let Some(text) = merged.text else {
            return Ok(true);
        };
        let bytes = encoding::encode(&text);
        if self.modes.is_on("move-if-change") && *bytes == *old {
            if !self.modes.is_on("silent") {
                env.print(&format!("{shown} was not modified"));
            }
            return Ok(true);
        }
        self.write(shown, path, &bytes)?;
        Ok(true)
    }

    /// Runs `TOOL NEW OLD`; the tool updates OLD, which is a copy of the file.
    fn merge_with(
        &mut self,
        tool: &str,
        shown: &str,
        path: &Path,
        text: &str,
        env: &mut dyn Environment,
    ) -> Result<bool, Failure> {
        let failed = |error: io::Error| Failure::Error(format!("{shown}: {}", posix(&error)));
        let before = self.files.read(&*self.disk, path).map_err(failed)?.unwrap_or_default();
        let (new, old) = (env.temporary(), env.temporary());
        self.disk.put(&new, text.as_bytes()).map_err(failed)?;
        self.disk.put(&old, &before).map_err(failed)?;
        let channels = if env.console().is_terminal() { Channels::Shared } else { Channels::Pipes };
        let process = env.processes().start(&Program {
            path: tool.into(),
            arguments: vec![new.clone().into(), old.clone().into()],
            directory: self.base.clone(),
            channels,
            resources: Resources::default(),
            access: None,
            outlives: std::time::Duration::ZERO,
        });
        let status = process.and_then(|mut process| process.wait_with_output());
        let merged = self.disk.read(&old).map_err(failed);
        self.disk.remove(&new);
        self.disk.remove(&old);
        let problem = match status {
            Ok((status, _)) if status.success() => None,
            Ok(_) => Some("child process exited abnormally".to_owned()),
            Err(error) => Some(format!("couldn't execute \"{tool}\": {}", posix(&error))),
        };
        if let Some(problem) = problem {
            env.message(&format!("{tool}: {problem}"));
            return Ok(false);
        }
        let merged = merged?;
        if merged != before {
            self.write(shown, path, &merged)?;
        }
        Ok(true)
    }
}

/// Shows a conflict and asks for its resolution.
fn ask(
    header: &str,
    conflict: &Conflict<'_>,
    action: &mut String,
    env: &mut dyn Environment,
) -> Choice {
    let patch = format!("{header}{}", encoding::shown(&conflict.hunk()));
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
    fn modes() {
        let mut modes = Modes::new(false);
        assert_eq!(
            modes.show().join(" "),
            "-overwrite move-if-change -merge-if-change -silent -debug"
        );
        assert_eq!(modes.set("+overwrite"), Ok(Some(("overwrite", true))));
        assert_eq!(modes.set("overwrite"), Ok(None));
        assert_eq!(modes.set("-move-if-change"), Ok(Some(("move-if-change", false))));
        assert!(matches!(modes.set("verbose"), Err(Failure::Fatal(_))));
    }
}
