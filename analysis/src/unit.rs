//! Translation units: the files that a root includes, each with the macros defined at its entry.
//!
//! The [`walk`] follows the includes. Every visit then gets a [`FileKey`]: the file, its kind of text, its
//! entry environment and the effects of its includes, both restricted to the macros that the file mentions.
//! Units in which a file looks the same share its key, and so its tree and item tree.

pub(crate) mod walk;

use std::{
    hash::{Hash, Hasher},
    mem,
    sync::Arc,
};

use camino::Utf8PathBuf;
use dotgen_syntax::{
    Fragment, Parse, TextSize,
    directive::{Define, DirectiveKind},
    finding::preprocessing::Preprocessing,
    parse,
    preproc::{
        self, Element, Host, IncludeError, IncludeRequest, MacroEnv, MentionedWords, Preprocessed,
        RequiredPackages, preprocess,
    },
};
use rustc_hash::{FxHashMap, FxHashSet};
use smol_str::SmolStr;
use typed_index_collections::{TiSlice, TiVec};

use crate::{
    base::{Db, SourceFile, lexed},
    item_tree::{
        ItemTree,
        lower::{self, Lowered, PtrRanges},
    },
    model::VisitId,
    parallel,
};
use walk::WalkId;
pub(crate) use walk::{STANDINS, is_standin, walk_unit};

/// A translation unit: the inputs in order, as one wrapper text that includes them.
#[salsa::interned(debug)]
pub(crate) struct UnitKey<'db> {
    /// Roots, in order.
    pub(crate) inputs: Vec<SourceFile>,
    /// Searched before those of the workspace.
    pub(crate) include_dirs: Vec<Utf8PathBuf>,
    /// Defined after those of the workspace.
    pub(crate) defines: Vec<(SmolStr, SmolStr)>,
}

/// One file in one context.
#[salsa::interned(debug)]
pub(crate) struct FileKey<'db> {
    #[returns(copy)]
    pub(crate) file: SourceFile,
    /// The kind of text at the place of its inclusion.
    #[returns(copy)]
    pub(crate) fragment: Fragment,
    /// Macros at its start.
    pub(crate) entry: MacroEnv,
    /// The effects of its directives that leave the file, in order.
    pub(crate) outcomes: Vec<DirectiveEffect>,
}

/// The effect of a directive that leaves the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum DirectiveEffect {
    /// An active `#include`: the environment after it, or the reason why it was not followed.
    Include(Result<MacroEnv, IncludeError>),
    /// An active `#pragma requires`: the environment after it, or the message of the package tool.
    Requires(Result<RequiredPackages, String>),
}

impl Hash for DirectiveEffect {
    /// Failures are distinguished only by comparison.
    fn hash<H: Hasher>(&self, state: &mut H) {
        mem::discriminant(self).hash(state);
        match self {
            DirectiveEffect::Include(result) => result.as_ref().ok().hash(state),
            DirectiveEffect::Requires(result) => result.as_ref().ok().hash(state),
        }
    }
}

/// The visits of a unit, ready to parse.
#[derive(Debug, Clone, PartialEq, Eq, salsa::SalsaValue)]
pub(crate) struct Visits<'db> {
    visits: Vec<Visit<'db>>,
}

impl<'db> Visits<'db> {
    pub(crate) fn all(&self) -> &TiSlice<WalkId, Visit<'db>> {
        TiSlice::from_ref(&self.visits)
    }

    /// A visit as the elaborator numbers it; `None` for the wrapper.
    pub(crate) fn of(&self, id: VisitId) -> Option<&Visit<'db>> {
        self.visits.get(usize::from(id).checked_sub(1)?)
    }
}

/// One inclusion of one file. See `WalkVisit`.
#[derive(Debug, Clone, PartialEq, Eq, salsa::SalsaValue)]
pub(crate) struct Visit<'db> {
    pub(crate) key: FileKey<'db>,
    pub(crate) includes: Vec<Option<WalkId>>,
    pub(crate) includer: Option<(WalkId, usize)>,
    /// True if every include on the path is at a place that allows declarations.
    pub(crate) reached: bool,
    /// Equal for equal files.
    pub(crate) file_number: u32,
}

