//! The default scenario, for a verification without a scenario.

use std::fmt::Write;

use dotgen_analysis::model::{Component, ServiceKind};

use super::ast::Policy;
use super::semantics::Preset;

/// Returns the default scenario: permanent activities, and a client that may send any request at any time,
/// one after the other.
pub fn default_text(components: &[&Component], files: &[String]) -> String {
    default_text_on(components, files, Platform::default())
}

/// The platform of the default scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Platform {
    /// Number of cores; `None`: as many as there are tasks.
    pub cores: Option<u32>,
    /// Order in which cores are granted, if it is stated.
    pub policy: Option<Policy>,
    /// Semantics of the model, if they are stated.
    pub semantics: Option<Preset>,
}

/// Returns the default scenario for a platform.
pub fn default_text_on(components: &[&Component], files: &[String], platform: Platform) -> String {
    let name = match components {
        [component] => component.name.to_string(),
        _ => "all".to_owned(),
    };
    let mut out = format!("scenario {name} {{\n");
    for file in files {
        let _ = writeln!(out, "  use \"{file}\";");
    }
    if let Some(semantics) = platform.semantics {
        let _ = writeln!(out, "  semantics {};", semantics.name());
    }
    let _ = match platform.cores {
        None => writeln!(out, "  cores free;"),
        Some(cores) => writeln!(out, "  cores {cores};"),
    };
    if let (Some(_), Some(policy)) = (platform.cores, platform.policy) {
        let _ = writeln!(out, "  policy {};", policy.name());
    }
    out.push_str("  durations interval;\n\n");
    let services: Vec<String> = components
        .iter()
        .flat_map(|component| {
            component
                .services
                .iter()
                .filter(|service| service.kind != ServiceKind::Activity || service.task.is_some())
                .map(move |service| format!("{}.{}", component.name, service.name))
        })
        .collect();
    if !services.is_empty() {
        out.push_str("  // Any request at any time, one after the other.\n");
        out.push_str("  client any {\n    repeat * {\n      delay [0, *] ms;\n");
        for (i, service) in services.iter().enumerate() {
            match (services.len(), i) {
                (1, _) => {
                    let _ = writeln!(out, "      send {service};");
                }
                (_, 0) => {
                    let _ = write!(out, "      choice {{\n        send {service};\n      }}");
                }
                _ => {
                    let _ = write!(out, " or {{\n        send {service};\n      }}");
                }
            }
        }
        if services.len() > 1 {
            out.push('\n');
        }
        out.push_str("    }\n  }\n\n");
    }
    out.push_str("  check schedulable *;\n  check no-overdue *;\n  check response *;\n}\n");
    out
}
