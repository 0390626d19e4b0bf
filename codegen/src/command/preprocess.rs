//! `-E`: the text after preprocessing.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{FileContent, Loader};
use dotgen_analysis::release::Release;
use dotgen_syntax::lexer::{RawTokens, lex};
use dotgen_syntax::preproc::{
    self, Element, Host, IncludeError, IncludeRequest, MacroEnv, Preprocessed, RequiredPackages,
    preprocess,
};
use smol_str::SmolStr;

/// Maximum number of nested files.
const DEPTH: usize = 100;

/// Preprocesses files one after the other.
pub(super) struct Preprocessor {
    pub(super) loader: Arc<dyn Loader>,
    pub(super) include_dirs: Vec<Utf8PathBuf>,
    pub(super) env: MacroEnv,
    /// Messages, as `FILE:LINE: TEXT`.
    pub(super) messages: Vec<String>,
    /// True if one of the messages is an error.
    pub(super) has_errors: bool,
    open: Vec<Utf8PathBuf>,
}

impl Preprocessor {
    pub(super) fn new(
        loader: Arc<dyn Loader>,
        include_dirs: Vec<Utf8PathBuf>,
        release: Release,
    ) -> Preprocessor {
        Preprocessor {
            loader,
            include_dirs,
            env: MacroEnv::of_release(release),
            messages: Vec::new(),
            has_errors: false,
            open: Vec::new(),
        }
    }

    /// The text of a file, with line marks.
    pub(super) fn file(&mut self, path: &Utf8Path) -> Result<String, String> {
        let text = match self.loader.read(path) {
            FileContent::Text(text) | FileContent::NotUtf8(text) => text,
            FileContent::Missing => return Err("No such file or directory".into()),
            FileContent::Directory => return Err("Is a directory".into()),
            FileContent::Unreadable(why) => return Err(why),
        };
        self.open.push(path.to_owned());
        let raw = lex(&text);
        let mut inside = FileHost { outer: self, texts: Vec::new() };
        let env = inside.outer.env.clone();
        let name = SmolStr::new(path.as_str());
        let result = preprocess(&name, &text, &raw, env, &mut inside);
        let texts = inside.texts;
        self.open.pop();
        self.env = result.exit_env.clone();
        for error in &result.errors {
            let before = text.get(..usize::from(error.range.start())).unwrap_or(&text);
            let line = 1 + before.matches('\n').count();
            let is_error = error.severity == preproc::Severity::Error;
            self.has_errors |= is_error;
            let severity = if is_error { "error" } else { "warning" };
            self.messages.push(format!("{path}:{line}: {severity}: {}", error.kind.wording()));
        }
        Ok(show(path, &text, &raw, &result, &texts))
    }
}

/// The host of one file, which collects the texts of its included files.
struct FileHost<'p> {
    outer: &'p mut Preprocessor,
    texts: Vec<String>,
}

impl Host for FileHost<'_> {
    fn include(
        &mut self,
        request: &IncludeRequest,
        env: &MacroEnv,
    ) -> Result<MacroEnv, IncludeError> {
        self.texts.push(String::new());
        if self.outer.open.len() >= DEPTH {
            return Err(IncludeError::TooDeep);
        }
        let wanted = Utf8Path::new(request.path.as_str());
        let own = self.outer.open.last().and_then(|path| path.parent());
        let own = own.filter(|_| !request.angled).map(ToOwned::to_owned);
        let dirs = own.into_iter().chain(self.outer.include_dirs.clone());
        let mut searched = Vec::new();
        for dir in dirs {
            let path = dir.join(wanted);
            searched.push(dir.to_string());
            if !matches!(
                self.outer.loader.read(&path),
                FileContent::Text(_) | FileContent::NotUtf8(_)
            ) {
                continue;
            }
            self.outer.env = env.clone();
            let text = self.outer.file(&path).map_err(IncludeError::Unreadable)?;
            if let Some(last) = self.texts.last_mut() {
                *last = text;
            }
            return Ok(self.outer.env.clone());
        }
        Err(IncludeError::NotFound { searched })
    }

    fn requires(
        &mut self,
        arguments: &[SmolStr],
        env: &MacroEnv,
    ) -> Result<RequiredPackages, String> {
        let arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
        let flags = self.outer.loader.packages(&arguments)?;
        let mut env = env.clone();
        for (name, value) in &flags.defines {
            env.define_option(&format!("{name}={value}"))?;
        }
        for dir in flags.include_dirs {
            if !self.outer.include_dirs.contains(&dir) {
                self.outer.include_dirs.push(dir);
            }
        }
        Ok(env.into())
    }
}

/// The text for a compiler: without directives except pragmas, with blanks for comments, and with expanded
/// macros.
fn show(
    path: &Utf8Path,
    text: &str,
    raw: &RawTokens,
    result: &Preprocessed,
    included: &[String],
) -> String {
    let mut out = format!("# 1 \"{path}\"\n");
    let lines = |first: u32, end: u32| -> usize {
        (first..end).map(|token| raw.text(text, token as usize).matches('\n').count()).sum()
    };
    let mut line = 1;
    for element in &result.elements {
        match element {
            Element::Real(token) => {
                let token = raw.text(text, *token as usize);
                line += token.matches('\n').count();
                out.push_str(token);
            }
            Element::Trivia(token) => {
                let token = raw.text(text, *token as usize);
                let breaks = token.matches('\n').count();
                line += breaks;
                if token.trim().is_empty() {
                    out.push_str(token);
                } else {
                    out.push(' ');
                    out.push_str(&"\n".repeat(breaks));
                }
            }
            Element::Virtual(token) => {
                if !token.glued && !out.ends_with(char::is_whitespace) {
                    out.push(' ');
                }
                out.push_str(&token.text);
            }
            Element::Call { first, end } | Element::Inactive { first, end } => {
                let breaks = lines(*first, *end);
                line += breaks;
                out.push_str(&"\n".repeat(breaks));
            }
            Element::Directive { first, end, index } => {
                let breaks = lines(*first, *end);
                line += breaks;
                let directive = result.directives.get(*index as usize);
                let keyword = directive.and_then(|directive| directive.keyword.as_ref());
                let pragma = keyword.is_some_and(|keyword| keyword.text == "pragma");
                match result.include_ordinal(*index) {
                    Some(ordinal) => {
                        let text = included.get(ordinal as usize).map_or("", String::as_str);
                        out.push_str(text);
                        if !text.is_empty() {
                            if !out.ends_with('\n') {
                                out.push('\n');
                            }
                            out.push_str(&format!("# {line} \"{path}\"\n"));
                        }
                    }
                    None if pragma => {
                        for token in *first..*end {
                            out.push_str(raw.text(text, token as usize));
                        }
                    }
                    None => out.push_str(&"\n".repeat(breaks)),
                }
            }
        }
    }
    if !out.ends_with('\n') {
        out.push('\n');
    }
    out
}
