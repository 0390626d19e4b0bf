//! The files with the codels of a component.
//!
//! The reference skeleton puts them in a folder `codels` next to the `.gen`, and lists them in
//! `codels/Makefile.am` as `lib…_SOURCES`. If that list names existing files, only the listed files are used.
//! Otherwise every C and C++ file of the folder is used.

use std::sync::{Arc, OnceLock};
use std::time::{Duration, SystemTime};

use camino::{Utf8Component, Utf8Path, Utf8PathBuf};
use dotgen_analysis::language::is_header;
use rustc_hash::FxHashMap;

use super::source::{Grammar, SourceIndex};

/// The location of codels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilesConfig {
    /// Folder of the codels, relative to the folder of the `.gen`.
    pub folder: Utf8PathBuf,
    /// Extensions of sources.
    pub extensions: Vec<String>,
    /// True if the lists in build files are used.
    pub makefile: bool,
}

impl Default for FilesConfig {
    fn default() -> FilesConfig {
        FilesConfig {
            folder: "codels".into(),
            extensions: ["c", "cc", "cpp", "cxx"].map(String::from).to_vec(),
            makefile: true,
        }
    }
}

impl FilesConfig {
    /// Folder of the codels of a `.gen`.
    pub fn folder_of(&self, specification: &Utf8Path) -> Utf8PathBuf {
        let mut folder = specification.parent().unwrap_or(Utf8Path::new("")).to_owned();
        // `..` is resolved in the text of the path, without links, as in other paths of files.
        for part in self.folder.components() {
            match part {
                Utf8Component::CurDir => {}
                Utf8Component::ParentDir if folder.file_name().is_some() => {
                    folder.pop();
                }
                part => folder.push(part),
            }
        }
        folder
    }

    /// True if the extension is one of sources.
    pub fn is_source(&self, path: &Utf8Path) -> bool {
        let extension = path.extension().unwrap_or_default();
        self.extensions.iter().any(|name| name == extension)
    }
}

/// Files of a codels folder by role, relative to it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CodelFiles {
    /// Sources, which may contain codels.
    pub sources: Vec<Utf8PathBuf>,
    /// Headers, which are read for the names they declare.
    pub headers: Vec<Utf8PathBuf>,
    /// Sources that the build files list and that do not exist.
    pub absent: Vec<Utf8PathBuf>,
    /// True if the lists in build files are used.
    pub listed: bool,
}

/// Sorts a listing (paths relative to the codels folder, subfolders included) into roles. `makefile` is the
/// text of its `Makefile.am`.
pub fn select(listing: &[Utf8PathBuf], makefile: Option<&str>, config: &FilesConfig) -> CodelFiles {
    let mut all: Vec<Utf8PathBuf> = listing.to_vec();
    all.sort();
    all.dedup();
    let headers = all.iter().filter(|path| is_header(path));
    let mut out = CodelFiles { headers: headers.cloned().collect(), ..CodelFiles::default() };
    let listed = makefile.filter(|_| config.makefile).map(makefile_sources);
    let listed = listed.unwrap_or_default();
    let listed = listed.into_iter().filter(|source| config.is_source(source));
    let (present, absent): (Vec<_>, Vec<_>) = listed.partition(|source| all.contains(source));
    if present.is_empty() {
        out.sources = all.into_iter().filter(|listing| config.is_source(listing)).collect();
    } else {
        out.sources = present;
        out.absent = absent;
        out.listed = true;
    }
    out
}

/// Paths in the `*_SOURCES` variables of a `Makefile.am`, relative to its folder. Paths that contain a
/// variable are skipped.
pub(crate) fn makefile_sources(text: &str) -> Vec<Utf8PathBuf> {
    let mut out: Vec<Utf8PathBuf> = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let mut logical = line.to_owned();
        while logical.ends_with('\\') {
            logical.pop();
            match lines.next() {
                Some(next) => {
                    logical.push(' ');
                    logical.push_str(next);
                }
                None => break,
            }
        }
        let logical = logical.split('#').next().unwrap_or_default();
        let Some((variable, value)) = logical.split_once('=') else {
            continue;
        };
        let variable = variable.trim_end_matches(['+', ':', ' ', '\t']);
        // The build generates BUILT_SOURCES, most of them headers.
        if !variable.ends_with("_SOURCES") || variable == "BUILT_SOURCES" {
            continue;
        }
        for word in value.split_whitespace() {
            let word = ["$(srcdir)/", "${srcdir}/", "./"]
                .iter()
                .find_map(|text| word.strip_prefix(text))
                .unwrap_or(word);
            if !word.contains('$') && !out.iter().any(|path| path == word) {
                out.push(word.into());
            }
        }
    }
    out
}