pub(crate) fn unit_of_root(db: &dyn Db, root: SourceFile) -> UnitKey<'_> {
    UnitKey::new(db, vec![root], Vec::new(), Vec::new())
}

/// Identifiers that occur in a file.
#[salsa::tracked]
pub(crate) fn mentioned(db: &dyn Db, file: SourceFile) -> MentionedWords {
    let lexed = lexed(db, file);
    preproc::mentioned(&lexed.raw, file.text(db))
}

#[salsa::tracked]
pub(crate) fn visits<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Visits<'db> {
    let walk = walk_unit(db, unit);
    let mut numbers: FxHashMap<SourceFile, u32> = FxHashMap::default();
    let mut out: TiVec<WalkId, Visit<'db>> = TiVec::with_capacity(walk.visits.len());
    for visit in &walk.visits {
        // An includer comes before its includes.
        let (fragment, reached) = match visit.includer {
            None => (Fragment::Specification, true),
            Some((by, ordinal)) => {
                let by = out.get(by);
                let fragment =
                    by.and_then(|by| include_fragments(db, by.key).get(ordinal).copied()).flatten();
                (
                    fragment.unwrap_or(Fragment::Specification),
                    fragment.is_some() && by.is_some_and(|by| by.reached),
                )
            }
        };
        let names = mentioned(db, visit.file);
        let restrict = |env: &MacroEnv| env.restrict(names);
        let outcomes: Vec<DirectiveEffect> = visit
            .outcomes
            .iter()
            .map(|outcome| match outcome {
                DirectiveEffect::Include(include) => {
                    DirectiveEffect::Include(include.as_ref().map(restrict).map_err(Clone::clone))
                }
                DirectiveEffect::Requires(requirement) => {
                    let restrict = |packages: &RequiredPackages| RequiredPackages {
                        env: restrict(&packages.env),
                        own: packages.own.clone(),
                    };
                    DirectiveEffect::Requires(
                        requirement.as_ref().map(restrict).map_err(Clone::clone),
                    )
                }
            })
            .collect();
        let next = numbers.len() as u32;
        out.push(Visit {
            key: FileKey::new(db, visit.file, fragment, restrict(&visit.entry), outcomes),
            includes: visit.includes.clone(),
            includer: visit.includer,
            reached,
            file_number: *numbers.entry(visit.file).or_insert(next),
        });
    }
    Visits { visits: out.raw }
}

/// The `#define`s of a file, active or not, by ordinal.
#[salsa::tracked]
pub(crate) fn defines(db: &dyn Db, file: SourceFile) -> Arc<Vec<Define>> {
    let name = SmolStr::new(file.path(db).as_str());
    let raw = &lexed(db, file).raw;
    let pre = preprocess(&name, file.text(db), raw, MacroEnv::empty(), &mut preproc::NoIncludes);
    let defines = pre.directives.into_iter().filter_map(|directive| match directive.kind {
        DirectiveKind::Define(define) => Some(define),
        _ => None,
    });
    Arc::new(defines.collect())
}

/// One `#define` of a file.
pub(crate) fn define(db: &dyn Db, file: SourceFile, ordinal: u32) -> Option<Define> {
    let all = defines(db, file);
    all.iter().find(|define| define.ordinal == ordinal).cloned()
}

/// For each file, the roots in whose units it is included, in their order; a root is not in its own list.
#[salsa::tracked]
fn includers(db: &dyn Db) -> FxHashMap<SourceFile, Vec<SourceFile>> {
    let mut out: FxHashMap<SourceFile, Vec<SourceFile>> = FxHashMap::default();
    for path in db.workspace().roots(db) {
        let root = db.file(path);
        for visit in &walk_unit(db, unit_of_root(db, root)).visits {
            let roots = out.entry(visit.file).or_default();
            if visit.file != root && roots.last() != Some(&root) {
                roots.push(root);
            }
        }
    }
    out
}

