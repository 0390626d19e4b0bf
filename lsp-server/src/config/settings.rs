//! The settings of `dotgen.toml`. The JSON schema and the manual's table are generated from the doc comments
//! here.

use std::collections::BTreeMap;
use std::time::Duration;

use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::host::LintConfig;
use dotgen_analysis::release::{Release, ReleaseOrigin};
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_timing::explore::Limits;
use dotgen_timing::scn::ast::Policy;
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::verify::Options;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ros2::Ros2;

/// Settings of dotgen, as written in `dotgen.toml` at the root of a workspace folder.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", default)]
#[schemars(title = "dotgen settings")]
pub struct Settings {
    /// Directories searched for `#include`, in order, after the directory of the including file (for the
    /// quoted form). Relative paths start at the directory of dotgen.toml, in the editor's settings at the
    /// workspace folder.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub include_paths: Vec<String>,
    /// Macros defined before the first file: a string or number is the body, `true` stands for 1,
    /// and `false` leaves the macro undefined.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub defines: BTreeMap<String, DefineValue>,
    /// The release of GenoM3 that specifications are read as, for example `"2.99.41"`; by default the
    /// installed one, else the greatest that the specifications require.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub release: Option<Release>,
    /// Who says [`Settings::release`], if that is not the configuration file.
    #[serde(skip)]
    pub release_origin: Option<ReleaseOrigin>,
    /// Directories with `.pc` files, searched for the packages of `#pragma requires` before those of
    /// pkg-config. The environment variable `PKG_CONFIG` sets the program; by default it is `pkg-config`. If
    /// the program is not installed, dotgen reads `.pc` files itself.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub package_paths: Vec<String>,
    /// The largest file that is read, in kilobytes; 4096 by default. A larger file gets a diagnostic instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 4096))]
    pub max_file_size: Option<u32>,
    /// Severity by diagnostic code, for example `pp-redefined = "off"`. Errors of GenoM3 stay errors.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub severity: BTreeMap<String, Level>,
    /// Output ports that feed input ports, for diagrams of systems: by reading component, then by its port,
    /// the writer as `component.port`. Ports that are not named here are connected by type and name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub connections: BTreeMap<String, BTreeMap<String, Writers>>,
    /// Directories searched for templates, instead of those of the environment variable
    /// `GENOM_TMPL_PATH`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub template_paths: Vec<String>,
    /// Generations that "Regenerate" repeats; "Generate…" writes them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub generate: Vec<Generate>,
    /// Settings of the timing rules.
    #[serde(skip_serializing_if = "Timing::is_default")]
    pub timing: Timing,
    /// Real-time verification in the editor.
    #[serde(skip_serializing_if = "Verification::is_default")]
    pub verification: Verification,
    /// The style of the formatter.
    #[serde(skip_serializing_if = "Format::is_default")]
    pub format: Format,
    /// Location of the C and C++ sources of codels.
    #[serde(skip_serializing_if = "Codels::is_default")]
    pub codels: Codels,
    /// Components as ROS 2 nodes.
    #[serde(skip_serializing_if = "Ros2::is_default")]
    pub ros2: Ros2,
    /// Show code lenses above declarations; on by default. Further settings select the lenses.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub code_lens: Option<bool>,
    /// Show answers of verification above tasks and checks; on by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub code_lens_verdicts: Option<bool>,
    /// Show a link to the state machine above tasks and activities; on by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub code_lens_state_machines: Option<bool>,
    /// Show readers and writers above ports and members of the `ids`; on by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub code_lens_accesses: Option<bool>,
    /// Show the specification of a codel above its C or C++ function; on by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub code_lens_codels: Option<bool>,
    /// Show commands that run a component or a scenario above its name, in editors that support them; on by
    /// default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub code_lens_runs: Option<bool>,
    /// Show the types of names that another component or interface declares.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub inlay_hints_inherited_types: Option<bool>,
    /// Show the types of all parameters that name data.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub inlay_hints_all_types: Option<bool>,
    /// Show the end of a state machine that has no codel for `stop`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub inlay_hints_implicit_ether: Option<bool>,
    /// Show the longest time from a state to the next pause.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub inlay_hints_wcet: Option<bool>,
    /// Show the share of its period that a task needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub inlay_hints_utilisation: Option<bool>,
    /// Show the values of properties that are not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub inlay_hints_defaults: Option<bool>,
}

