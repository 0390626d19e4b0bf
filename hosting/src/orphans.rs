//! Processes that codels start and that outlive their host: they end with the run.

use std::time::{Duration, Instant};

use rustix::process::{
    Pid, Signal, WaitId, WaitIdOptions, WaitOptions, getpid, kill_process, waitid, waitpid,
};

/// Maximum time until all orphans have ended.
const LIMIT: Duration = Duration::from_secs(2);

/// A guard: while it exists, orphans among the descendants of this process become its children. Dropping it
/// ends them, and reports those that cannot be ended on standard error. Only on Linux.
#[must_use]
pub struct OrphanReaper {
    /// Helpers of this program, which end by themselves.
    helpers: Vec<Pid>,
}

impl OrphanReaper {
    /// Becomes the parent of orphans. Returns `None` if orphans may belong to others: this process has
    /// children of another program, whose orphans would be adopted too, or it is process 1, the parent of all
    /// orphans.
    pub fn become_subreaper() -> Option<OrphanReaper> {
        let program = |of: &str| std::fs::read_link(format!("/proc/{of}/exe")).ok();
        let own = program("self");
        let helpers = children();
        let mut programs =
            helpers.iter().map(|helper| program(&helper.pid.as_raw_nonzero().to_string()));
        if getpid() == Pid::INIT || programs.any(|program| program != own) {
            return None;
        }
        let helpers = helpers.into_iter().map(|helper| helper.pid).collect();
        #[cfg(target_os = "linux")]
        rustix::process::set_child_subreaper(Some(getpid())).ok()?;
        Some(OrphanReaper { helpers })
    }
}

/// Collects the exit statuses of adopted processes, which would stay as zombies otherwise. The statuses of
/// `hosts` are collected elsewhere.
pub(super) fn reap(hosts: &[Pid]) {
    // Usually there are none, and the list of all processes is not read.
    let any = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    if !matches!(waitid(WaitId::All, any), Ok(Some(_))) {
        return;
    }
    for child in children() {
        if child.state == "Z" && !hosts.contains(&child.pid) {
            let _ = waitpid(Some(child.pid), WaitOptions::NOHANG);
        }
    }
}

impl Drop for OrphanReaper {
    fn drop(&mut self) {
        let until = Instant::now() + LIMIT;
        loop {
            let mut strays = children();
            strays.retain(|stray| !self.helpers.contains(&stray.pid));
            if strays.is_empty() {
                break;
            }
            if Instant::now() > until {
                for Child { pid, name, .. } in strays {
                    let pid = pid.as_raw_nonzero();
                    eprintln!("warning: process {pid} (`{name}`) of a codel cannot be ended");
                }
                break;
            }
            // The children of each orphan become children of this process.
            for child in strays {
                let _ = kill_process(child.pid, Signal::KILL);
                let _ = waitpid(Some(child.pid), WaitOptions::NOHANG);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        #[cfg(target_os = "linux")]
        let _ = rustix::process::set_child_subreaper(None);
    }
}

struct Child {
    pid: Pid,
    /// The name of the program.
    name: String,
    /// The state, as a letter of `/proc`.
    state: String,
}

/// Returns the children of this process.
fn children() -> Vec<Child> {
    let parent = getpid().as_raw_nonzero().to_string();
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let child = |entry: std::fs::DirEntry| {
        let pid = Pid::from_raw(entry.file_name().to_str()?.parse().ok()?)?;
        let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        // `PID (NAME) STATE PARENT …`. The name may contain any character.
        let (name, rest) = stat.rsplit_once(") ")?;
        let name = name.split_once('(')?.1.to_owned();
        let mut words = rest.split(' ');
        let state = words.next()?.to_owned();
        (words.next()? == parent).then_some(Child { pid, name, state })
    };
    processes.filter_map(child).collect()
}
