//! The walk over the includes of a unit, in order, with its own stack.
//!
//! It reads only the directive lines of each file, so that edits in the text between them do not repeat it.

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::{
    SyntaxKind,
    lexer::{RawTokens, lex},
    preproc::{Host, IncludeError, IncludeRequest, MacroEnv, RequiredPackages, preprocess},
};
use smol_str::SmolStr;
use typed_index_collections::TiVec;

use super::{DirectiveEffect, UnitKey};
use crate::{
    base::{Db, FileStatus, SourceFile, lexed, normalize},
    requirement,
};

const PRAGMA: &str = "_Pragma";

/// Maximum number of files that are open at the same time (language reference, 2.3).
const MAX_DEPTH: usize = 100;

/// The folder of stand-ins for interfaces, relative to the folder of the root: searched last.
pub(crate) const STANDINS: &str = ".dotgen/standins";

/// Returns true if a file is in the folder of stand-ins.
pub(crate) fn is_standin(path: &Utf8Path) -> bool {
    path.ancestors().any(|ancestor| ancestor.ends_with(STANDINS))
}

/// Maximum number of visits of a unit; far beyond any real specification.
const MAX_VISITS: usize = 4_000;

crate::model::ids::ids! {
    /// A visit of a unit: an index into [`Walk::visits`] and [`Visits::all`](super::Visits::all).
    pub(crate) WalkId
}

/// The result of walking a unit.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Walk {
    /// In order of inclusion; the inputs of the unit have no includer.
    pub(crate) visits: TiVec<WalkId, WalkVisit>,
    /// The search path at the end, in order: it only grows.
    search: Vec<Utf8PathBuf>,
}

impl Walk {
    /// The directories in which the file of an active include was searched, in order. The folder of
    /// stand-ins, which comes last, is not among them.
    pub(crate) fn places(
        &self,
        db: &dyn Db,
        visit: WalkId,
        ordinal: usize,
        request: &IncludeRequest,
    ) -> Vec<Utf8PathBuf> {
        let Some(visit) = self.visits.get(visit) else {
            return Vec::new();
        };
        let reach = visit.searched.get(ordinal).copied().unwrap_or_default();
        let search = self.search.get(..reach).unwrap_or(&self.search);
        let places = places(db, search, request, visit.file);
        places.into_iter().map(Utf8Path::to_owned).collect()
    }
}

/// The search path of a file for its includes, in order (language reference, 2.3).
fn places<'a>(
    db: &'a dyn Db,
    search: &'a [Utf8PathBuf],
    request: &IncludeRequest,
    from: SourceFile,
) -> Vec<&'a Utf8Path> {
    if Utf8Path::new(request.path.as_str()).is_absolute() {
        return vec![Utf8Path::new("/")];
    }
    let own = from.path(db).parent().filter(|_| !request.angled);
    own.into_iter().chain(search.iter().map(Utf8PathBuf::as_path)).collect()
}

/// One inclusion of one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct WalkVisit {
    pub(crate) file: SourceFile,
    pub(crate) entry: MacroEnv,
    pub(crate) outcomes: Vec<DirectiveEffect>,
    /// Visit that each active include leads to.
    pub(crate) includes: Vec<Option<WalkId>>,
    /// The length of [`Walk::search`] at each active include.
    searched: Vec<usize>,
    /// The visit and the ordinal of the include that led here.
    pub(crate) includer: Option<(WalkId, usize)>,
}

/// The directive lines of a file, one after the other, and nothing else.
///
/// All effects of a file on its units are on these lines, except for `_Pragma` operators, which are copied as
/// lines of their own.
#[salsa::tracked(returns(deref))]
pub(crate) fn skeleton(db: &dyn Db, file: SourceFile) -> String {
    let lexed = lexed(db, file);
    directive_lines(file.text(db), &lexed.raw)
}

/// Follows the includes of a unit.
#[salsa::tracked]
pub(crate) fn walk_unit<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Walk {
    // A macro with a pragma in it may be used in any text: start again, reading all of it.
    let walked = walk(db, unit, false).or_else(|()| walk(db, unit, true));
    walked.unwrap_or_default()
}