/// A template run on a specification.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub struct Generate {
    /// The specification, relative to the directory of this file.
    pub file: String,
    /// Name of the template.
    pub template: String,
    /// Its options.
    #[serde(default)]
    pub arguments: Vec<String>,
}

/// Settings of real-time verification in the editor.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", default)]
pub struct Verification {
    /// Verify open scenarios, and open specifications with timing, after every edit; on by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub enable: Option<bool>,
    /// Give up a verification after this many seconds; 10 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 10))]
    pub time_limit: Option<f64>,
    /// Give up a verification at this number of states; 2000000 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 2_000_000))]
    pub max_states: Option<u32>,
    /// Give up a verification if its states need more than this many megabytes; 1024 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 1024))]
    pub max_memory: Option<u32>,
    /// Order in which tasks get a core, if no scenario sets it: `priority` (the default), `fair`, `fifo`,
    /// `edf` or `any`. The number of cores is `timing.cores`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = "priority"))]
    pub policy: Option<CorePolicy>,
    /// Semantics of the model, if no scenario sets them: the `servers` that run on robots (the default), or
    /// the `published` formal models.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = "servers"))]
    pub semantics: Option<VerificationSemantics>,
}

/// Semantics of the timed model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VerificationSemantics {
    /// The servers that run on robots.
    Servers,
    /// The published formal models.
    Published,
}

/// Order in which waiting tasks get a core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CorePolicy {
    /// In order of release.
    Fifo,
    /// Earliest deadline first.
    Edf,
    /// Any waiting task.
    Any,
    /// The ready tasks of highest priority, preempting others.
    Priority,
    /// Any ready tasks, preempting others.
    Fair,
}

impl Eq for Verification {}

impl Verification {
    fn is_default(&self) -> bool {
        *self == Verification::default()
    }

    /// These settings on top of `weaker` ones.
    pub(super) fn over(self, weaker: Verification) -> Verification {
        Verification {
            enable: self.enable.or(weaker.enable),
            time_limit: self.time_limit.or(weaker.time_limit),
            max_states: self.max_states.or(weaker.max_states),
            max_memory: self.max_memory.or(weaker.max_memory),
            policy: self.policy.or(weaker.policy),
            semantics: self.semantics.or(weaker.semantics),
        }
    }

    /// True if documents are verified on edit.
    pub(crate) fn on_edit(&self) -> bool {
        self.enable != Some(false)
    }

    /// The time limit of a verification.
    pub fn time_limit(&self) -> Duration {
        let seconds = self.time_limit.filter(|limit| limit.is_finite() && *limit > 0.0);
        Duration::from_secs_f64(seconds.unwrap_or(10.0).min(86_400.0))
    }

    /// The options for the verifier.
    pub fn options(&self) -> Options {
        Options {
            limits: Limits {
                states: self.max_states.unwrap_or(2_000_000) as usize,
                bytes: (self.max_memory.unwrap_or(1024) as usize) << 20,
                threads: Limits::default().threads.saturating_sub(1).max(1),
                ..Limits::default()
            },
            ..Options::default()
        }
    }

    /// The policy of the default scenario.
    pub fn policy(&self) -> Option<Policy> {
        self.policy.map(|policy| match policy {
            CorePolicy::Fifo => Policy::Fifo,
            CorePolicy::Edf => Policy::Edf,
            CorePolicy::Any => Policy::Any,
            CorePolicy::Priority => Policy::Priority,
            CorePolicy::Fair => Policy::Fair,
        })
    }

    /// The semantics of the default scenario.
    pub fn semantics(&self) -> Option<Preset> {
        self.semantics.map(|semantics| match semantics {
            VerificationSemantics::Servers => Preset::Servers,
            VerificationSemantics::Published => Preset::Published,
        })
    }
}

/// Settings of the rules about time.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", default)]
pub struct Timing {
    /// Number of processor cores of the robot. Without a number, the load is not compared with anything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cores: Option<u32>,
    /// Report codels without an execution time in all components. By default they are reported only in
    /// components in which another codel has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub require_wcet: Option<bool>,
    /// Longest time, in milliseconds, that one function or attribute may keep the control task
    /// from serving other requests; 10 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 10))]
    pub control_task_budget: Option<f64>,
}

