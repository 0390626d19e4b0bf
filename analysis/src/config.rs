//! The settings that analysis knows.

use camino::Utf8PathBuf;
use num_rational::Ratio;
use smol_str::SmolStr;

use crate::{diagnostic::Severity, model::Seconds, release::ReleaseChoice};

/// Settings that change what a specification means or how it is reported.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Config {
    /// `-I`, in order.
    pub include_dirs: Vec<Utf8PathBuf>,
    /// `-D`, in order: name and value (`1` when none was given).
    pub defines: Vec<(SmolStr, SmolStr)>,
    /// The release of GenoM3 that specifications are read as; `None` if the user says nothing of it.
    pub release: Option<ReleaseChoice>,
    /// Directories whose specifications are read in another way.
    pub projects: Vec<Project>,
    /// Severity per code; `None` switches a code off. Errors stay errors: the configuration changes
    /// warnings, information and hints only.
    pub severities: Vec<(String, Option<Severity>)>,
    /// What the lints need to know.
    pub lints: LintConfig,
    /// Larger files are not read, and a diagnostic says so; [`MAX_FILE_BYTES`] unless given.
    pub max_file_bytes: Option<u64>,
}

/// Files of more bytes are no specifications that somebody wrote.
pub const MAX_FILE_BYTES: u64 = 4 << 20;

/// How the specifications below a directory are read, instead of what [`Config`] says for all. The innermost
/// counts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Project {
    /// Absolute.
    pub directory: Utf8PathBuf,
    /// `-I`, in order.
    pub include_dirs: Vec<Utf8PathBuf>,
    /// `-D`, in order.
    pub defines: Vec<(SmolStr, SmolStr)>,
    /// The release of GenoM3.
    pub release: Option<ReleaseChoice>,
}

/// What the rules need to know besides the model.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LintConfig {
    /// Cores of the platform, when known.
    pub cores: Option<u32>,
    /// Report codels without execution time even in components without any.
    pub always_missing_wcet: bool,
    /// Longest time the control task may be kept from other requests by one function, in seconds.
    pub control_task_budget: Seconds,
}

impl LintConfig {
    /// An exact time from a number of milliseconds in a configuration; `None` when it is not a time.
    pub fn milliseconds(value: f64) -> Option<Seconds> {
        let micros = (value * 1000.0).round();
        (micros.is_finite() && (0.0..1e15).contains(&micros))
            .then(|| Ratio::new(micros as i128, 1_000_000))
    }
}

impl Default for LintConfig {
    fn default() -> LintConfig {
        LintConfig {
            cores: None,
            always_missing_wcet: false,
            control_task_budget: Ratio::new(1, 100),
        }
    }
}