/// One attempt. Unless the walk reads whole texts, it stops at a macro with a pragma in it.
fn walk<'db>(db: &'db dyn Db, unit: UnitKey<'db>, whole_texts: bool) -> Result<Walk, ()> {
    let workspace = db.workspace();
    let root = unit.inputs(db).first().map(|input| input.path(db));
    let (include_dirs, defines) = match root {
        Some(root) => workspace.reading(db, root),
        None => (&[][..], &[][..]),
    };
    let mut search: Vec<Utf8PathBuf> = Vec::new();
    for dir in unit.include_dirs(db).iter().chain(include_dirs) {
        push_unique(&mut search, dir);
    }
    let mut env = MacroEnv::of_release(requirement::of_inputs(db, unit.inputs(db)).release);
    let mut pragmas_in_macros = false;
    for (name, value) in defines.iter().chain(unit.defines(db)) {
        define_in(&mut env, name, value);
        pragmas_in_macros |= value.contains(PRAGMA);
    }
    let mut walker = Walker {
        db,
        search,
        visits: TiVec::new(),
        depth: 1,
        cut_off: false,
        packages_missing: false,
        whole_texts,
        pragmas_in_macros,
    };
    for &input in unit.inputs(db) {
        env = walker.visit(input, env, None).1;
    }
    if walker.pragmas_in_macros && !whole_texts {
        return Err(());
    }
    Ok(Walk { visits: walker.visits, search: walker.search })
}

/// The state of a walk.
struct Walker<'db> {
    db: &'db dyn Db,
    /// Search path so far.
    search: Vec<Utf8PathBuf>,
    visits: TiVec<WalkId, WalkVisit>,
    /// Number of files open now; the wrapper counts.
    depth: usize,
    /// True if a limit was reached: nothing more is followed, as in the reference compiler.
    cut_off: bool,
    /// True if a `#pragma requires` failed.
    packages_missing: bool,
    /// True to read more than the directive lines.
    whole_texts: bool,
    /// True if some macro has a `_Pragma` in it.
    pragmas_in_macros: bool,
}

struct VisitHost<'a, 'db> {
    walker: &'a mut Walker<'db>,
    visit: WalkId,
    file: SourceFile,
}

impl Walker<'_> {
    /// Visits a file; returns its visit and the environment after it.
    fn visit(
        &mut self,
        file: SourceFile,
        entry: MacroEnv,
        includer: Option<(WalkId, usize)>,
    ) -> (WalkId, MacroEnv) {
        self.db.unwind_if_revision_cancelled();
        let visit = self.visits.push_and_get_key(WalkVisit {
            file,
            entry: entry.clone(),
            outcomes: Vec::new(),
            includes: Vec::new(),
            searched: Vec::new(),
            includer,
        });
        self.depth += 1;
        let name = SmolStr::new(file.path(self.db).as_str());
        let text = skeleton(self.db, file);
        self.pragmas_in_macros |= defines_pragma(text);
        let whole_text = self.whole_texts;
        let db = self.db;
        let mut host = VisitHost { walker: self, visit, file };
        let exit = if whole_text {
            let raw = &lexed(db, file).raw;
            preprocess(&name, file.text(db), raw, entry, &mut host).exit_env
        } else if text.is_empty() {
            entry
        } else {
            preprocess(&name, text, &lex(text), entry, &mut host).exit_env
        };
        self.depth -= 1;
        (visit, exit)
    }

    /// Finds the file of an include (language reference, 2.3).
    fn resolve(
        &self,
        request: &IncludeRequest,
        from: SourceFile,
    ) -> Result<SourceFile, IncludeError> {
        let name = Utf8Path::new(request.path.as_str());
        let dirs = places(self.db, &self.search, request, from);
        // The stand-in for a file that is not found elsewhere.
        let root = self.visits.iter().rev().find(|visit| visit.includer.is_none());
        let root = root.map(|visit| visit.file.path(self.db));
        let standins = root.and_then(|root| root.parent()).map(|parent| parent.join(STANDINS));
        let last = standins.as_deref().filter(|_| !name.is_absolute());
        let mut obstacle = None;
        for dir in dirs.iter().copied().chain(last) {
            let candidate = dir.join(name);
            let file = self.db.file(&candidate);
            match file.status(self.db) {
                FileStatus::Text | FileStatus::NotUtf8 => return Ok(file),
                FileStatus::Missing => {}
                FileStatus::Directory => {
                    obstacle.get_or_insert_with(|| format!("`{candidate}` is a directory"));
                }
                FileStatus::TooLarge(_) => {
                    let limit = self.db.max_bytes() / 1024;
                    obstacle.get_or_insert_with(|| {
                        format!(
                            "`{candidate}` has more than the {limit} kB of the setting `max-file-size`"
                        )
                    });
                }
                FileStatus::Unreadable(why) => {
                    obstacle.get_or_insert_with(|| format!("`{candidate}` cannot be read: {why}"));
                }
            }
        }
        Err(match obstacle {
            Some(why) => IncludeError::Unreadable(why),
            // The file may be in the missing package, which is reported.
            None if self.packages_missing => IncludeError::Silent,
            None => {
                IncludeError::NotFound { searched: dirs.iter().map(ToString::to_string).collect() }
            }
        })
    }
}

