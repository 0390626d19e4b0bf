//! Codels that are executed: their selection, and their build.

use std::collections::{HashMap, HashSet};

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Severity;
use dotgen_codegen::codels::build::Optimization;
use dotgen_codegen::codels::files::{Files as _, Sources};
use dotgen_codegen::codels::folder::folders;
use dotgen_codegen::codels::value::Values;
use dotgen_runtime::live::{HostedComponent, HostedComponents};
use dotgen_runtime::refine;
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::settings::Settings;
use dotgen_timing::system::{ClientId, CodelId, ComponentId, Ticks};
use dotgen_timing::verify::{Interrupt, Prepared};

use crate::codels::build;
use crate::report::{self, FileReports};
use crate::session::Session;
use dotgen_lsp_server::features::codels::Disk;
use dotgen_views::verification::Problem;
use typed_index_collections::{TiVec, ti_vec};

/// The executed part of a system.
pub(super) struct Hosted<'s> {
    /// By component of [`Names`].
    parts: Vec<Option<HostedComponent<'s>>>,
    /// Shared objects, by component of [`Names`].
    libraries: Vec<Option<Utf8PathBuf>>,
    /// Notes for the report.
    pub(super) notes: Vec<String>,
}

/// Builds the components with sources, on request for a debugger. Returns `None` if the build fails, which is
/// reported, or is interrupted.
pub(super) fn build<'s>(
    session: &Session,
    problem: &Problem,
    names: &Names<'s>,
    debug: bool,
    interrupt: &Interrupt,
) -> anyhow::Result<Option<Hosted<'s>>> {
    let mut out = Hosted {
        parts: names.components.iter().map(|_| None).collect(),
        libraries: vec![None; names.components.len()],
        notes: Vec::new(),
    };
    let mut said = FileReports::default();
    let mut failed = false;
    let config = session.codels();
    for (number, unit) in problem.units.iter().enumerate() {
        let mut sources = |path: &Utf8Path| Sources::load(path, &config, &Disk);
        for folder in folders(unit, &mut sources) {
            if folder.sources.sources.is_empty() {
                continue;
            }
            let optimization = if debug { Optimization::None } else { Optimization::Some };
            let built = build::hosts(&folder, session.packages(), optimization, interrupt)?;
            failed |= built.failed;
            let mut errors = built.diagnostics;
            errors.retain(|error| error.severity == Severity::Error);
            said.add(errors, |path| Disk.read(path));
            for shared_object in built.hosted {
                let name = &unit.spec.components[shared_object.component].name;
                let found = names.components.iter().position(|member| {
                    member.spec_index == number && member.component.name == *name
                });
                let Some(found) = found else { continue };
                out.libraries[found] = Some(shared_object.link.output);
                let missing: HashSet<_> = shared_object.missing.into_iter().collect();
                out.parts[found] =
                    Some(HostedComponent { member: names.components[found], missing });
            }
        }
    }
    if interrupt.is_raised() {
        return Ok(None);
    }
    if failed {
        said.finish();
        // On standard error: standard output may be read by a program.
        report::text::print_errors(&said.diagnostics, &said.texts)?;
        report::note("codels that do not compile cannot run; `--simulate all` does without them");
        return Ok(None);
    }
    let parts = out.parts.iter().zip(&names.components);
    out.notes = parts
        .filter_map(|(part, member)| simulated_note(&member.component.name, part.as_ref()))
        .collect();
    Ok(Some(out))
}

/// Returns the note about what is simulated of a component.
fn simulated_note(name: &str, part: Option<&HostedComponent<'_>>) -> Option<String> {
    let Some(part) = part else {
        return Some(format!(
            "`{name}` is simulated: it has no sources of codels; `dotgen codels stub` writes them"
        ));
    };
    let mut missing: Vec<&str> = part.missing.iter().map(AsRef::as_ref).collect();
    missing.sort_unstable();
    (!missing.is_empty()).then(|| {
        format!(
            "simulated codels of `{name}`, which have no function (`dotgen codels stub` writes them): {}",
            missing.join(", ")
        )
    })
}

