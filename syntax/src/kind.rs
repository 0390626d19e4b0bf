//! Kinds of tokens and nodes.

use std::sync::LazyLock;

use logos::Logos;
use rustc_hash::FxHashMap;

/// Declares the kinds. Those of `tokens` are found by the lexer: by their spellings, and by the patterns and
/// further spellings in their attributes.
macro_rules! syntax_kinds {
    (
        $(#[$attr:meta])*
        pub enum SyntaxKind {
            tokens { $($(#[$token_attr:meta])* $token:ident $(= $($spelling:tt)|+)?,)* }
            others { $($(#[$doc:meta])* $kind:ident $(= $($word:tt)|+)?,)* }
        }
    ) => {
        $(#[$attr])*
        pub enum SyntaxKind {
            $($(#[$token_attr])* $($(#[token($spelling)])+)? $token,)*
            $($(#[$doc])* $kind,)*
        }

        /// Every kind, by discriminant.
        const KINDS: &[SyntaxKind] = &[$(SyntaxKind::$token,)* $(SyntaxKind::$kind,)*];

        /// Spellings of the punctuation and keyword kinds, as messages name them. Digraphs and operator
        /// words are left out; of two spellings of a keyword the first is the preferred one.
        const SPELLINGS: &[(SyntaxKind, &str)] = &[
            $($($((SyntaxKind::$token, $spelling),)+)?)*
            $($($((SyntaxKind::$kind, $word),)+)?)*
        ];
    };
}

syntax_kinds! {
/// Every kind of token and node of the tree. Tokens come first.
///
/// The language has only a few reserved words (manual, "Reserved words"); every other keyword is an
/// identifier that the grammar recognises by its text, so the tree holds it as [`SyntaxKind::IDENT`]
/// until the grammar remaps it to the keyword kind at the place where it is one.
#[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "the names of the grammar")]
#[derive(Logos, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u16)]
pub enum SyntaxKind {
    tokens {
        // Trivia.
        #[regex(r"[ \t\x0B\x0C]+")]
        WHITESPACE,
        #[regex(r"\n|\r\n|\r")]
        NEWLINE,
        /// A backslash that ends a line, with the line end.
        SPLICE,
        #[regex(r"//[^\r\n]*", allow_greedy = true)]
        LINE_COMMENT,
        #[token("/*")]
        BLOCK_COMMENT,
        /// A block comment without end.
        OPEN_COMMENT,

        // Literals and names.
        #[regex(r"[A-Za-z_][A-Za-z0-9_]*")]
        #[token("clock-rate")]
        #[token("real-time")]
        #[token("codels-require")]
        #[token("codels-requires")]
        IDENT,
        #[regex(r"(0[xX][0-9a-fA-F]+|[0-9]+)([uU][lL]?|[lL][uU]?)?")]
        INT,
        #[regex(r"(([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)[fFlL]?")]
        FLOAT,
        /// A number with suffix `d` or `D`.
        #[regex(r"(([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)[dD]")]
        FIXED,
        #[token("'")]
        CHAR,
        #[token("\"")]
        STRING,
        /// A string or character literal without end.
        OPEN_STRING,

        // Punctuation (digraphs and operator words have the kind of the token they stand for).
        #[token("<%")]
        L_CURLY = "{",
        #[token("%>")]
        R_CURLY = "}",
        #[token("<:")]
        L_BRACK = "[",
        #[token(":>")]
        R_BRACK = "]",
        L_PAREN = "(",
        R_PAREN = ")",
        SEMICOLON = ";",
        COLON = ":",
        COLON2 = "::",
        QUESTION = "?",
        DOT = ".",
        PLUS = "+",
        MINUS = "-",
        STAR = "*",
        SLASH = "/",
        PERCENT = "%",
        #[token("xor")]
        CARET = "^",
        #[token("bitand")]
        AMP = "&",
        #[token("bitor")]
        PIPE = "|",
        #[token("compl")]
        TILDE = "~",
        #[token("not")]
        BANG = "!",
        EQ = "=",
        L_ANGLE = "<",
        R_ANGLE = ">",
        SHL = "<<",
        SHR = ">>",
        COMMA = ",",
        /// `#` or `%:`
        #[token("%:")]
        HASH = "#",
        /// `##` or `%:%:`
        #[token("%:%:")]
        HASH2 = "##",
        /// A character that does not start a token.
        #[regex(r"[^\x00-\x7F]+")]
        STRAY,

        // Reserved words.
        MODULE_KW = "module",
        FALSE_KW = "FALSE",
        TRUE_KW = "TRUE",
        UNSIGNED_KW = "unsigned",
        SHORT_KW = "short",
        LONG_KW = "long",
        FIXED_KW = "fixed",
        FLOAT_KW = "float",
        DOUBLE_KW = "double",
        CHAR_KW = "char",
        WCHAR_KW = "wchar",
        STRING_KW = "string",
        WSTRING_KW = "wstring",
        BOOLEAN_KW = "boolean",
        OCTET_KW = "octet",
        OBJECT_KW = "object",
        ANY_KW = "any",
        CONST_KW = "const",
        ENUM_KW = "enum",
        UNION_KW = "union",
        SWITCH_KW = "switch",
        CASE_KW = "case",
        DEFAULT_KW = "default",
        STRUCT_KW = "struct",
        SEQUENCE_KW = "sequence",
        OPTIONAL_KW = "optional",
        TYPEDEF_KW = "typedef",
    }
    others {
        // Contextual keywords: identifiers that the grammar remaps where they are keywords (language
        // reference, 3.3). Words with two spellings have one kind, named after the plural.
        ACTIVITY_KW = "activity",
        AFTER_KW = "after",
        ASYNC_KW = "async",
        ATTRIBUTE_KW = "attribute",
        BEFORE_KW = "before",
        CLOCK_RATE_KW = "clock-rate",
        CODEL_KW = "codel",
        CODELS_REQUIRES_KW = "codels-require" | "codels-requires",
        COMPONENT_KW = "component",
        DELAY_KW = "delay",
        DOC_KW = "doc",
        EMAIL_KW = "email",
        EXCEPTION_KW = "exception",
        EXTENDS_KW = "extends" | "extend",
        FUNCTION_KW = "function",
        IDS_KW = "ids",
        IN_KW = "in",
        INOUT_KW = "inout",
        INTERFACE_KW = "interface",
        INTERRUPTS_KW = "interrupts" | "interrupt",
        K_KW = "k",
        LANG_KW = "lang",
        LOCAL_KW = "local",
        M_KW = "M",
        MS_KW = "ms",
        MULTIPLE_KW = "multiple",
        NATIVE_KW = "native",
        OUT_KW = "out",
        PAUSE_KW = "pause",
        PERIOD_KW = "period",
        PORT_KW = "port",
        PRIORITY_KW = "priority",
        PROVIDES_KW = "provides" | "provide",
        REAL_TIME_KW = "real-time",
        REMOTE_KW = "remote",
        REQUIRES_KW = "require" | "requires",
        S_KW = "s",
        SCHEDULING_KW = "scheduling",
        STACK_KW = "stack",
        TASK_KW = "task",
        THROWS_KW = "throw" | "throws",
        US_KW = "us",
        USES_KW = "uses" | "use",
        VALIDATE_KW = "validate",
        VERSION_KW = "version",
        WCET_KW = "wcet",
        YIELDS_KW = "yield" | "yields",

        /// End of the input (never in a tree).
        EOF,
        /// First kind that is not a token; also stands for an abandoned node (never in a tree).
        TOMBSTONE,

        // Nodes; `genom.ungram` defines the content of each.
        SOURCE_FILE,
        /// Text that does not match a rule.
        ERROR,
        BODY,
        NAME,
        NAME_REF,
        PATH,

        MODULE,
        CONST_DECL,
        TYPEDEF_DECL,
        NATIVE_DECL,
        EXCEPTION_DECL,
        EXCEPTION,
        TYPE_DECL,
        FORWARD_DECL,
        COMPONENT,
        IDS,
        TASK,
        PORT,
        SERVICE,
        MEMBER,
        CASE,
        CASE_LABEL,
        DECLARATOR,
        DIMENSION,

        BASE_TYPE,
        STRING_TYPE,
        SEQUENCE_TYPE,
        OPTIONAL_TYPE,
        FIXED_TYPE,
        NAMED_TYPE,
        STRUCT,
        UNION,
        ENUM,
        ENUMERATOR_LIST,
        ENUMERATOR,

        LITERAL,
        PATH_EXPR,
        PAREN_EXPR,
        PREFIX_EXPR,
        BINARY_EXPR,

        STRING_PROPERTY,
        REQUIRES_PROPERTY,
        DURATION_PROPERTY,
        INTERFACES_PROPERTY,
        THROWS_PROPERTY,
        PRIORITY_PROPERTY,
        SCHEDULING_PROPERTY,
        STACK_PROPERTY,
        TASK_PROPERTY,
        SERVICES_PROPERTY,
        VALIDATE_PROPERTY,
        LOCAL_PROPERTY,
        CODEL_PROPERTY,
        QUANTITY,

        CODEL,
        TRIGGERS,
        YIELDS,
        STATE,
        WCET,
        PARAM_LIST,
        TYPED_PARAM,
        PATH_PARAM,
        PARAM_PATH,
        MEMBER_STEP,
        INDEX_STEP,
        RENAME,

        INITIALIZER,
        INITIALIZER_LIST,
        INITIALIZER_DOC,
        MEMBER_DESIGNATOR,
        INDEX_DESIGNATOR,

        // Preprocessor nodes, placed by the tree builder between the others.
        DIRECTIVE,
        INCLUDE_PATH,
        MACRO_PARAMS,
        MACRO_BODY,
        CONDITION,
        PRAGMA_ARG,
        DIRECTIVE_TEXT,
        INACTIVE,
        MACRO_CALL,
    }
}
}

use SyntaxKind::*;

/// The contextual keywords by their spellings.
static CONTEXTUAL: LazyLock<FxHashMap<&str, SyntaxKind>> = LazyLock::new(|| {
    SPELLINGS
        .iter()
        .filter(|entry| entry.0.is_contextual())
        .map(|&(kind, text)| (text, kind))
        .collect()
});

impl SyntaxKind {
    /// The kind with this discriminant. Anything out of range is [`ERROR`], which cannot happen for
    /// trees built by this crate.
    pub fn from_raw(raw: u16) -> SyntaxKind {
        KINDS.get(usize::from(raw)).copied().unwrap_or(ERROR)
    }

    /// White space, comment or splice.
    pub fn is_trivia(self) -> bool {
        self <= OPEN_COMMENT
    }

    /// A comment, closed or not.
    pub fn is_comment(self) -> bool {
        matches!(self, LINE_COMMENT | BLOCK_COMMENT | OPEN_COMMENT)
    }

    /// A word that is never an identifier (language reference, 3.2).
    pub fn is_reserved_word(self) -> bool {
        (MODULE_KW..=TYPEDEF_KW).contains(&self)
    }

    /// A word that is a keyword only where the grammar expects it (language reference, 3.3).
    pub(crate) fn is_contextual(self) -> bool {
        (ACTIVITY_KW..=YIELDS_KW).contains(&self)
    }

    /// A keyword of either sort.
    pub fn is_keyword(self) -> bool {
        self.is_reserved_word() || self.is_contextual()
    }

    /// A number, string, character or truth value.
    pub fn is_literal(self) -> bool {
        matches!(self, INT | FLOAT | FIXED | CHAR | STRING | OPEN_STRING | TRUE_KW | FALSE_KW)
    }

    /// The contextual keyword with this spelling.
    pub fn contextual(text: &str) -> Option<SyntaxKind> {
        CONTEXTUAL.get(text).copied()
    }

    /// The (preferred) spelling of a keyword or punctuation.
    pub fn spelling(self) -> Option<&'static str> {
        SPELLINGS.iter().find(|(kind, _)| *kind == self).map(|(_, spelling)| *spelling)
    }

    /// Every keyword and punctuation with its spellings, preferred ones first.
    pub fn spellings() -> &'static [(SyntaxKind, &'static str)] {
        SPELLINGS
    }
}

impl From<SyntaxKind> for rowan::SyntaxKind {
    fn from(kind: SyntaxKind) -> Self {
        rowan::SyntaxKind(kind as u16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_keyword_has_a_spelling_and_is_found_by_it() {
        for &kind in KINDS {
            assert_eq!(SyntaxKind::from_raw(kind as u16), kind);
            if kind.is_keyword() || (L_CURLY..=HASH2).contains(&kind) {
                assert!(kind.spelling().is_some(), "{kind:?} has no spelling");
            }
        }
        for &(kind, spelling) in SPELLINGS {
            if kind.is_contextual() {
                assert_eq!(SyntaxKind::contextual(spelling), Some(kind));
            } else {
                assert_eq!(SyntaxKind::contextual(spelling), None);
            }
        }
    }
}
