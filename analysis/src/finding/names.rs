//! Findings about names: declared twice, not declared, or used as something else.

use std::fmt;

use dotgen_syntax::findings;

use crate::{
    fixes::{FixSite, TextFix},
    model::Name,
};

/// The expected kind of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Noun {
    Type,
    Constant,
    Exception,
}

impl fmt::Display for Noun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Noun::Type => "type",
            Noun::Constant => "constant",
            Noun::Exception => "exception",
        })
    }
}

/// The kind of a declaration. Its text has the article: `an enum`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Described {
    pub noun: &'static str,
}

impl fmt::Display for Described {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let article = if self.noun.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" };
        write!(f, "{article} {}", self.noun)
    }
}

/// The scopes searched for the first part of a path.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum SearchedScope {
    /// The enclosing scopes.
    Here,
    /// The scope named by the part before.
    Scope(Name),
}

impl fmt::Display for SearchedScope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SearchedScope::Here => f.write_str("here"),
            SearchedScope::Scope(name) => write!(f, "in `{name}`"),
        }
    }
}

findings! {
    /// A name that is declared twice, not declared, or used as something else.
    pub enum NameProblem {
        "name-clash" Clash { name: Name, what: Described }
            => "`{name}` is already declared in this scope, as {what}";
        "name-clash" ClashWithState { name: Name, what: Described }
            => "`{name}` is already {what}: every component has the states `ether`, `start` and `stop`";
        "name-clash-module" ClashWithScope { name: Name, what: &'static str }
            => "`{name}` is already the name of {what} in this scope";
        "name-clash-enclosing" ClashWithEnclosing { name: Name }
            => "`{name}` cannot be declared here, because it is the name of the scope it would be in",
               "choose another name";
        "redefinition" Taken { name: Name, what: &'static str }
            => "`{name}` is already {what} of this component";
        "redefinition" RemoteTaken { name: Name }
            => "remote service `{name}` has the name of a service of this component";
        "comp-kind-conflict" OtherKind { name: Name, was: &'static str, is: &'static str }
            => "`{name}` is {was}", "it cannot be reopened as {is}";

        "forward-undefined" NeverDefined { keyword: &'static str, name: Name }
            => "{keyword} `{name}` is declared but never defined",
               "define it in the same scope and file, or remove the declaration";
        "forward-other-file" DefinedElsewhere { name: Name }
            => "`{name}` was declared in another file", "it must be defined in that file";
        "forward-by-value" NotYetDefined { path: Name }
            => "`{path}` is only declared so far",
               "until it is defined it can be used in `sequence<>` and `optional<>` only";

        "unknown-type" UnknownScope { path: Name, noun: Noun, missing: Name, inside: SearchedScope }
            => "`{path}` does not name a {noun}: there is no module, component or type scope \
                `{missing}` {inside}";
        "unknown-type" Standard { path: Name, ty: &'static str }
            => "`{path}` is a type of C++", "did you mean `{ty}`?";
        "unknown-type" UnknownPath { noun: Noun, path: Name } => "there is no {noun} `{path}`";
        "unknown-type" Unknown { noun: Noun, name: Name }
            => "unknown {noun} `{name}`", "it must be declared before it is used";
        "not-a-type" NotAType { path: Name, what: Described }
            => "`{path}` is {what}, not a type: this is accepted, but the code generated from it \
                does not compile";
        "void-exception-type" NoData { path: Name }
            => "exception `{path}` has no members, so it cannot be used as a data type",
               "give it members or use another type";
        "throw-not-exception" NotAnException { path: Name, what: Described }
            => "`{path}` is {what}, not an exception",
               "only what is declared with `exception` can be thrown";
        "throw-duplicate" ThrownTwice { path: Name } => "`{path}` is already in this list", "remove it";

        "iface-repeated" ImportedTwice { name: Name }
            => "`{name}` is already in this list", "remove it";
        "iface-unknown" UnknownInterface { name: Name }
            => "unknown interface `{name}`", "it must be declared before it is used";
        "iface-is-component" NotAnInterface { name: Name }
            => "`{name}` is a component",
               "only interfaces can be imported, so move what is shared into an interface that both \
                provide";
        "pragma-provides-unknown" UnknownInPragma { name: Name }
            => "unknown interface `{name}`", "it must be declared before it is used";
        "pragma-provides-component" ComponentInPragma { name: Name }
            => "`{name}` is a component",
               "only interfaces can be imported, so move what is shared into an interface that both \
                provide";
        "pragma-provides-unknown" CommentInPragma
            => "in a pragma, comments are read as names of interfaces",
               "write it on a line of its own";
        "pragma-masquerade-syntax" MasqueradeArguments { are: &'static str, count: usize }
            => "`#pragma masquerade` takes three arguments, a template, a type and a text, but there \
                {are} {count}",
               "put texts with blanks in quotes";
        "pragma-masquerade-type" MasqueradeUnknown { name: Name }
            => "there is no type `{name}` so far, so it cannot masquerade";
        "pragma-masquerade-duplicate" MasqueradeTwice { name: Name, template: Name }
            => "`{name}` has a masquerade for template `{template}` already";
    }
}

impl NameProblem {
    /// See [`Kind::may_be_in_a_package`](super::Kind::may_be_in_a_package).
    pub(super) fn may_be_in_a_package(&self, is_near: bool) -> bool {
        match self {
            NameProblem::UnknownScope { .. }
            | NameProblem::UnknownInterface { .. }
            | NameProblem::UnknownInPragma { .. }
            | NameProblem::MasqueradeUnknown { .. } => true,
            NameProblem::UnknownPath { .. } => !is_near,
            NameProblem::Unknown { .. } => !is_near,
            _ => false,
        }
    }

    /// The fixes, the best first, made from the text around.
    pub(crate) fn fixes(&self, here: &FixSite<'_>) -> Vec<TextFix> {
        match self {
            NameProblem::ThrownTwice { .. } => {
                here.remove_part().map(TextFix::plain).into_iter().collect()
            }
            NameProblem::Standard { ty, .. } => vec![here.replace(ty)],
            NameProblem::Unknown { noun: Noun::Exception, name } => {
                here.declare_exception(name).into_iter().collect()
            }
            NameProblem::Unknown { noun: Noun::Type, name } => {
                here.declare_type(name).into_iter().collect()
            }
            NameProblem::Unknown { noun: Noun::Constant, name } => {
                here.near_macro(name).into_iter().collect()
            }
            _ => Vec::new(),
        }
    }
}