impl<'s> Hosted<'s> {
    /// Returns the absence of executed codels.
    pub(super) fn none(names: &Names<'s>) -> Self {
        Hosted {
            parts: names.components.iter().map(|_| None).collect(),
            libraries: vec![None; names.components.len()],
            notes: Vec::new(),
        }
    }

    /// Returns true if no codel is executed.
    pub(super) fn is_empty(&self) -> bool {
        self.parts.iter().all(Option::is_none)
    }

    /// Returns the shared objects by component of the system.
    pub(super) fn libraries(&self, prepared: &Prepared) -> TiVec<ComponentId, Option<Utf8PathBuf>> {
        let built = &prepared.built;
        let mut out = ti_vec![None; built.system.components.len()];
        for (&name, &component) in &built.components {
            out[component] = self.libraries.get(name).cloned().flatten();
        }
        out
    }

    /// Returns the parts of a system, with the inputs of requests.
    pub(super) fn parts(
        &self,
        prepared: &Prepared,
        names: &Names<'s>,
        settings: &Settings,
        inputs: &HashMap<String, Vec<u8>>,
    ) -> HostedComponents<'s> {
        let parts = self.parts.clone();
        HostedComponents::new(prepared, names, settings, parts, &|text| inputs.get(text).cloned())
    }
}

/// Returns a system that allows the behaviour of executed codels; on the real clock also their durations, and
/// requests from outside. Also returns the factor by which the times of the system have grown, and the first
/// client for requests from outside.
pub(super) fn opened(
    prepared: &Prepared,
    parts: &HostedComponents<'_>,
    real: bool,
    without_clients: bool,
) -> (Prepared, Ticks, Option<ClientId>) {
    let mut out = prepared.clone();
    let is_real = |codel: CodelId| parts.codel(codel).is_some();
    refine::open(&mut out, &is_real);
    if !real {
        return (out, 1, None);
    }
    let factor = refine::scale(&mut out);
    refine::release(&mut out, &is_real);
    if without_clients {
        out.built.system.clients.clear();
    }
    let first = refine::add_outside(&mut out);
    (out, factor, Some(first))
}

/// Parses `--input COMPONENT.SERVICE=JSON`. Returns the inputs as bytes.
pub(super) fn inputs(
    given: &[String],
    names: &Names<'_>,
) -> anyhow::Result<HashMap<String, Vec<u8>>> {
    let mut out = HashMap::new();
    for text in given {
        let (path, json) = text
            .split_once('=')
            .with_context(|| format!("`--input {text}`: write COMPONENT.SERVICE={{…}}"))?;
        let (path, json) = (path.trim(), json.trim());
        let (component, service) = path.split_once('.').unwrap_or((path, ""));
        let member = names.components.iter().find(|member| member.component.name == component);
        let Some(member) = member else {
            bail!("`--input {path}`: there is no component `{component}`");
        };
        let found = member.component.services.iter().find(|candidate| candidate.name == service);
        let Some(found) = found else {
            bail!("`--input {path}`: `{component}` has no service `{service}`");
        };
        let values = serde_json::from_str(json)
            .with_context(|| format!("`--input {path}`: the inputs are not a JSON object"))?;
        let bytes = Values::new(member.spec).inputs(found, &values);
        let bytes = bytes.map_err(|error| anyhow::anyhow!("`--input {path}`: {error}"))?;
        out.insert(path.to_owned(), bytes);
    }
    Ok(out)
}

/// Returns the unit of a clock in nanoseconds.
pub(super) fn nanos(prepared: &Prepared) -> u64 {
    let unit = prepared.built.system.unit * num_rational::Ratio::from_integer(1_000_000_000);
    u64::try_from(unit.to_integer()).unwrap_or(1).max(1)
}
