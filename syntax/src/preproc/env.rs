//! Macro environments: the macros defined at one point of a translation unit.
//!
//! An environment is a value: cheap to clone, comparable and hashable, so that it can be part of the key of a
//! query. Definitions refer to their directive by file and ordinal, never by position, so that edits
//! elsewhere leave environments equal.

use std::{
    hash::{Hash, Hasher},
    sync::{Arc, LazyLock},
};

use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};
use smol_str::SmolStr;

use super::{
    body::lower_define,
    definition::{BodyToken, Macro, MacroKind},
};
use crate::{
    directive::{Directive, DirectiveKind},
    kind::SyntaxKind,
    lexer::{RawTokens, is_word, lex},
    release::Release,
};

/// The macro that holds the release of GenoM.
const GENOM: &str = "__GENOM__";

/// The macros defined at one point.
#[derive(Clone)]
pub struct MacroEnv {
    macros: Arc<FxHashMap<SmolStr, Arc<Macro>>>,
    /// Sum of the hashes of the definitions, so that hashing needs no order and no walk.
    fingerprint: u64,
    /// The first bytes of the names (modulo 128), a filter in front of the map. May hold too many.
    first_bytes: u128,
}

impl MacroEnv {
    /// An environment without macros, not even the predefined ones.
    pub fn empty() -> MacroEnv {
        MacroEnv { macros: Arc::default(), fingerprint: 0, first_bytes: 0 }
    }

    /// The predefined macros (language reference, 2.2), of the default release.
    ///
    /// `__DATE__` and `__TIME__` are the strings C compilers use when the time is not known, so that a result
    /// depends on nothing but the text.
    pub fn predefined() -> MacroEnv {
        static PREDEFINED: LazyLock<MacroEnv> = LazyLock::new(|| {
            let mut env = MacroEnv::empty();
            for (name, value) in [
                (GENOM, Release::default().to_string().as_str()),
                ("__DATE__", "\"??? ?? ????\""),
                ("__TIME__", "\"??:??:??\""),
                ("__STDC__", "1"),
                ("__STDC_VERSION__", "199901L"),
            ] {
                env.define(Macro::from_text(name, value));
            }
            for (name, kind) in [("__FILE__", MacroKind::File), ("__LINE__", MacroKind::Line)] {
                env.define(Macro { kind, ..Macro::from_text(name, "") });
            }
            env
        });
        PREDEFINED.clone()
    }

    /// The predefined macros of a release: `__GENOM__` is its number.
    pub fn of_release(release: Release) -> MacroEnv {
        let mut env = MacroEnv::predefined();
        if release != Release::default() {
            env.define(Macro::from_text(GENOM, &release.to_string()));
        }
        env
    }

    /// Defines a macro as `-D definition` does: `NAME`, which stands for 1, or `NAME=VALUE`. A former
    /// definition is silently replaced.
    ///
    /// # Errors
    /// Returns a message if `definition` does not begin with a name.
    pub fn define_option(&mut self, definition: &str) -> Result<(), String> {
        let (head, value) = definition.split_once('=').unwrap_or((definition, "1"));
        let text = format!("#define {head} {}", value.replace(['\n', '\r'], " "));
        let raw = lex(&text);
        let mut defines = 0;
        let directive = Directive::parse(&text, &raw, 0, &mut defines);
        let DirectiveKind::Define(define) = &directive.kind else {
            return Err(format!("`{definition}` is not a macro definition"));
        };
        let (definition, problems) = lower_define(&text, &raw, define, None);
        match (definition, problems.into_iter().next()) {
            (Some(definition), None) => {
                self.define(definition);
                Ok(())
            }
            (_, problem) => Err(problem.map_or_else(
                || format!("`{head}` is not the name of a macro"),
                |problem| problem.wording().to_string(),
            )),
        }
    }

    /// Returns false if no macro has a name that starts with this byte. Cheap.
    #[inline]
    pub(crate) fn may_start(&self, first: u8) -> bool {
        self.first_bytes >> (first & 127) & 1 != 0
    }

