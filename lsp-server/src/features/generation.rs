//! Generating files from an editor: runs of templates, and their results as edits.

pub(crate) mod choices;
pub(crate) mod edit;
pub(crate) mod plan;
pub(crate) mod run;

use serde_json::json;

use crate::protocol::types::{Command, Uri};

/// Lists the templates.
pub(crate) const TEMPLATES: &str = "dotgen.templates";
/// Lists the options of a template.
pub(crate) const OPTIONS: &str = "dotgen.templateOptions";
/// Runs a template and shows the files it would write.
pub(crate) const GENERATE: &str = "dotgen.generate";
/// Runs a template with the stored choices.
pub(crate) const REGENERATE: &str = "dotgen.regenerate";
/// Stores a choice.
pub(crate) const REMEMBER: &str = "dotgen.rememberTemplate";

/// All commands of this module.
pub(crate) const COMMANDS: [&str; 5] = [TEMPLATES, OPTIONS, GENERATE, REGENERATE, REMEMBER];

/// The actions on a component: the code action "Generate…", and "Regenerate" if a choice is stored.
pub(crate) fn actions(uri: &Uri, remembered: bool) -> Vec<(String, Command)> {
    let command = |title: &str, command: &str| {
        let argument = json!({ "uri": uri });
        let command = Command::new(title.to_owned(), command.to_owned(), Some(vec![argument]));
        (title.to_owned(), command)
    };
    let mut all = vec![command("Generate…", GENERATE)];
    if remembered {
        all.push(command("Regenerate", REGENERATE));
    }
    all
}
