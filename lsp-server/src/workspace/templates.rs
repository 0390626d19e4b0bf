//! Where templates are, and which documents belong to one.

use std::collections::{BTreeMap, BTreeSet};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::FileContent;
use dotgen_codegen::template::files::{self, SCRIPT};

use crate::files::vfs;

/// What clients call a document that is a source of a template wherever it is.
pub(crate) const LANGUAGE: &str = "genom3-template";

/// The templates of the workspace: the directory of each, with the files elsewhere that it names.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Templates(BTreeMap<Utf8PathBuf, BTreeSet<Utf8PathBuf>>);

impl Templates {
    /// From the scripts of all templates.
    pub(crate) fn new(scripts: impl IntoIterator<Item = Utf8PathBuf>) -> Templates {
        let mut templates = Templates::default();
        for script in scripts {
            templates.add(&script);
        }
        templates
    }

    /// Reads a script again; whether anything is different now.
    pub(crate) fn add(&mut self, script: &Utf8Path) -> bool {
        let (Some(directory), FileContent::Text(text)) = (script.parent(), vfs::read(script))
        else {
            return self.remove(script);
        };
        let outside = files::outside(directory, &text);
        let outside: BTreeSet<_> = outside.into_iter().filter(|it| it.is_file()).collect();
        let before = self.0.insert(directory.to_owned(), outside.clone());
        before != Some(outside)
    }

    /// A script has gone; whether it was known.
    pub(crate) fn remove(&mut self, script: &Utf8Path) -> bool {
        script
            .parent()
            .is_some_and(|it| self.0.remove(it).is_some())
    }

    /// Forgets what is below directories.
    pub(crate) fn retain(&mut self, keep: impl Fn(&Utf8Path) -> bool) {
        self.0.retain(|it, _| keep(it));
    }

    /// The template that a file belongs to by its place: around it, or naming it.
    pub(crate) fn home(&self, file: &Utf8Path) -> Option<Utf8PathBuf> {
        let mut around = file.ancestors().skip(1);
        let around = around.find(|it| self.0.contains_key(*it) || it.join(SCRIPT).is_file());
        let around = around.map(Utf8Path::to_owned);
        around.or_else(|| {
            let mut all = self.0.iter();
            let naming = all.find(|(_, outside)| outside.contains(file));
            naming.map(|it| it.0.clone())
        })
    }

    /// Globs for all files of the templates.
    pub(crate) fn globs(&self) -> BTreeSet<String> {
        // What has a meaning in a glob stands for any character.
        let plain = |it: &Utf8Path| it.as_str().replace(['*', '?', '{', '}', '[', ']'], "?");
        let below = self.0.keys().map(|it| format!("{}/**", plain(it)));
        let outside = self.0.values().flatten().map(|it| plain(it));
        below.chain(outside).collect()
    }
}

/// Whether a document belongs to a template by its place. Specifications and scenarios do not.
pub(crate) fn is_template(templates: &Templates, file: &Utf8Path) -> bool {
    !matches!(file.extension(), Some("gen" | "scn")) && templates.home(file).is_some()
}
