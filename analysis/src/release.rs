//! A release of GenoM3 and its origin. [`crate::requirement`] finds the one for a specification.

use std::fmt;

use camino::Utf8PathBuf;
pub use dotgen_syntax::release::{Area, CHANGES, Change, Entry, NoRelease, Release};

/// A release, and its origin.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct ReleaseChoice {
    pub release: Release,
    pub origin: ReleaseOrigin,
}

/// The origin of a release, strongest first.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub enum ReleaseOrigin {
    /// `--release`
    CommandLine,
    /// `DOTGEN_GENOM_RELEASE`
    Environment,
    /// A setting of the editor.
    Editor,
    ConfigurationFile(Utf8PathBuf),
    /// The version file of the GenoM3 whose templates are used.
    Templates(Utf8PathBuf),
    /// The package of the installed GenoM3.
    Package,
    /// The greatest lower bound that the specifications require.
    Required(Release),
    /// No origin: the newest release that dotgen was compared with.
    #[default]
    Default,
}

impl ReleaseOrigin {
    /// Returns true if the user or the installation sets it, not the specifications or the default.
    pub(crate) fn is_given(&self) -> bool {
        !matches!(self, ReleaseOrigin::Required(_) | ReleaseOrigin::Default)
    }
}

impl fmt::Display for ReleaseOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ReleaseOrigin::CommandLine => f.write_str("given by `--release`"),
            ReleaseOrigin::Environment => f.write_str("given by `DOTGEN_GENOM_RELEASE`"),
            ReleaseOrigin::Editor => f.write_str("given by the editor's settings"),
            ReleaseOrigin::ConfigurationFile(path) => write!(f, "given by {path}"),
            ReleaseOrigin::Templates(path) => write!(f, "installed: {path}"),
            ReleaseOrigin::Package => f.write_str("installed: package `genom3`"),
            ReleaseOrigin::Required(bound) => {
                write!(f, "the specifications require `genom3 >= {bound}`")
            }
            ReleaseOrigin::Default => {
                f.write_str("none is installed or required; the newest that was verified")
            }
        }
    }
}

impl fmt::Display for ReleaseChoice {
    /// `2.99.41 (given by …)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}", self.release, self.origin)?;
        if !self.release.is_verified() {
            f.write_str("; not verified")?;
        }
        f.write_str(")")
    }
}

impl ReleaseChoice {
    /// The choice if the user sets none and nothing is installed: the lower bound of the specifications.
    /// Never older than the oldest known release.
    pub fn required(bound: Option<Release>) -> ReleaseChoice {
        match bound {
            Some(bound) => ReleaseChoice {
                release: bound.max(Release::OLDEST),
                origin: ReleaseOrigin::Required(bound),
            },
            None => ReleaseChoice::default(),
        }
    }
}
