//! The interface of the preprocessor to included files and packages.

use smol_str::SmolStr;

use super::MacroEnv;

/// The outside world of the preprocessor: the files and packages that a text names.
pub trait Host {
    /// Handles an active `#include`: returns the environment after the included file.
    ///
    /// # Errors
    /// Returns the reason if the file could not be included; the environment is then taken as unchanged.
    fn include(
        &mut self,
        request: &IncludeRequest,
        env: &MacroEnv,
    ) -> Result<MacroEnv, IncludeError>;

    /// Handles an active `#pragma requires`: returns the environment with the `-D` definitions of the
    /// packages (see [`MacroEnv::define_option`]). The host handles include directories itself.
    ///
    /// # Errors
    /// Returns a message for the user; the environment is then taken as unchanged.
    fn requires(
        &mut self,
        arguments: &[SmolStr],
        env: &MacroEnv,
    ) -> Result<RequiredPackages, String>;
}

/// The result of requiring packages.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct RequiredPackages {
    /// The environment with the definitions of the packages.
    pub env: MacroEnv,
    /// Packages that are not installed and are replaced by definitions that come with dotgen.
    pub own: Vec<SmolStr>,
}

impl From<MacroEnv> for RequiredPackages {
    fn from(env: MacroEnv) -> RequiredPackages {
        let own = Vec::new();
        RequiredPackages { env, own }
    }
}

/// A host that finds no file and accepts every package, for standalone texts.
#[derive(Debug, Default)]
pub struct NoIncludes;

impl Host for NoIncludes {
    fn include(&mut self, _: &IncludeRequest, _: &MacroEnv) -> Result<MacroEnv, IncludeError> {
        Err(IncludeError::NotFound { searched: Vec::new() })
    }

    fn requires(&mut self, _: &[SmolStr], env: &MacroEnv) -> Result<RequiredPackages, String> {
        Ok(env.clone().into())
    }
}

/// A file requested by an active `#include`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct IncludeRequest {
    /// Ordinal among the active `#include` directives of the file.
    pub ordinal: u32,
    /// As written between the delimiters.
    pub path: SmolStr,
    /// `<…>`: the directory of the including file is not searched.
    pub angled: bool,
}

/// The reason why a file could not be included.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum IncludeError {
    /// No such file (`pp-include-not-found`).
    NotFound {
        /// The directories that were searched, for the message; may be empty.
        searched: Vec<String>,
    },
    /// Found but unusable, with the reason: a directory, not readable… (`pp-include-not-found`).
    Unreadable(String),
    /// More than 100 files open (`pp-include-depth`).
    TooDeep,
    /// Not included, for a reason that is reported elsewhere.
    Silent,
}
