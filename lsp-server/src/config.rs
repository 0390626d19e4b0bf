//! Configuration: the sources of settings, and their combination.
//!
//! Sources, weakest first: built-in defaults, `dotgen.toml` in a workspace folder, the editor's settings, the
//! command line. Each source is read into [`Settings`]; [`Settings::over`] combines them; [`Config`] is the
//! result with absolute paths. The rest of the server uses only [`Config`].

mod problem;
mod read;
mod ros2;
pub mod schema;
mod selection;
mod settings;
pub mod style;

use std::collections::{BTreeMap, BTreeSet};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::LintConfig;
use dotgen_analysis::release::{ReleaseChoice, ReleaseOrigin};
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_diagram::system::Connection;

use dotgen_analysis::ide::{InlayConfig, LensConfig};
use dotgen_platform::files::vfs::PackageConfig;
pub use problem::{Problem, ProblemKind};
pub use read::{LoadedSettings, from_editor, from_toml};
pub use ros2::{Message, Ros2, located, rule_problem};
use settings::over;
pub use settings::{
    DefineValue, Format, FormatAlign, FormatUnit, Generate, Level, Settings, Verification,
};

/// Name of the configuration file of a workspace folder.
pub const FILE_NAME: &str = "dotgen.toml";

/// The settings in force, with absolute paths.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Config {
    /// Directories searched for `#include`, in order.
    pub include_paths: Vec<Utf8PathBuf>,
    /// Macros defined before the first file: name and body.
    pub defines: Vec<(String, String)>,
    /// The release of GenoM3, if the user sets it.
    pub release: Option<ReleaseChoice>,
    /// Directories with a configuration file of their own, which sets their include paths and macros.
    pub projects: Vec<Project>,
    /// The search for packages of `#pragma requires`.
    pub packages: PackageConfig,
    /// Directories searched for templates.
    pub template_paths: Vec<Utf8PathBuf>,
    /// Generations that can be repeated; the files are absolute paths.
    pub generate: Vec<Generate>,
    /// Severity by diagnostic code.
    pub severity: BTreeMap<String, Level>,
    /// Connections between components, each with the directory of its settings.
    pub connections: Vec<(Utf8PathBuf, Connection)>,
    /// The settings of the timing rules.
    pub lints: LintConfig,
    /// Maximum size of a file in kilobytes; larger files are not read.
    pub max_file_size: Option<u32>,
    /// The inlay hints that are shown.
    pub inlay_hints: InlayConfig,
    /// The code lenses that are shown.
    pub code_lens: LensConfig,
    /// True if there are lenses that run components and scenarios.
    pub run_lenses: bool,
    /// Verification of open documents.
    pub verification: Verification,
    /// The style of the formatter.
    pub format: Format,
    /// Settings for ROS 2.
    pub ros2: Ros2,
    /// The files with codels; `None` if specifications are not compared with them.
    pub codels: Option<FilesConfig>,
}

/// The settings for the specifications below a directory.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Project {
    /// The directory of its configuration file.
    pub directory: Utf8PathBuf,
    /// Directories searched for `#include`, in order.
    pub include_paths: Vec<Utf8PathBuf>,
    /// Macros: name and body.
    pub defines: Vec<(String, String)>,
    /// The release of GenoM3, if the user sets it.
    pub release: Option<ReleaseChoice>,
    /// The files with codels, see [`Config::codels`].
    pub codels: Option<FilesConfig>,
}

impl Config {
    /// The configuration of some settings. Relative paths start at `base`.
    pub fn new(settings: &Settings, base: &Utf8Path, trusted: bool) -> Config {
        let absolute = |paths: &[String]| -> Vec<Utf8PathBuf> {
            paths.iter().map(|path| resolve(path, base)).collect()
        };
        Config {
            include_paths: absolute(&settings.include_paths),
            defines: settings
                .defines
                .iter()
                .filter_map(|(name, value)| Some((name.clone(), value.body()?)))
                .collect(),
            release: release(settings, base),
            projects: Vec::new(),
            packages: PackageConfig {
                paths: absolute(&settings.package_paths),
                templates: absolute(&settings.template_paths),
                may_run: trusted,
                own_interfaces: true,
            },
            template_paths: absolute(&settings.template_paths),
            generate: settings
                .generate
                .iter()
                .map(|generate| Generate {
                    file: resolve(&generate.file, base).into_string(),
                    ..generate.clone()
                })
                .collect(),
            severity: settings.severity.clone(),
            inlay_hints: settings.inlay_config(),
            code_lens: settings.lens_config(),
            run_lenses: settings.run_lenses(),
            connections: connections(settings, base),
            verification: settings.verification.clone(),
            lints: settings.timing.lints(),
            max_file_size: settings.max_file_size,
            format: settings.format,
            ros2: settings.ros2.clone(),
            codels: settings.codels.check.unwrap_or(true).then(|| settings.codels.files()),
        }
    }

