//! Kinds of tokens and nodes.

macro_rules! syntax_kinds {
    ($(#[$attr:meta])* pub enum SyntaxKind { $($(#[$doc:meta])* $kind:ident,)* }) => {
        $(#[$attr])*
        pub enum SyntaxKind { $($(#[$doc])* $kind,)* }

        /// Every kind, by discriminant.
        const KINDS: &[SyntaxKind] = &[$(SyntaxKind::$kind,)*];
    };
}

syntax_kinds! {
/// Every kind of token and node of the tree. Tokens come first.
///
/// The language has only a few reserved words (manual, "Reserved words"); every other keyword is an
/// identifier that the grammar recognises by its text, so the tree holds it as [`SyntaxKind::IDENT`]
/// until the grammar remaps it to the keyword kind at the place where it is one.
#[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "the names of the grammar")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u16)]
pub enum SyntaxKind {
    // Trivia.
    WHITESPACE,
    NEWLINE,
    /// A backslash that ends a line, with the line end.
    SPLICE,
    LINE_COMMENT,
    BLOCK_COMMENT,
    /// A block comment without end.
    OPEN_COMMENT,

    // Literals and names.
    IDENT,
    INT,
    FLOAT,
    /// A number with suffix `d` or `D`.
    FIXED,
    CHAR,
    STRING,
    /// A string or character literal without end.
    OPEN_STRING,

    // Punctuation (digraphs and operator words have the kind of the token they stand for).
    L_CURLY,
    R_CURLY,
    L_BRACK,
    R_BRACK,
    L_PAREN,
    R_PAREN,
    SEMICOLON,
    COLON,
    COLON2,
    QUESTION,
    DOT,
    PLUS,
    MINUS,
    STAR,
    SLASH,
    PERCENT,
    CARET,
    AMP,
    PIPE,
    TILDE,
    BANG,
    EQ,
    L_ANGLE,
    R_ANGLE,
    SHL,
    SHR,
    COMMA,
    /// `#` or `%:`
    HASH,
    /// `##` or `%:%:`
    HASH2,
    /// A character that does not start a token.
    STRAY,

    // Reserved words.
    MODULE_KW,
    FALSE_KW,
    TRUE_KW,
    UNSIGNED_KW,
    SHORT_KW,
    LONG_KW,
    FIXED_KW,
    FLOAT_KW,
    DOUBLE_KW,
    CHAR_KW,
    WCHAR_KW,
    STRING_KW,
    WSTRING_KW,
    BOOLEAN_KW,
    OCTET_KW,
    OBJECT_KW,
    ANY_KW,
    CONST_KW,
    ENUM_KW,
    UNION_KW,
    SWITCH_KW,
    CASE_KW,
    DEFAULT_KW,
    STRUCT_KW,
    SEQUENCE_KW,
    OPTIONAL_KW,
    TYPEDEF_KW,

    // Contextual keywords: identifiers that the grammar remaps where they are keywords (language
    // reference, 3.3). Words with two spellings have one kind, named after the plural.
    ACTIVITY_KW,
    AFTER_KW,
    ASYNC_KW,
    ATTRIBUTE_KW,
    BEFORE_KW,
    CLOCK_RATE_KW,
    CODEL_KW,
    CODELS_REQUIRES_KW,
    COMPONENT_KW,
    DELAY_KW,
    DOC_KW,
    EMAIL_KW,
    EXCEPTION_KW,
    EXTENDS_KW,
    FUNCTION_KW,
    IDS_KW,
    IN_KW,
    INOUT_KW,
    INTERFACE_KW,
    INTERRUPTS_KW,
    K_KW,
    LANG_KW,
    LOCAL_KW,
    M_KW,
    MS_KW,
    MULTIPLE_KW,
    NATIVE_KW,
    OUT_KW,
    PAUSE_KW,
    PERIOD_KW,
    PORT_KW,
    PRIORITY_KW,
    PROVIDES_KW,
    REAL_TIME_KW,
    REMOTE_KW,
    REQUIRES_KW,
    S_KW,
    SCHEDULING_KW,
    STACK_KW,
    TASK_KW,
    THROWS_KW,
    US_KW,
    USES_KW,
    VALIDATE_KW,
    VERSION_KW,
    WCET_KW,
    YIELDS_KW,

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

use SyntaxKind::*;

/// Spellings of the punctuation and keyword kinds, as messages name them. Digraphs and operator
/// words are left out; of two spellings of a keyword the first is the preferred one.
const SPELLINGS: &[(SyntaxKind, &str)] = &[
    (L_CURLY, "{"),
    (R_CURLY, "}"),
    (L_BRACK, "["),
    (R_BRACK, "]"),
    (L_PAREN, "("),
    (R_PAREN, ")"),
    (SEMICOLON, ";"),
    (COLON, ":"),
    (COLON2, "::"),
    (QUESTION, "?"),
    (DOT, "."),
    (PLUS, "+"),
    (MINUS, "-"),
    (STAR, "*"),
    (SLASH, "/"),
    (PERCENT, "%"),
    (CARET, "^"),
    (AMP, "&"),
    (PIPE, "|"),
    (TILDE, "~"),
    (BANG, "!"),
    (EQ, "="),
    (L_ANGLE, "<"),
    (R_ANGLE, ">"),
    (SHL, "<<"),
    (SHR, ">>"),
    (COMMA, ","),
    (HASH, "#"),
    (HASH2, "##"),
    (MODULE_KW, "module"),
    (FALSE_KW, "FALSE"),
    (TRUE_KW, "TRUE"),
    (UNSIGNED_KW, "unsigned"),
    (SHORT_KW, "short"),
    (LONG_KW, "long"),
    (FIXED_KW, "fixed"),
    (FLOAT_KW, "float"),
    (DOUBLE_KW, "double"),
    (CHAR_KW, "char"),
    (WCHAR_KW, "wchar"),
    (STRING_KW, "string"),
    (WSTRING_KW, "wstring"),
    (BOOLEAN_KW, "boolean"),
    (OCTET_KW, "octet"),
    (OBJECT_KW, "object"),
    (ANY_KW, "any"),
    (CONST_KW, "const"),
    (ENUM_KW, "enum"),
    (UNION_KW, "union"),
    (SWITCH_KW, "switch"),
    (CASE_KW, "case"),
    (DEFAULT_KW, "default"),
    (STRUCT_KW, "struct"),
    (SEQUENCE_KW, "sequence"),
    (OPTIONAL_KW, "optional"),
    (TYPEDEF_KW, "typedef"),
    (ACTIVITY_KW, "activity"),
    (AFTER_KW, "after"),
    (ASYNC_KW, "async"),
    (ATTRIBUTE_KW, "attribute"),
    (BEFORE_KW, "before"),
    (CLOCK_RATE_KW, "clock-rate"),
    (CODEL_KW, "codel"),
    (CODELS_REQUIRES_KW, "codels-require"),
    (CODELS_REQUIRES_KW, "codels-requires"),
    (COMPONENT_KW, "component"),
    (DELAY_KW, "delay"),
    (DOC_KW, "doc"),
    (EMAIL_KW, "email"),
    (EXCEPTION_KW, "exception"),
    (EXTENDS_KW, "extends"),
    (EXTENDS_KW, "extend"),
    (FUNCTION_KW, "function"),
    (IDS_KW, "ids"),
    (IN_KW, "in"),
    (INOUT_KW, "inout"),
    (INTERFACE_KW, "interface"),
    (INTERRUPTS_KW, "interrupts"),
    (INTERRUPTS_KW, "interrupt"),
    (K_KW, "k"),
    (LANG_KW, "lang"),
    (LOCAL_KW, "local"),
    (M_KW, "M"),
    (MS_KW, "ms"),
    (MULTIPLE_KW, "multiple"),
    (NATIVE_KW, "native"),
    (OUT_KW, "out"),
    (PAUSE_KW, "pause"),
    (PERIOD_KW, "period"),
    (PORT_KW, "port"),
    (PRIORITY_KW, "priority"),
    (PROVIDES_KW, "provides"),
    (PROVIDES_KW, "provide"),
    (REAL_TIME_KW, "real-time"),
    (REMOTE_KW, "remote"),
    (REQUIRES_KW, "require"),
    (REQUIRES_KW, "requires"),
    (S_KW, "s"),
    (SCHEDULING_KW, "scheduling"),
    (STACK_KW, "stack"),
    (TASK_KW, "task"),
    (THROWS_KW, "throw"),
    (THROWS_KW, "throws"),
    (US_KW, "us"),
    (USES_KW, "uses"),
    (USES_KW, "use"),
    (VALIDATE_KW, "validate"),
    (VERSION_KW, "version"),
    (WCET_KW, "wcet"),
    (YIELDS_KW, "yield"),
    (YIELDS_KW, "yields"),
];

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
        Some(match text {
            "activity" => ACTIVITY_KW,
            "after" => AFTER_KW,
            "async" => ASYNC_KW,
            "attribute" => ATTRIBUTE_KW,
            "before" => BEFORE_KW,
            "clock-rate" => CLOCK_RATE_KW,
            "codel" => CODEL_KW,
            "codels-require" | "codels-requires" => CODELS_REQUIRES_KW,
            "component" => COMPONENT_KW,
            "delay" => DELAY_KW,
            "doc" => DOC_KW,
            "email" => EMAIL_KW,
            "exception" => EXCEPTION_KW,
            "extend" | "extends" => EXTENDS_KW,
            "function" => FUNCTION_KW,
            "ids" => IDS_KW,
            "in" => IN_KW,
            "inout" => INOUT_KW,
            "interface" => INTERFACE_KW,
            "interrupt" | "interrupts" => INTERRUPTS_KW,
            "k" => K_KW,
            "lang" => LANG_KW,
            "local" => LOCAL_KW,
            "M" => M_KW,
            "ms" => MS_KW,
            "multiple" => MULTIPLE_KW,
            "native" => NATIVE_KW,
            "out" => OUT_KW,
            "pause" => PAUSE_KW,
            "period" => PERIOD_KW,
            "port" => PORT_KW,
            "priority" => PRIORITY_KW,
            "provide" | "provides" => PROVIDES_KW,
            "real-time" => REAL_TIME_KW,
            "remote" => REMOTE_KW,
            "require" | "requires" => REQUIRES_KW,
            "s" => S_KW,
            "scheduling" => SCHEDULING_KW,
            "stack" => STACK_KW,
            "task" => TASK_KW,
            "throw" | "throws" => THROWS_KW,
            "us" => US_KW,
            "use" | "uses" => USES_KW,
            "validate" => VALIDATE_KW,
            "version" => VERSION_KW,
            "wcet" => WCET_KW,
            "yield" | "yields" => YIELDS_KW,
            _ => return None,
        })
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