/// Reads the includes of every root in parallel, so that [`roots_of`] answers without delay. Returns true if
/// a root is included by another one, and so does not count for itself.
pub(crate) fn index(db: &dyn Db) -> bool {
    let roots = db.workspace().roots(db);
    parallel::over(db, roots, |db, path| {
        walk_unit(db, unit_of_root(db, db.file(path)));
    });
    let included = includers(db);
    let mut roots = roots.iter();
    roots.any(|root| included.get(&db.file(root)).is_some_and(|includer| !includer.is_empty()))
}

/// The roots of the units that contain a file: other roots that include it, or, if there are none, the file
/// itself. Never empty; the one that serves the file comes first.
#[salsa::tracked(returns(deref))]
pub(crate) fn roots_of(db: &dyn Db, file: SourceFile) -> Vec<SourceFile> {
    let workspace = db.workspace();
    if !workspace.indexed(db) && workspace.roots(db).contains(file.path(db)) {
        return vec![file];
    }
    let mut roots = includers(db).get(&file).cloned().unwrap_or_default();
    if roots.is_empty() {
        roots.push(file);
    }
    let chosen = workspace.chosen(db).iter().find(|chosen| chosen.0 == *file.path(db));
    // The choice of the user counts more than the most recently edited document.
    for preferred in [workspace.active(db).as_ref(), chosen.map(|chosen| &chosen.1)] {
        let position = |path| roots.iter().position(|root| root.path(db) == path);
        if let Some(at) = preferred.and_then(position) {
            roots[..=at].rotate_right(1);
        }
    }
    roots
}

/// The files of a unit, in order of first visit.
pub(crate) fn files<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Vec<SourceFile> {
    let mut seen = FxHashSet::default();
    let visits = walk_unit(db, unit).visits.iter();
    visits.map(|walk_visit| walk_visit.file).filter(|&file| seen.insert(file)).collect()
}

/// The unit that serves a file.
pub(crate) fn serving_unit(db: &dyn Db, file: SourceFile) -> UnitKey<'_> {
    unit_of_root(db, roots_of(db, file).first().copied().unwrap_or(file))
}

/// The visit of a file that serves the editor: the first one with declarations, otherwise the first.
pub(crate) fn serving_visit<'db>(
    db: &'db dyn Db,
    unit: UnitKey<'db>,
    file: SourceFile,
) -> Option<(WalkId, FileKey<'db>)> {
    let of_file = |visit: &(WalkId, &Visit<'db>)| visit.1.key.file(db) == file;
    let all = visits(db, unit).all();
    let mut of_file = all.iter_enumerated().filter(of_file).peekable();
    let first = of_file.peek().map(|(i, file)| (*i, file.key));
    of_file
        .find(|(_, visit)| visit.reached && !item_tree(db, visit.key).items.is_empty())
        .map(|(i, file)| (i, file.key))
        .or(first)
}

/// The text of a file, preprocessed and parsed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ParsedText {
    parse: Parse,
    /// Only the directives and macro calls of the elements are kept.
    pre: Preprocessed,
}

/// Preprocesses a file, with every element of it.
pub(crate) fn preprocess_whole(db: &dyn Db, key: FileKey<'_>) -> Preprocessed {
    let file = key.file(db);
    let name = SmolStr::new(file.path(db).as_str());
    let mut replay = Replay::new(key.outcomes(db));
    let raw = &lexed(db, file).raw;
    let entry = key.entry(db).clone();
    preprocess(&name, file.text(db), raw, entry, &mut replay)
}

/// Preprocesses and parses a file.
#[salsa::tracked(lru = 24)]
fn parse_text<'db>(db: &'db dyn Db, key: FileKey<'db>) -> ParsedText {
    let file = key.file(db);
    let mut pre = preprocess_whole(db, key);
    let raw = &lexed(db, file).raw;
    let parse = parse(file.text(db), raw, &pre, key.fragment(db));
    pre.elements
        .retain(|element| matches!(element, Element::Directive { .. } | Element::Call { .. }));
    pre.elements.shrink_to_fit();
    ParsedText { parse, pre }
}

