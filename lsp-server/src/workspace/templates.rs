//! The directories of templates, and the documents that belong to a template.

use std::collections::{BTreeMap, BTreeSet};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::FileContent;
use dotgen_analysis::language;
use dotgen_codegen::template::files::{self, SCRIPT};

use dotgen_platform::files::vfs;

/// The language id with which clients mark a source of a template, wherever it is.
pub(crate) const LANGUAGE: &str = "genom3-template";

/// The templates of the workspace: the directory of each, with the files elsewhere that it names.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Templates(BTreeMap<Utf8PathBuf, BTreeSet<Utf8PathBuf>>);

impl Templates {
    /// The templates of some scripts.
    pub(crate) fn new(scripts: impl IntoIterator<Item = Utf8PathBuf>) -> Templates {
        let mut templates = Templates::default();
        for script in scripts {
            templates.add(&script);
        }
        templates
    }

    /// Reads a script again. Returns true if the templates have changed.
    pub(crate) fn add(&mut self, script: &Utf8Path) -> bool {
        let (Some(directory), FileContent::Text(text)) = (script.parent(), vfs::read(script))
        else {
            return self.remove(script);
        };
        let outside = files::outside(directory, &text);
        let outside: BTreeSet<_> = outside.into_iter().filter(|path| path.is_file()).collect();
        let before = self.0.insert(directory.to_owned(), outside.clone());
        before != Some(outside)
    }

    /// Removes a script. Returns true if it was known.
    pub(crate) fn remove(&mut self, script: &Utf8Path) -> bool {
        script.parent().is_some_and(|parent| self.0.remove(parent).is_some())
    }

    /// Keeps the templates in the directories for which `keep` is true.
    pub(crate) fn retain(&mut self, keep: impl Fn(&Utf8Path) -> bool) {
        self.0.retain(|path, _| keep(path));
    }

    /// The template that a file belongs to: the template in a directory above it, or the one that names the
    /// file.
    pub(crate) fn home(&self, file: &Utf8Path) -> Option<Utf8PathBuf> {
        let mut around = file.ancestors().skip(1);
        let around = around
            .find(|ancestor| self.0.contains_key(*ancestor) || ancestor.join(SCRIPT).is_file());
        let around = around.map(Utf8Path::to_owned);
        around.or_else(|| {
            let mut all = self.0.iter();
            let naming = all.find(|(_, outside)| outside.contains(file));
            naming.map(|naming| naming.0.clone())
        })
    }

    /// Globs for all files of the templates.
    pub(crate) fn globs(&self) -> BTreeSet<String> {
        // Characters with a meaning in globs are replaced by `?`, which matches any character.
        let plain = |path: &Utf8Path| path.as_str().replace(['*', '?', '{', '}', '[', ']'], "?");
        let below = self.0.keys().map(|key| format!("{}/**", plain(key)));
        let outside = self.0.values().flatten().map(|path| plain(path));
        below.chain(outside).collect()
    }
}

/// True if a document belongs to a template by its place. False for specifications and scenarios.
pub(crate) fn is_template(templates: &Templates, file: &Utf8Path) -> bool {
    !language::is_specification(file)
        && !language::is_scenario(file)
        && templates.home(file).is_some()
}