impl Eq for Timing {}

impl Timing {
    fn is_default(&self) -> bool {
        *self == Timing::default()
    }

    /// These settings on top of `weaker` ones.
    fn over(self, weaker: Timing) -> Timing {
        Timing {
            cores: self.cores.or(weaker.cores),
            require_wcet: self.require_wcet.or(weaker.require_wcet),
            control_task_budget: self.control_task_budget.or(weaker.control_task_budget),
        }
    }

    /// The settings that the lints need.
    pub(super) fn lints(&self) -> LintConfig {
        let default = LintConfig::default();
        LintConfig {
            cores: self.cores,
            always_missing_wcet: self.require_wcet.unwrap_or(default.always_missing_wcet),
            control_task_budget: self
                .control_task_budget
                .and_then(LintConfig::milliseconds)
                .unwrap_or(default.control_task_budget),
        }
    }
}

/// The style of the formatter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", default)]
pub struct Format {
    /// Indentation of one level: a number of blanks, or `"tab"`. The default is taken from `.editorconfig`,
    /// else from the file, else from the editor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<FormatUnit>,
    /// Columns that a line should not exceed; 80 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 80))]
    pub width: Option<u16>,
    /// Words that are aligned in a column with words of neighbouring lines: `keep` (the default) keeps the
    /// column, `none` leaves one blank.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = "keep"))]
    pub align: Option<FormatAlign>,
}

/// White space of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum FormatUnit {
    /// A number of blanks.
    Blanks(u8),
    /// One tab.
    Word(Tabulator),
}

/// A tabulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Tabulator {
    /// One for each level.
    Tab,
}

/// What becomes of columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FormatAlign {
    /// They stay.
    Keep,
    /// One blank is enough.
    None,
}

impl Format {
    fn is_default(&self) -> bool {
        *self == Format::default()
    }

    /// These settings on top of `weaker` ones.
    pub(super) fn over(self, weaker: Format) -> Format {
        Format {
            unit: self.unit.or(weaker.unit),
            width: self.width.or(weaker.width),
            align: self.align.or(weaker.align),
        }
    }
}

/// Settings of the sources of codels.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", default)]
pub struct Codels {
    /// Compare specifications with the sources of their codels; on by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub check: Option<bool>,
    /// Folder of the sources, relative to the folder of the `.gen`; `codels` by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = "codels"))]
    pub folder: Option<String>,
    /// Extensions of the sources, without dot; `c`, `cc`, `cpp` and `cxx` by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = ["c", "cc", "cpp", "cxx"]))]
    pub extensions: Option<Vec<String>>,
    /// Read only the sources that the `Makefile.am` of the folder lists, if any of them exists; on by
    /// default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = true))]
    pub makefile: Option<bool>,
}

impl Codels {
    fn is_default(&self) -> bool {
        *self == Codels::default()
    }

    /// These settings on top of `weaker` ones.
    fn over(self, weaker: Codels) -> Codels {
        Codels {
            check: self.check.or(weaker.check),
            folder: self.folder.or(weaker.folder),
            extensions: self.extensions.or(weaker.extensions),
            makefile: self.makefile.or(weaker.makefile),
        }
    }

    /// The files with codels.
    pub fn files(&self) -> FilesConfig {
        let default = FilesConfig::default();
        let folder = self.folder.as_deref().map(|folder| folder.trim_end_matches('/'));
        FilesConfig {
            folder: folder.map_or(default.folder, Into::into),
            extensions: self.extensions.clone().unwrap_or(default.extensions),
            makefile: self.makefile.unwrap_or(default.makefile),
        }
    }
}

/// Output ports that feed an input port, each as `component.port`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Writers {
    /// One.
    One(String),
    /// Several, for a `port multiple`.
    Several(Vec<String>),
}

impl Writers {
    /// The ports as written.
    pub fn all(&self) -> &[String] {
        match self {
            Writers::One(one) => std::slice::from_ref(one),
            Writers::Several(all) => all,
        }
    }
}

/// Value of a macro in the settings.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum DefineValue {
    /// `true`: defined as 1. `false`: not defined.
    Flag(bool),
    /// The body, a number.
    Number(i64),
    /// The body.
    Text(String),
}