/// One file with its index.
#[derive(Debug, Clone)]
pub struct IndexedFile {
    pub path: Utf8PathBuf,
    pub text: Arc<str>,
    /// The grammar of its text.
    pub grammar: Grammar,
    index: Arc<OnceLock<SourceIndex>>,
}

impl IndexedFile {
    /// Returns the components whose types the file includes.
    fn included_types(&self) -> impl Iterator<Item = &str> {
        self.index().includes.iter().filter_map(|include| {
            let file = include.path.rsplit('/').next()?;
            let of = |end: &str| file.strip_suffix(end);
            of("_c_types.h").or_else(|| of("_cxx_types.h"))
        })
    }

    /// The declarations of the text. It is parsed at the first call.
    pub fn index(&self) -> &SourceIndex {
        self.index.get_or_init(|| SourceIndex::new(&self.text, self.grammar))
    }

    /// True for the same text of the same file, parsed once for both.
    pub fn is(&self, other: &IndexedFile) -> bool {
        Arc::ptr_eq(&self.index, &other.index)
    }

    /// A text of a file; with `cxx`, headers are read as C++.
    pub fn new(path: Utf8PathBuf, text: Arc<str>, cxx: bool) -> IndexedFile {
        let grammar = match Grammar::of_path(path.as_str()) {
            Some(Grammar::C) if path.extension() == Some("c") || !cxx => Grammar::C,
            _ => Grammar::Cxx,
        };
        IndexedFile { path, text, grammar, index: Arc::default() }
    }
}

/// Number of texts of a file whose indexes are kept: the present one, and those of edits that are tried.
const KEPT_TEXTS: usize = 3;

/// Indexes of texts: each is parsed once, while it is one of the last texts of its file.
#[derive(Debug, Default)]
pub struct Indexes {
    /// By path and grammar, the last used text last.
    files: FxHashMap<(Utf8PathBuf, bool), Vec<IndexedFile>>,
}

impl Indexes {
    /// The index of a text; the arguments are those of [`IndexedFile::new`].
    pub fn get(&mut self, path: Utf8PathBuf, text: Arc<str>, cxx: bool) -> IndexedFile {
        let known = self.files.entry((path.clone(), cxx)).or_default();
        let is_same = |file: &IndexedFile| Arc::ptr_eq(&file.text, &text) || file.text == text;
        let file = match known.iter().rposition(is_same) {
            Some(at) => known.remove(at),
            None => IndexedFile::new(path, text, cxx),
        };
        known.push(file.clone());
        if known.len() > KEPT_TEXTS {
            known.remove(0);
        }
        file
    }
}

/// The indexed files of one codels folder.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    /// The codels folder.
    pub folder: Utf8PathBuf,
    /// True if the folder exists.
    pub exists: bool,
    /// Sources, which may contain codels.
    pub sources: Vec<IndexedFile>,
    /// Headers, which are read for the names they declare.
    pub headers: Vec<IndexedFile>,
    /// `Makefile.am` of the folder with its text, if its list of sources is used.
    pub makefile: Option<(Utf8PathBuf, Arc<str>)>,
    /// True if a source cannot be read, or if the build files list one that does not exist: existing
    /// functions may then be missing here.
    pub incomplete: bool,
    /// The errors of files and folders that cannot be read.
    pub unreadable: Vec<String>,
}

/// Access to the files of a codels folder.
pub trait Files {
    /// Text of a file; `None` if it cannot be read.
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>>;
    /// Files below a folder, subfolders included, relative to it; `None` if the folder does not exist.
    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>>;
    /// The errors of folders that cannot be listed: the folder itself, or below it.
    fn unlisted(&self, _folder: &Utf8Path) -> Vec<String> {
        Vec::new()
    }
    /// The time of the last change of a file; `None` if it is unknown.
    fn changed(&self, _path: &Utf8Path) -> Option<ModificationTime> {
        None
    }
}

/// The time of the last change of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModificationTime {
    /// The time of its last commit, or of its time stamp if it differs from that commit.
    At(SystemTime),
    /// The file is open in an editor, with unsaved changes.
    Unsaved,
}

impl ModificationTime {
    /// Files that one command of an editor saves get time stamps that differ by less, in any order.
    const TOGETHER: Duration = Duration::from_secs(10);

    /// True if a change was made after another one, and not together with it.
    pub fn is_after(self, other: ModificationTime) -> bool {
        match (self, other) {
            (ModificationTime::At(this), ModificationTime::At(other)) => {
                this.duration_since(other).is_ok_and(|between| between >= Self::TOGETHER)
            }
            (this, other) => this == ModificationTime::Unsaved && this != other,
        }
    }
}

