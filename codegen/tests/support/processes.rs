//! Starts programs for tests: nothing is confined, and only memory is limited.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use dotgen_codegen::process::{
    Channels, Folder, Gap, Group, Meter, Process, Processes, Program, Resources,
};

pub(crate) struct ShellProcesses;

impl Processes for ShellProcesses {
    fn start(&self, program: &Program) -> io::Result<Process> {
        let mut command = Command::new("/bin/sh");
        let limit = program.resources.memory.map(|memory| format!("ulimit -v {};", memory / 1024));
        let script = format!("{} exec \"$0\" \"$@\"", limit.unwrap_or_default());
        command.args(["-c", &script]).arg(&program.path).args(&program.arguments);
        if !program.directory.as_os_str().is_empty() {
            command.current_dir(&program.directory);
        }
        if program.channels != Channels::Shared {
            command.stdin(Stdio::piped()).stdout(Stdio::piped());
        }
        if program.channels == Channels::Pipes {
            command.stderr(Stdio::piped());
        }
        Ok(Process { child: command.spawn()?, group: Box::new(SingleProcess) })
    }

    fn renderer(&self, _: Resources) -> Option<io::Result<Process>> {
        None
    }

    fn folder(&self, parent: Option<&Path>) -> io::Result<Box<dyn Folder>> {
        let parent = parent.map_or_else(std::env::temp_dir, Path::to_owned);
        let folder = tempfile::tempdir_in(parent.canonicalize()?)?;
        let path = folder.path().to_owned();
        Ok(Box::new(Temporary(Some(folder), path)))
    }

    fn gaps(&self) -> Vec<Gap> {
        Vec::new()
    }

    fn meter(&self, _: Vec<PathBuf>) -> Meter {
        Box::new(|| 0)
    }
}

struct SingleProcess;

impl Group for SingleProcess {
    fn kill(&self, child: &mut Child) {
        let _ = child.kill();
    }
}

#[derive(Debug)]
struct Temporary(Option<tempfile::TempDir>, PathBuf);

impl Folder for Temporary {
    fn path(&self) -> &Path {
        &self.1
    }

    fn keep(&mut self) {
        if let Some(folder) = self.0.take() {
            let _ = folder.keep();
        }
    }
}