/// A file, preprocessed.
pub(crate) fn preprocessed<'db>(db: &'db dyn Db, key: FileKey<'db>) -> &'db Preprocessed {
    &parse_text(db, key).pre
}

/// The syntax tree of a file.
pub(crate) fn parsed<'db>(db: &'db dyn Db, key: FileKey<'db>) -> &'db Parse {
    &parse_text(db, key).parse
}

/// The item tree of a file together with the places of its nodes. The frequently used parts are in the
/// queries below, so that neither this result nor the syntax tree is kept for files that are not edited.
#[salsa::tracked(lru = 24)]
pub(crate) fn lowered<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Lowered {
    lower::lower(
        parsed(db, key),
        key.fragment(db),
        &lexed(db, key.file(db)).raw,
        preprocessed(db, key),
    )
}

/// The item tree of a file. Stays equal when only places change.
#[salsa::tracked(lru = 0)]
pub(crate) fn item_tree<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Arc<ItemTree> {
    lowered(db, key).tree.clone()
}

/// The places of the nodes of the item tree.
#[salsa::tracked(lru = 0)]
pub(crate) fn ranges<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Arc<PtrRanges> {
    lowered(db, key).ranges.clone()
}

/// Sets the maximum number of files with cached results.
pub(crate) fn keep(db: &mut dyn Db, count: usize) {
    item_tree::set_lru_capacity(db, count);
    ranges::set_lru_capacity(db, count);
}

/// The facts about a file's text that each report on a unit reads. They stay equal under most edits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TextFacts {
    /// True if some active include is in the middle of a declaration.
    pub(crate) misplaced_includes: bool,
    /// True if an include does not name a file.
    pub(crate) bad_include: bool,
    /// Offset from which strings and code are exchanged: see [`Parse::inside_out`].
    pub(crate) inside_out: Option<TextSize>,
    /// True if some token comes out of a macro.
    pub(crate) has_expansions: bool,
}

/// See [`TextFacts`].
#[salsa::tracked(returns(copy))]
pub(crate) fn text_facts<'db>(db: &'db dyn Db, key: FileKey<'db>) -> TextFacts {
    let (parse, errors) = (parsed(db, key), &preprocessed(db, key).errors);
    TextFacts {
        misplaced_includes: !lowered(db, key).misplaced.is_empty(),
        bad_include: errors.iter().any(|error| {
            matches!(error.kind, Preprocessing::IncludeWithoutFile | Preprocessing::IncludeWithMore)
        }),
        inside_out: parse.inside_out,
        has_expansions: !parse.expansion.is_empty(),
    }
}

/// The kind of text of each active include of a file; `None` if no declaration is allowed at its place.
#[salsa::tracked(returns(deref))]
pub(crate) fn include_fragments<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Vec<Option<Fragment>> {
    lowered(db, key).fragments.clone()
}

/// A host that repeats the results of the walk.
struct Replay<'a> {
    includes: Vec<&'a Result<MacroEnv, IncludeError>>,
    requires: std::vec::IntoIter<&'a Result<RequiredPackages, String>>,
}

impl<'a> Replay<'a> {
    fn new(outcomes: &'a [DirectiveEffect]) -> Replay<'a> {
        let (mut includes, mut requires) = (Vec::new(), Vec::new());
        for outcome in outcomes {
            match outcome {
                DirectiveEffect::Include(include) => includes.push(include),
                DirectiveEffect::Requires(requirement) => requires.push(requirement),
            }
        }
        Replay { includes, requires: requires.into_iter() }
    }
}

impl Host for Replay<'_> {
    fn include(
        &mut self,
        request: &IncludeRequest,
        env: &MacroEnv,
    ) -> Result<MacroEnv, IncludeError> {
        let recorded = self.includes.get(request.ordinal as usize);
        recorded.map_or_else(|| Ok(env.clone()), |&include| include.clone())
    }

    fn requires(&mut self, _: &[SmolStr], env: &MacroEnv) -> Result<RequiredPackages, String> {
        let recorded = self.requires.next();
        recorded.map_or_else(|| Ok(env.clone().into()), Clone::clone)
    }
}
