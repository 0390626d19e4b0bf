//! Diagnostics of open template files. No template is executed for them.

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::Cancellable;
use dotgen_codegen::template::check;
use dotgen_codegen::template::files::{self, Role, SCRIPT};

use super::language::LanguageFeatures;
use crate::workspace::snapshot::Snapshot;

/// The features of templates.
pub(crate) const FEATURES: LanguageFeatures =
    LanguageFeatures { diagnostics, ..LanguageFeatures::NONE };

/// Maximum number of scripts that a template requires.
const MAX_REQUIRED: usize = 32;

/// The diagnostics of an open file of a template.
fn diagnostics(snapshot: &Snapshot, file: &Utf8Path) -> Cancellable<Vec<Diagnostic>> {
    let Some(text) = snapshot.analysis.text(file)? else {
        return Ok(Vec::new());
    };
    let mut scripts = Vec::new();
    if let Some(home) = snapshot.templates.home(file)
        && let Some(main) = snapshot.analysis.text(&home.join(SCRIPT))?
    {
        for script in files::required(&home, &main).iter().take(MAX_REQUIRED) {
            scripts.extend(snapshot.analysis.text(script)?);
        }
        scripts.push(main);
    }
    // The settings of the user take precedence.
    let said = snapshot.open.get(file).is_some_and(|file| file.is_template_source);
    let role = files::role(file, &text, scripts.iter().map(|script| &**script));
    Ok(match role {
        Some(Role::Script) if !said => check::script(file, &text),
        Some(_) => check::source(file, &text),
        None if said => check::source(file, &text),
        None => Vec::new(),
    })
}
