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
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

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
    #[serde(skip_serializing_if = "is_default")]
    pub timing: Timing,
    /// Real-time verification in the editor.
    #[serde(skip_serializing_if = "is_default")]
    pub verification: Verification,
    /// The style of the formatter.
    #[serde(skip_serializing_if = "is_default")]
    pub format: Format,
    /// Location of the C and C++ sources of codels.
    #[serde(skip_serializing_if = "is_default")]
    pub codels: Codels,
    /// Components as ROS 2 nodes.
    #[serde(skip_serializing_if = "is_default")]
    pub ros2: Ros2,
    /// Show code lenses above declarations; on by default. Further settings select the lenses.
    #[schemars(extend("default" = true))]
    pub code_lens: Option<bool>,
    /// Show answers of verification above tasks and checks; on by default.
    #[schemars(extend("default" = true))]
    pub code_lens_verdicts: Option<bool>,
    /// Show a link to the state machine above tasks and activities; on by default.
    #[schemars(extend("default" = true))]
    pub code_lens_state_machines: Option<bool>,
    /// Show readers and writers above ports and members of the `ids`; on by default.
    #[schemars(extend("default" = true))]
    pub code_lens_accesses: Option<bool>,
    /// Show the specification of a codel above its C or C++ function; on by default.
    #[schemars(extend("default" = true))]
    pub code_lens_codels: Option<bool>,
    /// Show commands that run a component or a scenario above its name, in editors that support them; on by
    /// default.
    #[schemars(extend("default" = true))]
    pub code_lens_runs: Option<bool>,
    /// Show the types of names that another component or interface declares.
    #[schemars(extend("default" = true))]
    pub inlay_hints_inherited_types: Option<bool>,
    /// Show the types of all parameters that name data.
    #[schemars(extend("default" = false))]
    pub inlay_hints_all_types: Option<bool>,
    /// Show the end of a state machine that has no codel for `stop`.
    #[schemars(extend("default" = true))]
    pub inlay_hints_implicit_ether: Option<bool>,
    /// Show the longest time from a state to the next pause.
    #[schemars(extend("default" = true))]
    pub inlay_hints_wcet: Option<bool>,
    /// Show the share of its period that a task needs.
    #[schemars(extend("default" = true))]
    pub inlay_hints_utilisation: Option<bool>,
    /// Show the values of properties that are not given.
    #[schemars(extend("default" = true))]
    pub inlay_hints_defaults: Option<bool>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Greatest depth of tables that are joined: `ros2.messages.COMPONENT.PORT` is one value.
const TABLES: usize = 3;

/// Some settings on top of `weaker` ones. Tables are joined by key, and so are lists at the top; other values
/// of `strong` take precedence. `depth` is 1 for a table of the settings.
pub(super) fn over<T: Serialize + DeserializeOwned>(strong: T, weak: T, depth: usize) -> T {
    let json = |settings: &T| serde_json::to_value(settings);
    let merged = json(&strong).and_then(|mut merged| {
        merge(&mut merged, json(&weak)?, depth);
        serde_json::from_value(merged)
    });
    // What was read can be written, and read again.
    merged.unwrap_or_else(|error| {
        tracing::error!("settings cannot be combined: {error}");
        strong
    })
}

fn merge(strong: &mut Value, weak: Value, depth: usize) {
    match (strong, weak) {
        (Value::Object(strong), Value::Object(weak)) if depth <= TABLES => {
            for (key, value) in weak {
                merge(strong.entry(key).or_insert(Value::Null), value, depth + 1);
            }
        }
        (Value::Array(strong), Value::Array(weak)) if depth == 1 => strong.extend(weak),
        (strong @ Value::Null, weak) => *strong = weak,
        _ => {}
    }
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
    #[schemars(extend("default" = true))]
    pub enable: Option<bool>,
    /// Give up a verification after this many seconds; 10 by default.
    #[schemars(extend("default" = 10))]
    pub time_limit: Option<f64>,
    /// Give up a verification at this number of states; 2000000 by default.
    #[schemars(extend("default" = 2_000_000))]
    pub max_states: Option<u32>,
    /// Give up a verification if its states need more than this many megabytes; 1024 by default.
    #[schemars(extend("default" = 1024))]
    pub max_memory: Option<u32>,
    /// Order in which tasks get a core, if no scenario sets it: `priority` (the default), `fair`, `fifo`,
    /// `edf` or `any`. The number of cores is `timing.cores`.
    #[schemars(extend("default" = "priority"))]
    pub policy: Option<CorePolicy>,
    /// Semantics of the model, if no scenario sets them: the `servers` that run on robots (the default), or
    /// the `published` formal models.
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
    pub cores: Option<u32>,
    /// Report codels without an execution time in all components. By default they are reported only in
    /// components in which another codel has one.
    #[schemars(extend("default" = false))]
    pub require_wcet: Option<bool>,
    /// Longest time, in milliseconds, that one function or attribute may keep the control task
    /// from serving other requests; 10 by default.
    #[schemars(extend("default" = 10))]
    pub control_task_budget: Option<f64>,
}

impl Eq for Timing {}

impl Timing {
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
    pub unit: Option<FormatUnit>,
    /// Columns that a line should not exceed; 80 by default.
    #[schemars(extend("default" = 80))]
    pub width: Option<u16>,
    /// Words that are aligned in a column with words of neighbouring lines: `keep` (the default) keeps the
    /// column, `none` leaves one blank.
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

/// Settings of the sources of codels.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", default)]
pub struct Codels {
    /// Compare specifications with the sources of their codels; on by default.
    #[schemars(extend("default" = true))]
    pub check: Option<bool>,
    /// Folder of the sources, relative to the folder of the `.gen`; `codels` by default.
    #[schemars(extend("default" = "codels"))]
    pub folder: Option<String>,
    /// Extensions of the sources, without dot; `c`, `cc`, `cpp` and `cxx` by default.
    #[schemars(extend("default" = ["c", "cc", "cpp", "cxx"]))]
    pub extensions: Option<Vec<String>>,
    /// Read only the sources that the `Makefile.am` of the folder lists, if any of them exists; on by
    /// default.
    #[schemars(extend("default" = true))]
    pub makefile: Option<bool>,
}

impl Codels {
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
    pub fn over(self, weaker: Settings) -> Settings {
        let stronger = if self.release.is_some() { &self } else { &weaker };
        let release_origin = stronger.release_origin.clone();
        Settings { release_origin, ..over(self, weaker, 0) }
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