impl Sources {
    /// Reads the codels folder of a `.gen`.
    pub fn load(specification: &Utf8Path, config: &FilesConfig, files: &dyn Files) -> Sources {
        Sources::load_with(specification, config, files, &mut IndexedFile::new)
    }

    /// True if some source contains a name, or one that ends with it.
    pub fn mention(&self, name: &str) -> bool {
        let goes_on = |character: char| character.is_alphanumeric() || character == '_';
        self.all().any(|file| {
            let mut found = file.text.match_indices(name);
            found.any(|(at, _)| !file.text[at + name.len()..].starts_with(goes_on))
        })
    }

    /// Returns the sources that may be of these components. A folder that several specifications share has
    /// sources that include the types of other components (`…_c_types.h`) and those of none of these. If no
    /// source includes theirs, the component may have another name now, and all are returned.
    pub(super) fn of_components(&self, components: &[&str]) -> impl Iterator<Item = &IndexedFile> {
        let own = |file: &IndexedFile| file.included_types().any(|of| components.contains(&of));
        let any = self.sources.iter().any(own);
        self.sources
            .iter()
            .filter(move |source| !any || own(source) || source.included_types().next().is_none())
    }

    /// As [`Sources::load`], with a function that may reuse the indexes of texts (its arguments are those of
    /// [`IndexedFile::new`]).
    pub fn load_with(
        specification: &Utf8Path,
        config: &FilesConfig,
        files: &dyn Files,
        index: &mut dyn FnMut(Utf8PathBuf, Arc<str>, bool) -> IndexedFile,
    ) -> Sources {
        let folder = config.folder_of(specification);
        let listing = files.list(&folder);
        let exists = listing.is_some();
        let makefile_path = folder.join("Makefile.am");
        let makefile = files.read(&makefile_path);
        let selected = select(&listing.unwrap_or_default(), makefile.as_deref(), config);
        let cxx = selected.sources.iter().any(|source| source.extension() != Some("c"));
        let mut unreadable = files.unlisted(&folder);
        let mut incomplete = !selected.absent.is_empty() || !unreadable.is_empty();
        let mut load = |paths: Vec<Utf8PathBuf>| {
            let mut out = Vec::new();
            for path in paths {
                let path = folder.join(path);
                if let Some(text) = files.read(&path) {
                    out.push(index(path, text, cxx));
                } else {
                    incomplete = true;
                    unreadable.push(format!("cannot read `{path}` as UTF-8 text"));
                }
            }
            out
        };
        let sources = load(selected.sources);
        let headers = load(selected.headers);
        Sources {
            folder,
            exists,
            sources,
            headers,
            makefile: makefile
                .filter(|_| selected.listed)
                .map(|makefile| (makefile_path, makefile)),
            incomplete,
            unreadable,
        }
    }

    /// True if a function returns an event in the spelling of C++.
    pub(crate) fn uses_cxx(&self) -> bool {
        let mut functions = self.sources.iter().flat_map(|source| &source.index().functions);
        functions.any(|function| function.result.base == "genom::event")
    }

    /// Sources and headers.
    pub fn all(&self) -> impl Iterator<Item = &IndexedFile> {
        self.sources.iter().chain(&self.headers)
    }

    pub fn file(&self, path: &Utf8Path) -> Option<&IndexedFile> {
        self.all().find(|file| file.path == path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(all: &[&str]) -> Vec<Utf8PathBuf> {
        all.iter().map(Utf8PathBuf::from).collect()
    }

    #[test]
    fn sources_of_a_makefile() {
        let text = "lib_LTLIBRARIES = liba.la\n\
            liba_la_SOURCES  =\ta_c_types.h a.c # b.c\n\
            liba_la_SOURCES += \\\n\tc.cc \\\n\t$(srcdir)/sub/d.cpp ${X}/e.c\n\
            BUILT_SOURCES= f.c\n";
        assert_eq!(makefile_sources(text), paths(&["a_c_types.h", "a.c", "c.cc", "sub/d.cpp"]));
    }

    #[test]
    fn the_build_file_is_believed_when_its_files_are_there() {
        let listing = paths(&["b.c", "a.c", "old.c", "x.h", "README"]);
        let config = FilesConfig::default();
        let file = select(&listing, Some("l_SOURCES = a.c b.c gone.c"), &config);
        assert_eq!(file.sources, paths(&["a.c", "b.c"]));
        assert_eq!(file.absent, paths(&["gone.c"]));
        assert_eq!(file.headers, paths(&["x.h"]));
        let file = select(&listing, Some("l_SOURCES = gone.c"), &config);
        assert_eq!(file.sources, paths(&["a.c", "b.c", "old.c"]));
        let file = select(&listing, None, &config);
        assert_eq!(file.sources, paths(&["a.c", "b.c", "old.c"]));
    }
}