    /// The project that a file belongs to, if there is one.
    pub fn project(&self, file: &Utf8Path) -> Option<&Project> {
        let around = self.projects.iter();
        let around = around.filter(|project| file.starts_with(&project.directory));
        around.max_by_key(|project| project.directory.as_str().len())
    }

    /// The release that the user sets for a file.
    pub fn release_of(&self, file: &Utf8Path) -> Option<ReleaseChoice> {
        match self.project(file) {
            Some(project) => project.release.clone(),
            None => self.release.clone(),
        }
    }

    /// The files with codels of a specification, or of the specifications in the folder of a file; `None` if
    /// these are not compared. A project without settings for codels follows the workspace.
    pub fn codels_of(&self, file: &Utf8Path) -> Option<&FilesConfig> {
        let own = self.project(file).map(|project| &project.codels);
        let said = own.filter(|own| **own != Some(FilesConfig::default()));
        said.unwrap_or(&self.codels).as_ref()
    }

    /// The connections for the components in a folder of a file: those of the directories around the file.
    pub(crate) fn connections_of(&self, file: &Utf8Path) -> Vec<Connection> {
        let around = self.connections.iter().filter(|(directory, _)| file.starts_with(directory));
        around.map(|(_, connection)| connection.clone()).collect()
    }

    /// Folders of codels, of the workspace and its projects.
    pub(crate) fn codel_folders(&self) -> BTreeSet<Utf8PathBuf> {
        let projects = self.projects.iter().filter_map(|project| project.codels.as_ref());
        let all = self.codels.iter().chain(projects);
        all.map(|config| config.folder.clone()).collect()
    }

    /// Adds the configuration of a directory, which applies to files below the directory. Its other settings
    /// apply everywhere, unless they are already set.
    pub(crate) fn with_project(mut self, directory: &Utf8Path, mut own: Config) -> Config {
        self.projects.push(Project {
            directory: directory.to_owned(),
            include_paths: std::mem::take(&mut own.include_paths),
            defines: std::mem::take(&mut own.defines),
            release: own.release.take(),
            codels: own.codels.replace(FilesConfig::default()),
        });
        self.join(own)
    }

    /// The settings that analysis needs.
    pub fn for_analysis(&self) -> dotgen_analysis::host::Config {
        let defines = |all: &[(String, String)]| {
            let all = all.iter();
            all.map(|(name, body)| (name.into(), body.into())).collect()
        };
        let projects = self.projects.iter();
        dotgen_analysis::host::Config {
            include_dirs: self.include_paths.clone(),
            defines: defines(&self.defines),
            release: self.release.clone(),
            projects: projects
                .map(|project| dotgen_analysis::host::Project {
                    directory: project.directory.clone(),
                    include_dirs: project.include_paths.clone(),
                    defines: defines(&project.defines),
                    release: project.release.clone(),
                })
                .collect(),
            severities: self
                .severity
                .iter()
                .map(|(code, level)| (code.clone(), level.severity()))
                .collect(),
            lints: self.lints.clone(),
            max_file_bytes: self.max_file_size.map(|size| u64::from(size) * 1024),
        }
    }