    #[inline]
    pub fn get(&self, name: &str) -> Option<&Arc<Macro>> {
        let first = *name.as_bytes().first()?;
        if self.may_start(first) { self.macros.get(name) } else { None }
    }

    /// Adds or replaces a definition.
    pub fn define(&mut self, definition: Macro) {
        self.insert(Arc::new(definition));
    }

    fn insert(&mut self, definition: Arc<Macro>) {
        self.undef(&definition.name);
        let first = definition.name.as_bytes().first().copied().unwrap_or_default();
        self.first_bytes |= 1 << (first & 127);
        self.fingerprint = self.fingerprint.wrapping_add(fingerprint(&definition));
        Arc::make_mut(&mut self.macros).insert(definition.name.clone(), definition);
    }

    /// Removes a definition, if there is one.
    pub fn undef(&mut self, name: &str) {
        if self.get(name).is_none() {
            return;
        }
        if let Some(old) = Arc::make_mut(&mut self.macros).remove(name) {
            self.fingerprint = self.fingerprint.wrapping_sub(fingerprint(&old));
        }
    }

    /// All definitions, in no particular order.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<Macro>> {
        self.macros.values()
    }

    /// Number of macros.
    pub fn len(&self) -> usize {
        self.macros.len()
    }

    /// No macro is defined.
    pub fn is_empty(&self) -> bool {
        self.macros.is_empty()
    }

    /// The part of the environment that can matter to a text: the macros it mentions and, in turn, those
    /// mentioned in their bodies. If the text or one of these macros pastes tokens, any name can result, and
    /// the whole environment is returned.
    pub fn restrict(&self, mentioned: &MentionedWords) -> MacroEnv {
        if mentioned.pastes || self.is_empty() {
            return self.clone();
        }
        let mut kept = MacroEnv::empty();
        let mut queue: Vec<&Arc<Macro>> = if mentioned.words.len() < self.len() {
            mentioned.words.iter().filter_map(|word| self.get(word)).collect()
        } else {
            self.iter().filter(|definition| mentioned.words.contains(&definition.name)).collect()
        };
        while let Some(definition) = queue.pop() {
            if kept.get(&definition.name).is_some() {
                continue;
            }
            if definition.body.iter().any(BodyToken::is_paste) {
                return self.clone();
            }
            kept.insert(Arc::clone(definition));
            queue.extend(definition.body.iter().filter_map(|token| self.get(&token.text)));
        }
        kept
    }
}

impl Default for MacroEnv {
    /// The predefined macros.
    fn default() -> MacroEnv {
        MacroEnv::predefined()
    }
}

impl PartialEq for MacroEnv {
    fn eq(&self, other: &MacroEnv) -> bool {
        Arc::ptr_eq(&self.macros, &other.macros)
            || (self.fingerprint == other.fingerprint && self.macros == other.macros)
    }
}

impl Eq for MacroEnv {}

impl Hash for MacroEnv {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.fingerprint.hash(state);
    }
}

impl std::fmt::Debug for MacroEnv {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut names: Vec<&str> = self.macros.keys().map(SmolStr::as_str).collect();
        names.sort_unstable();
        f.debug_set().entries(names).finish()
    }
}

fn fingerprint(definition: &Macro) -> u64 {
    use std::hash::BuildHasher;
    FxBuildHasher.hash_one(definition)
}

/// The words of a text that may be names of macros.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MentionedWords {
    pub words: FxHashSet<SmolStr>,
    /// True if the text has a `##`, so that one of its macros may form further names.
    pub pastes: bool,
}

/// The words of a text that may be names of macros.
pub fn mentioned(raw: &RawTokens, text: &str) -> MentionedWords {
    let mut mentioned = MentionedWords::default();
    for i in 0..raw.len() {
        let kind = raw.kind(i);
        if kind == SyntaxKind::HASH2 {
            mentioned.pastes = true;
        } else if is_word(kind, raw.text(text, i)) {
            let word = raw.clean_text(text, i);
            if !mentioned.words.contains(word.as_ref()) {
                mentioned.words.insert(SmolStr::new(word));
            }
        }
    }
    mentioned
}
