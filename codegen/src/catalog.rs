//! The available templates, and their options, for a user to choose from.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::builtin;
use crate::disk::Disk;
use crate::template::discover::SearchPath;

/// The language of a template.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TemplateKind {
    /// Included in dotgen.
    Builtin,
    /// A `template.tcl`; needs Tcl.
    Tcl,
    /// A `template.toml` with MiniJinja texts.
    Minijinja,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TemplateInfo {
    /// The name on the command line.
    pub name: String,
    /// Its language.
    pub kind: TemplateKind,
    /// Its description, in one line; empty if unknown.
    pub about: String,
    /// Its folder; `None` for templates in the program.
    pub dir: Option<PathBuf>,
}

/// All templates in a search path, and those of dotgen, by name. A folder in the search path takes precedence
/// over a template of dotgen, unless the settings of a folder name the search path (`of_project`).
pub fn templates(disk: &dyn Disk, search: &SearchPath, of_project: bool) -> Vec<TemplateInfo> {
    let mut all: Vec<TemplateInfo> = Vec::new();
    let own = builtin::names();
    let found = search.list(disk).into_iter();
    for name in found.filter(|name| !of_project || !own.contains(&name.as_str())) {
        let manifest = search.find_manifest(disk, &name);
        let kind = match manifest {
            Some(_) => TemplateKind::Minijinja,
            None => TemplateKind::Tcl,
        };
        let about = manifest.as_ref().and_then(|dir| builtin::about_folder(disk, dir));
        all.push(TemplateInfo {
            dir: manifest.or_else(|| search.find(disk, &name).ok()),
            name,
            kind,
            about: about.unwrap_or_default(),
        });
    }
    for name in own {
        if all.iter().all(|template_info| template_info.name != name) {
            all.push(TemplateInfo {
                name: name.to_owned(),
                kind: TemplateKind::Builtin,
                about: builtin::about(disk, name),
                dir: None,
            });
        }
    }
    all.sort_by(|a, b| a.name.cmp(&b.name));
    all
}

/// An option of a template, from its usage text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TemplateOption {
    /// All its spellings, as `-l` and `--language`.
    pub flags: Vec<String>,
    /// The placeholder of its value, if it takes one.
    pub value: Option<String>,
    /// Its description.
    pub help: String,
}

/// Reads the options from a usage text: lines that begin with blanks and a dash, then the spellings with
/// commas or dots between them, a value after `=` or a blank, and the description after a tab or two blanks.
/// Options that only print help are omitted.
pub fn options(usage: &str) -> Vec<TemplateOption> {
    let mut all: Vec<TemplateOption> = Vec::new();
    for line in usage.lines() {
        let text = line.trim_start();
        let blanks = line.chars().take_while(|character| character.is_whitespace());
        let indent: usize = blanks.map(|blank| if blank == '\t' { 8 } else { 1 }).sum();
        if indent == 0 || text.is_empty() {
            continue;
        }
        if !text.starts_with('-') {
            // A long description continues on the next lines.
            if let Some(last) = all.last_mut()
                && indent > 8
            {
                format!("{} {text}", last.help).trim().clone_into(&mut last.help);
            }
            continue;
        }
        let parted = text.find('\t').into_iter().chain(text.find("  ")).min();
        let (spelled, help) = text.split_at(parted.unwrap_or(text.len()));
        let mut option =
            TemplateOption { flags: Vec::new(), value: None, help: help.trim().to_owned() };
        for part in spelled.split([',', '.', ' ']).filter(|part| !part.is_empty()) {
            if !part.starts_with('-') {
                option.value.get_or_insert_with(|| part.to_owned());
                continue;
            }
            let (flag, value) = match part.split_once('=') {
                Some((flag, value)) => (flag, Some(value)),
                None => (part, None),
            };
            option.flags.push(flag.to_owned());
            if let Some(value) = value {
                option.value = Some(value.trim_matches(['[', ']']).to_owned());
            }
        }
        let is_help = option.flags.iter().any(|text| text == "--help" || text == "-h");
        if !option.flags.is_empty() && !is_help {
            all.push(option);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_texts_tell_the_options() {
        let usage = "\nROS-based generation.\n\nSupported options:\n  -C, --directory=dir\toutput \
                     files in dir\n  -p, --preserve\tdo not overwrite\n\t\texisting files\n  -MF \
                     FILE             to FILE\n  -i\t\t\tmerge\n  -h. --help\t\tprint usage\n";
        let shown: Vec<String> = options(usage)
            .iter()
            .map(|option| format!("{} {:?} {}", option.flags.join("/"), option.value, option.help))
            .collect();
        assert_eq!(
            shown,
            [
                "-C/--directory Some(\"dir\") output files in dir",
                "-p/--preserve None do not overwrite existing files",
                "-MF Some(\"FILE\") to FILE",
                "-i None merge",
            ]
        );
    }
}
