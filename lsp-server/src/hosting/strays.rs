//! Processes that codels start and that outlive their host: they end with the run.

use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, WaitOptions, getpid, kill_process, waitpid};

/// Time within which all of them must have ended.
const LIMIT: Duration = Duration::from_secs(2);

/// While this exists, orphans among the descendants of this process become its children. Dropping it ends
/// them, and names on standard error those that cannot be ended. Elsewhere than on Linux it does nothing.
#[must_use]
pub(crate) struct Strays {
    /// Children from before.
    known: Vec<Pid>,
}

impl Strays {
    /// Becomes the parent of orphans.
    pub(crate) fn adopt() -> Strays {
        #[cfg(target_os = "linux")]
        // Without the permission, orphans go to the system, and are not seen.
        let _ = rustix::process::set_child_subreaper(Some(getpid()));
        let known = children().into_iter().map(|child| child.0).collect();
        Strays { known }
    }
}

impl Drop for Strays {
    fn drop(&mut self) {
        let until = Instant::now() + LIMIT;
        loop {
            let mut strays = children();
            strays.retain(|stray| !self.known.contains(&stray.0));
            if strays.is_empty() {
                break;
            }
            if Instant::now() > until {
                for (pid, name) in strays {
                    let pid = pid.as_raw_nonzero();
                    eprintln!("warning: process {pid} (`{name}`) of a codel cannot be ended");
                }
                break;
            }
            // The children of each become ours in turn.
            for (pid, _) in strays {
                let _ = kill_process(pid, Signal::KILL);
                let _ = waitpid(Some(pid), WaitOptions::NOHANG);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        #[cfg(target_os = "linux")]
        let _ = rustix::process::set_child_subreaper(None);
    }
}

/// The children of this process, with the names of their programs.
fn children() -> Vec<(Pid, String)> {
    let parent = getpid().as_raw_nonzero().to_string();
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let child = |entry: std::fs::DirEntry| {
        let pid = Pid::from_raw(entry.file_name().to_str()?.parse().ok()?)?;
        let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        // `PID (NAME) STATE PARENT …`, where the name may have any character.
        let (name, rest) = stat.rsplit_once(") ")?;
        let name = name.split_once('(')?.1.to_owned();
        (rest.split(' ').nth(1)? == parent).then_some((pid, name))
    };
    processes.filter_map(child).collect()
}