    /// The configuration of several workspace folders. Paths of the earlier folder are searched first, and
    /// its settings with a single value (a macro, a severity) take precedence.
    pub fn join(mut self, other: Config) -> Config {
        add_new(&mut self.include_paths, other.include_paths);
        add_new(&mut self.template_paths, other.template_paths);
        self.generate.extend(other.generate);
        add_new(&mut self.packages.paths, other.packages.paths);
        add_new(&mut self.packages.templates, other.packages.templates);
        self.release = self.release.or(other.release);
        for (name, body) in other.defines {
            if self.defines.iter().all(|(known, _)| *known != name) {
                self.defines.push((name, body));
            }
        }
        for (code, level) in other.severity {
            self.severity.entry(code).or_insert(level);
        }
        self.connections.extend(other.connections);
        self.verification = over(self.verification, other.verification, 1);
        self.max_file_size = self.max_file_size.or(other.max_file_size);
        self.format = over(self.format, other.format, 1);
        self.ros2 = over(self.ros2, other.ros2, 1);
        if self.lints == LintConfig::default() {
            self.lints = other.lints;
        }
        if self.codels == Some(FilesConfig::default()) {
            self.codels = other.codels;
        }
        self
    }
}

/// Adds the paths that are not in a list yet.
fn add_new(paths: &mut Vec<Utf8PathBuf>, more: Vec<Utf8PathBuf>) {
    for path in more {
        if !paths.contains(&path) {
            paths.push(path);
        }
    }
}

/// Environment variable that sets the release of GenoM3.
pub const RELEASE_VARIABLE: &str = "DOTGEN_GENOM_RELEASE";

/// The release that [`RELEASE_VARIABLE`] sets.
///
/// # Errors
/// The value is not a release. The message is for the user.
pub fn release_of_environment() -> Result<Option<ReleaseChoice>, String> {
    match std::env::var(RELEASE_VARIABLE) {
        Ok(text) if !text.is_empty() => match text.parse() {
            Ok(release) => Ok(Some(ReleaseChoice { release, origin: ReleaseOrigin::Environment })),
            Err(error) => Err(format!("{RELEASE_VARIABLE}: {error}")),
        },
        _ => Ok(None),
    }
}

/// The release that the command line, the environment, the editor or a configuration file sets, in this order
/// of precedence.
fn release(settings: &Settings, base: &Utf8Path) -> Option<ReleaseChoice> {
    let said = settings.release.map(|release| ReleaseChoice {
        release,
        origin: match &settings.release_origin {
            Some(origin) => origin.clone(),
            None => ReleaseOrigin::ConfigurationFile(base.join(FILE_NAME)),
        },
    });
    if let Some(ReleaseChoice { origin: ReleaseOrigin::CommandLine, .. }) = said {
        return said;
    }
    // An invalid value of the variable is reported at the start of the program.
    release_of_environment().ok().flatten().or(said)
}

/// Connections as pairs of ports. A name that is not `component.port` is ignored.
fn connections(settings: &Settings, base: &Utf8Path) -> Vec<(Utf8PathBuf, Connection)> {
    let mut out = Vec::new();
    for (reader, ports) in &settings.connections {
        for (port, writers) in ports {
            for writer in writers.all() {
                if let Some((component, source)) = writer.split_once('.') {
                    let connection = Connection {
                        from: (component.to_owned(), source.to_owned()),
                        to: (reader.clone(), port.clone()),
                    };
                    out.push((base.to_owned(), connection));
                }
            }
        }
    }
    out
}

/// The nearest directory around a file that has a `dotgen.toml`.
pub fn nearest_directory(file: &Utf8Path) -> Option<Utf8PathBuf> {
    let mut directories = file.ancestors().skip(1);
    directories.find(|directory| directory.join(FILE_NAME).is_file()).map(Utf8Path::to_owned)
}

/// Makes a path of a setting absolute: `~/x`, `${workspaceFolder}/x`, `${env:NAME}/x`, or relative
/// to `base`.
fn resolve(path: &str, base: &Utf8Path) -> Utf8PathBuf {
    let mut text = path.replace("${workspaceFolder}", base.as_str());
    while let Some(start) = text.find("${env:") {
        let Some(length) = text[start..].find('}') else {
            break;
        };
        let name = &text[start + "${env:".len()..start + length];
        let value = std::env::var(name).unwrap_or_default().replace("${", "$");
        text.replace_range(start..=start + length, &value);
    }
    if let (Some(rest), Ok(home)) = (text.strip_prefix("~/"), std::env::var("HOME")) {
        return dotgen_platform::files::vfs::normalize(&Utf8Path::new(&home).join(rest));
    }
    dotgen_platform::files::vfs::normalize(&base.join(text))
}

#[cfg(test)]
mod tests;