impl Host for VisitHost<'_, '_> {
    fn include(
        &mut self,
        request: &IncludeRequest,
        env: &MacroEnv,
    ) -> Result<MacroEnv, IncludeError> {
        let walker = &mut *self.walker;
        let ordinal = walker.visits[self.visit].includes.len();
        let searched = walker.search.len();
        let visit = &mut walker.visits[self.visit];
        visit.includes.push(None);
        visit.searched.push(searched);
        let result = if walker.cut_off {
            Err(IncludeError::Silent)
        } else if walker.depth >= MAX_DEPTH {
            walker.cut_off = true;
            Err(IncludeError::TooDeep)
        } else if walker.visits.len() >= MAX_VISITS {
            walker.cut_off = true;
            Err(IncludeError::Unreadable(format!(
                "the specification includes more than {MAX_VISITS} files, counting repetitions; \
                 include each once, with a guard"
            )))
        } else {
            walker.resolve(request, self.file).map(|file| {
                let (visit, exit) = walker.visit(file, env.clone(), Some((self.visit, ordinal)));
                walker.visits[self.visit].includes[ordinal] = Some(visit);
                exit
            })
        };
        walker.visits[self.visit].outcomes.push(DirectiveEffect::Include(result.clone()));
        result
    }

    fn requires(
        &mut self,
        arguments: &[SmolStr],
        env: &MacroEnv,
    ) -> Result<RequiredPackages, String> {
        let walker = &mut *self.walker;
        let arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
        let packages = walker.db.packages(&arguments);
        let result = packages.flags(walker.db).as_ref().map_err(Clone::clone).map(|flags| {
            for dir in &flags.include_dirs {
                push_unique(&mut walker.search, dir);
            }
            let mut env = env.clone();
            for (name, value) in &flags.defines {
                define_in(&mut env, name, value);
            }
            let own = flags.own.iter().map(SmolStr::from).collect();
            RequiredPackages { env, own }
        });
        walker.packages_missing |= result.is_err();
        walker.visits[self.visit].outcomes.push(DirectiveEffect::Requires(result.clone()));
        result
    }
}

/// Defines a macro. Invalid names were refused when the configuration was read.
fn define_in(env: &mut MacroEnv, name: &str, value: &str) {
    _ = env.define_option(&format!("{name}={value}"));
}

fn push_unique(search: &mut Vec<Utf8PathBuf>, dir: &Utf8Path) {
    let dir = normalize(dir);
    if !search.contains(&dir) {
        search.push(dir);
    }
}

/// Returns true if a directive line defines a macro that holds a pragma.
fn defines_pragma(skeleton: &str) -> bool {
    skeleton.contains(PRAGMA)
        && skeleton.lines().any(|line| line.contains("define") && line.contains(PRAGMA))
}

fn directive_lines(text: &str, raw: &RawTokens) -> String {
    let mut out = String::new();
    let mut at_line_start = true;
    let mut i = 0;
    while i < raw.len() {
        match raw.kind(i) {
            SyntaxKind::NEWLINE => at_line_start = true,
            SyntaxKind::WHITESPACE
            | SyntaxKind::SPLICE
            | SyntaxKind::LINE_COMMENT
            | SyntaxKind::BLOCK_COMMENT
            | SyntaxKind::OPEN_COMMENT => {}
            SyntaxKind::HASH if at_line_start => {
                while i < raw.len() && raw.kind(i) != SyntaxKind::NEWLINE {
                    match raw.kind(i) {
                        SyntaxKind::LINE_COMMENT
                        | SyntaxKind::BLOCK_COMMENT
                        | SyntaxKind::OPEN_COMMENT => out.push(' '),
                        SyntaxKind::SPLICE => {}
                        _ => out.push_str(raw.text(text, i)),
                    }
                    i += 1;
                }
                out.push('\n');
                at_line_start = true;
            }
            SyntaxKind::IDENT if raw.text(text, i) == PRAGMA => {
                // The operator and its argument, up to the closing parenthesis.
                at_line_start = false;
                for _ in 0..8 {
                    out.push_str(raw.text(text, i));
                    i += 1;
                    if i >= raw.len() || raw.kind(i - 1) == SyntaxKind::R_PAREN {
                        break;
                    }
                }
                out.push('\n');
                continue;
            }
            _ => at_line_start = false,
        }
        i += 1;
    }
    out
}
