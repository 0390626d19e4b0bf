//! The process of the client, by the `processId` of `initialize`: the server ends when that process has
//! ended. A killed client closes nothing, and its child processes may hold the pipe open.
//!
//! In a container the id may be that of another namespace. A process that does not exist at the start is not
//! watched.

use tokio::sync::oneshot;

/// Resolves when the process has ended. Fails on systems where it cannot be watched.
pub(crate) fn gone(id: i64) -> oneshot::Receiver<()> {
    let (tell, told) = oneshot::channel();
    let watch = move || {
        if wait(id) {
            tracing::warn!("the client, process {id}, is gone");
            // Fails if the server has ended before.
            let _ = tell.send(());
        }
    };
    let thread = std::thread::Builder::new().name("client".to_owned());
    if let Err(error) = thread.spawn(watch) {
        tracing::warn!("the client is not watched: {error}");
    }
    told
}

/// Waits for the end of a process. False if the process cannot be watched, or does not exist at the start.
#[cfg(target_os = "linux")]
fn wait(id: i64) -> bool {
    use rustix::event::{PollFd, PollFlags, poll};
    use rustix::io::Errno;
    use rustix::process::{Pid, PidfdFlags, pidfd_open};

    let Some(pid) = i32::try_from(id).ok().and_then(Pid::from_raw) else {
        return false;
    };
    // The descriptor becomes readable at the end of the process, even before its parent waits for it.
    match pidfd_open(pid, PidfdFlags::empty()) {
        Ok(process) => loop {
            let mut polled = [PollFd::new(&process, PollFlags::IN)];
            match poll(&mut polled, None) {
                Err(Errno::INTR) => {}
                Err(_) => return false,
                Ok(_) => return true,
            }
        },
        Err(Errno::SRCH) => {
            tracing::info!("the client's process {id} is not visible here, so it is not watched");
            false
        }
        Err(_) => poll_exit(pid),
    }
}

#[cfg(all(unix, not(target_os = "linux")))]
fn wait(id: i64) -> bool {
    let pid = i32::try_from(id).ok().and_then(rustix::process::Pid::from_raw);
    pid.is_some_and(poll_exit)
}

/// Polls every few seconds: for systems without descriptors of processes.
#[cfg(unix)]
fn poll_exit(pid: rustix::process::Pid) -> bool {
    use rustix::io::Errno;
    if rustix::process::test_kill_process(pid) == Err(Errno::SRCH) {
        return false;
    }
    while rustix::process::test_kill_process(pid) != Err(Errno::SRCH) {
        std::thread::sleep(std::time::Duration::from_secs(3));
    }
    true
}

#[cfg(not(unix))]
fn wait(_: i64) -> bool {
    false
}