/// Severity of a diagnostic code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Rejects the specification: `dotgen check` fails.
    Error,
    /// Probably wrong.
    Warning,
    /// Worth knowing.
    Information,
    /// Shown discreetly.
    Hint,
    /// Not reported.
    Off,
}

impl DefineValue {
    /// Body of the macro; `None` if the macro is not defined.
    pub fn body(&self) -> Option<String> {
        match self {
            DefineValue::Flag(true) => Some("1".to_owned()),
            DefineValue::Flag(false) => None,
            DefineValue::Number(number) => Some(number.to_string()),
            DefineValue::Text(text) => Some(text.clone()),
        }
    }
}

impl Settings {
    /// These settings on top of `weaker` ones. Lists are joined, these first. Tables are joined by key, and
    /// these take precedence.
    ///
    /// Lists are joined because editors send an empty list for a setting that the user has not changed.
    pub fn over(mut self, mut weaker: Settings) -> Settings {
        self.max_file_size = self.max_file_size.or(weaker.max_file_size);
        let lenses = weaker.code_lenses();
        for (own, weaker) in self.code_lenses_mut().into_iter().zip(lenses) {
            *own = own.or(weaker);
        }
        if self.release.is_none() {
            self.release = weaker.release;
            self.release_origin = weaker.release_origin.take();
        }
        let hints = weaker.inlay_hints();
        for (own, weaker) in self.inlay_hints_mut().into_iter().zip(hints) {
            *own = own.or(weaker);
        }
        self.template_paths.extend(weaker.template_paths);
        self.generate.extend(weaker.generate);
        self.include_paths.extend(weaker.include_paths);
        self.package_paths.extend(weaker.package_paths);
        for (name, value) in weaker.defines {
            self.defines.entry(name).or_insert(value);
        }
        for (code, level) in weaker.severity {
            self.severity.entry(code).or_insert(level);
        }
        for (component, ports) in weaker.connections {
            let known = self.connections.entry(component).or_default();
            for (port, writers) in ports {
                known.entry(port).or_insert(writers);
            }
        }
        self.timing = self.timing.over(weaker.timing);
        self.verification = self.verification.over(weaker.verification);
        self.codels = self.codels.over(weaker.codels);
        self.format = self.format.over(weaker.format);
        self.ros2 = self.ros2.over(weaker.ros2);
        self
    }

    /// Adds a `NAME` or `NAME=VALUE` of the command line.
    pub fn define(&mut self, argument: &str) {
        let (name, value) = match argument.split_once('=') {
            Some((name, value)) => (name, DefineValue::Text(value.to_owned())),
            None => (argument, DefineValue::Flag(true)),
        };
        self.defines.insert(name.to_owned(), value);
    }

    /// Sets the origin of the release, if there is a release without one.
    pub fn chosen_by(mut self, origin: ReleaseOrigin) -> Settings {
        if self.release.is_some() && self.release_origin.is_none() {
            self.release_origin = Some(origin);
        }
        self
    }

    /// Resolves relative directories against `base`, so that sources with different bases can be combined.
    pub fn resolved_against(mut self, base: &camino::Utf8Path) -> Settings {
        let paths = self.include_paths.iter_mut().chain(&mut self.package_paths);
        for path in paths.chain(&mut self.template_paths) {
            *path = super::resolve(path, base).into_string();
        }
        self
    }
}

impl Level {
    /// The severity; `None` for off.
    pub fn severity(self) -> Option<Severity> {
        match self {
            Level::Error => Some(Severity::Error),
            Level::Warning => Some(Severity::Warning),
            Level::Information => Some(Severity::Information),
            Level::Hint => Some(Severity::Hint),
            Level::Off => None,
        }
    }

    /// A finding with its configured severity; `None` if it is off. Errors remain: they are reasons why
    /// something fails.
    pub fn apply(
        levels: &BTreeMap<String, Level>,
        mut diagnostic: Diagnostic,
    ) -> Option<Diagnostic> {
        if diagnostic.severity != Severity::Error
            && let Some(level) = levels.get(diagnostic.code)
        {
            diagnostic.severity = level.severity()?;
        }
        Some(diagnostic)
    }
}
