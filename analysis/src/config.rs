//! The settings of the analysis.

use camino::Utf8PathBuf;
use num_rational::Ratio;
use smol_str::SmolStr;

use crate::{diagnostic::Severity, model::Seconds, release::ReleaseChoice};

/// Settings that change the meaning of a specification or its reports.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Config {
    /// `-I`, in order.
    pub include_dirs: Vec<Utf8PathBuf>,
    /// `-D`, in order: name and value (`1` when none was given).
    pub defines: Vec<(SmolStr, SmolStr)>,
    /// The release of GenoM3 for all specifications; `None` if the user does not set one.
    pub release: Option<ReleaseChoice>,
    /// Directories with settings of their own.
    pub projects: Vec<Project>,
    /// Severity per code; `None` switches a code off. Errors stay errors: the configuration changes only
    /// warnings, information and hints.
    pub severities: Vec<(String, Option<Severity>)>,
    /// The settings of the lints.
    pub lints: LintConfig,
    /// Maximum size of a file in bytes; larger files are reported and not read. [`MAX_FILE_BYTES`] by
    /// default.
    pub max_file_bytes: Option<u64>,
}

/// Default maximum size of a file in bytes; a larger file is not a handwritten specification.
pub const MAX_FILE_BYTES: u64 = 4 << 20;

/// Settings for the specifications below a directory, instead of the settings in [`Config`]. The innermost
/// project applies.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Project {
    /// Absolute path.
    pub directory: Utf8PathBuf,
    /// `-I`, in order.
    pub include_dirs: Vec<Utf8PathBuf>,
    /// `-D`, in order.
    pub defines: Vec<(SmolStr, SmolStr)>,
    /// The release of GenoM3.
    pub release: Option<ReleaseChoice>,
}

/// The settings of the rules, besides the model.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LintConfig {
    /// Number of cores of the platform, if known.
    pub cores: Option<u32>,
    /// True to report codels without execution time even in components without any.
    pub always_missing_wcet: bool,
    /// Longest time that one function may occupy the control task, in seconds.
    pub control_task_budget: Seconds,
}

impl LintConfig {
    /// An exact time from a number of milliseconds in a configuration; `None` if it is not a time.
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
