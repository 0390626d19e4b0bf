//! `dotgen monitor SOCKET`: follows a run until it ends.

use std::os::unix::fs::FileTypeExt as _;
use std::sync::mpsc::{RecvTimeoutError, channel};

use camino::Utf8Path;
use dotgen_timing::verify::Interrupt;
use serde_json::json;

use super::checks::LogChecks;
use super::{NewDeviations, POLL_INTERVAL};
use crate::call::RunConnection;
use crate::report::TextOrJson;

pub(super) fn is_socket(path: &Utf8Path) -> bool {
    std::fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_socket())
}

/// Receives executions of codels until the run ends, or Ctrl-C.
pub(super) fn follow(
    path: &Utf8Path,
    monitor: &mut LogChecks<'_>,
    format: TextOrJson,
    interrupt: &Interrupt,
) -> anyhow::Result<()> {
    let mut talk = RunConnection::begin(Some(&path.to_owned()))?;
    talk.say(&json!({"id": 1, "profile": null}))?;
    let (sender, lines) = channel();
    // The thread may outlive its receiver, and ends with the process.
    std::thread::spawn(move || {
        loop {
            let heard = talk.hear();
            let goes_on = matches!(heard, Ok(Some(_)));
            if sender.send(heard).is_err() || !goes_on {
                return;
            }
        }
    });
    let mut told = NewDeviations::default();
    let mut number = 0;
    while !interrupt.is_raised() {
        let heard = match lines.recv_timeout(POLL_INTERVAL) {
            Ok(heard) => heard?,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        let Some(heard) = heard else { break };
        if let Some(line) = heard["line"].as_str() {
            number += 1;
            monitor.line(number, line.as_bytes(), true);
            told.print(monitor, format)?;
        }
    }
    Ok(())
}
