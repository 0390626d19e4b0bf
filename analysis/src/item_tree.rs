//! Declarations of one file without positions.
//!
//! This is the incremental firewall. Editing a comment or a blank line gives an equal item tree, so dependent
//! queries are not computed again. Every node that other data may refer to has a [`Ptr`]; `lower` computes
//! [`ItemTree`] and the ranges of its pointers together.
//!
//! The item tree is a faithful, ordered transcription: it does no resolution and no checking. Text that could
//! not be parsed is left out (or is a `Missing` variant), so that one syntax error causes no second message.

pub mod lower;

use dotgen_syntax::SyntaxKind;
use smol_str::SmolStr;

use crate::model::{Name as Text, ParamDir, ServiceKind, SourceKind, TypeKind};

/// A node of an item tree: ordinal of the top-level item in its file, and ordinal inside the item.
///
/// Relative to the item, so that an edit in one component leaves the pointers of the others alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Ptr {
    /// Ordinal of the top-level item.
    pub item: u32,
    /// Ordinal inside the item, in text order.
    pub node: u32,
}

/// A name with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    /// As spelled (after macro expansion).
    pub text: Text,
    /// The token.
    pub ptr: Ptr,
}

/// The declarations of one file, or of the part of a body that an included file holds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ItemTree {
    /// In text order.
    pub items: Vec<Item>,
}

/// Any item of a specification, module, component, ids, struct or property body. The parser guarantees no
/// more about the place of an item than the grammar does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Item {
    /// `#include`, by ordinal among the include directives of the file that are active.
    Include {
        ordinal: u32,
        ptr: Ptr,
    },
    Pragma(Pragma),
    Module {
        name: Option<Name>,
        items: Vec<Item>,
        ptr: Ptr,
    },
    Const(ConstDecl),
    Typedef {
        ty: TypeRef,
        declarators: Vec<Declarator>,
        ptr: Ptr,
    },
    Native {
        name: Option<Name>,
        ptr: Ptr,
    },
    /// `exception a, b { … };`
    Exceptions {
        exceptions: Vec<ExceptionDecl>,
        ptr: Ptr,
    },
    /// A struct, union or enum declared as a statement.
    Type(Box<TypeDecl>),
    /// `struct s;` or `union u;`
    Forward {
        union: bool,
        name: Option<Name>,
        ptr: Ptr,
    },
    /// `component c { … };`; `body` is `None` for `component c;`.
    Component {
        interface: bool,
        name: Option<Name>,
        body: Option<Vec<Item>>,
        ptr: Ptr,
    },
    Property(Property),
    Ids {
        members: Vec<Item>,
        ptr: Ptr,
        /// The keyword `ids`, in the place of a name.
        keyword: Ptr,
    },
    Task {
        name: Option<Name>,
        properties: Vec<Item>,
        ptr: Ptr,
    },
    Port(PortDecl),
    Service(ServiceDecl),
    /// A member of a struct, exception or ids.
    Member {
        ty: TypeRef,
        declarators: Vec<Declarator>,
        ptr: Ptr,
    },
    /// A case of a union.
    Case {
        labels: Vec<CaseLabel>,
        ty: TypeRef,
        declarator: Option<Declarator>,
        ptr: Ptr,
    },
}

/// A `#pragma` that affects the specification.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Pragma {
    /// `#pragma requires "pkg >= v" …`
    Requires { arguments: Vec<(SmolStr, Ptr)>, ptr: Ptr },
    /// `#pragma provides i j`
    Provides { arguments: Vec<(SmolStr, Ptr)>, ptr: Ptr },
    /// `#pragma masquerade TEMPLATE TYPE DATA`
    Masquerade {
        arguments: Vec<(SmolStr, Ptr)>,
        /// The second argument as a path.
        ty: Option<Path>,
        ptr: Ptr,
    },
    /// `#pragma wcet CODEL DURATION [UNIT]`: codel name, then the duration as an expression.
    Wcet { codel: Option<Name>, duration: Option<Duration>, ptr: Ptr },
}

/// `const T N = V;`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConstDecl {
    pub ty: TypeRef,
    pub name: Option<Name>,
    pub value: Expr,
    pub ptr: Ptr,
}

/// `name[2][3]`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Declarator {
    pub name: Name,
    /// Outermost dimension first.
    pub dimensions: Vec<Expr>,
}

/// One exception; `members` is empty without body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExceptionDecl {
    pub name: Name,
    pub members: Vec<Item>,
}

/// A struct, union or enum with its body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TypeDecl {
    pub name: Option<Name>,
    pub kind: TypeDeclKind,
    pub ptr: Ptr,
}

/// See [`TypeDecl`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TypeDeclKind {
    Struct { members: Vec<Item> },
    Union { switch: TypeRef, cases: Vec<Item> },
    Enum { enumerators: Vec<Name> },
}

/// `case V:` or `default:` (`value` is `None`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CaseLabel {
    pub value: Option<Expr>,
    pub ptr: Ptr,
}

/// A type where it is used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TypeRef {
    /// The kind, as written.
    pub kind: TypeRefKind,
    /// The type specifier.
    pub ptr: Ptr,
}

/// See [`TypeRef`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TypeRefKind {
    /// A type without parts.
    Base(TypeKind),
    String {
        bound: Option<Expr>,
    },
    Sequence {
        element: Box<TypeRef>,
        bound: Option<Expr>,
    },
    Optional {
        element: Box<TypeRef>,
    },
    Fixed,
    Named(Path),
    Inline(Box<TypeDecl>),
    /// Not parsed; already reported.
    Missing,
}

/// `[::]a::b::c`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    /// Starts with `::`.
    pub absolute: bool,
    /// At least one.
    pub segments: Vec<Name>,
    /// The whole path.
    pub ptr: Ptr,
}

/// A constant expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Expr {
    /// The kind, as written.
    pub kind: ExprKind,
    /// The whole expression.
    pub ptr: Ptr,
}

/// See [`Expr`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ExprKind {
    Bool(bool),
    /// Literal text, suffix included.
    Int(SmolStr),
    /// Literal text, suffix included.
    Float(SmolStr),
    /// `1.5d`
    Fixed,
    /// Literal text, quotes included.
    Char(SmolStr),
    /// Literal tokens with quotes, in order (adjacent strings concatenate).
    Str(Vec<(SmolStr, Ptr)>),
    Path(Path),
    Paren(Box<Expr>),
    Unary {
        op: SyntaxKind,
        op_ptr: Ptr,
        operand: Box<Expr>,
    },
    Binary {
        op: SyntaxKind,
        op_ptr: Ptr,
        left: Box<Expr>,
        right: Box<Expr>,
    },
    /// Not parsed; already reported.
    Missing,
}

/// A number with an optional unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Duration {
    /// The number.
    pub value: Expr,
    /// The unit, with its place.
    pub unit: Option<(SyntaxKind, Ptr)>,
    /// The unit directly follows a number literal, without a blank (see deviation D29).
    pub glued: bool,
    /// The whole.
    pub ptr: Ptr,
}

/// One property. Any property may be written anywhere; the elaborator reports illegal places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Property {
    pub kind: PropertyKind,
    /// From its first token to its `;`.
    pub ptr: Ptr,
    pub keyword: Ptr,
}

/// See [`Property`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PropertyKind {
    Doc(Expr),
    Version(Expr),
    Lang(Expr),
    Email(Expr),
    Requires(Vec<Expr>),
    CodelsRequires(Vec<Expr>),
    ClockRate(Duration),
    Provides(Vec<Name>),
    Uses(Vec<Name>),
    Extends(Vec<Name>),
    Throws(Vec<Path>),
    Period(Duration),
    Delay(Duration),
    Priority(Expr),
    /// `scheduling real-time`
    Scheduling,
    Stack(Duration),
    Task(Option<Name>),
    Interrupts(Vec<Name>),
    Before(Vec<Name>),
    After(Vec<Name>),
    Validate(Box<CodelDecl>),
    Local {
        ty: TypeRef,
        declarators: Vec<Declarator>,
    },
    Codel(Box<CodelDecl>),
}

/// A port declaration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortDecl {
    pub multiple: bool,
    /// `None` if missing (a syntax error, already reported).
    pub out: Option<bool>,
    pub ty: TypeRef,
    pub name: Option<Name>,
    pub properties: Vec<Item>,
    pub ptr: Ptr,
    /// The `port` keyword.
    pub keyword: Ptr,
}

/// An attribute, function or activity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServiceDecl {
    pub kind: ServiceKind,
    pub name: Option<Name>,
    /// [`ParamSpec::Path`] for attributes, [`ParamSpec::Typed`] for the others.
    pub params: Vec<ParamDecl>,
    pub properties: Vec<Item>,
    pub ptr: Ptr,
}

/// A parameter of a service or codel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParamDecl {
    pub dir: ParamDir,
    pub spec: ParamSpec,
    /// `= initializer` (services only).
    pub init: Option<Box<Initializer>>,
    pub ptr: Ptr,
}

/// The data that a parameter names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ParamSpec {
    /// `in long a[2]`
    Typed {
        /// Declared type.
        ty: Box<TypeRef>,
        /// Name and dimensions; `None` if missing.
        declarator: Option<Box<Declarator>>,
    },
    /// `[source] in a.b[0]::renamed`, `in ::whole`
    Path {
        /// Explicit source, with its place.
        source: Option<(SourceKind, Ptr)>,
        /// Empty for `::name` alone.
        path: Vec<PathStep>,
        /// `::name`
        rename: Option<Box<Name>>,
    },
}

/// One step of a parameter path; the first is always a member.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PathStep {
    Member(Name),
    Index(Expr),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodelDecl {
    pub is_async: bool,
    pub name: Option<Name>,
    /// `Some` if it has `< >`, even if empty.
    pub triggers: Option<Vec<StateRef>>,
    pub params: Vec<ParamDecl>,
    pub yields: Option<Vec<StateRef>>,
    /// Every given execution time: `wcet` clauses and bare durations, in order. The elaborator reports more
    /// than one.
    pub wcet: Vec<WcetClause>,
    pub ptr: Ptr,
}

/// A state as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateRef {
    pub paused: bool,
    pub name: Name,
    /// With `pause::`.
    pub ptr: Ptr,
}

/// `wcet D unit`, or a bare duration after the yield list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WcetClause {
    /// Written without the word `wcet`.
    pub bare: bool,
    /// `None` if the value is missing.
    pub duration: Option<Duration>,
    /// The clause.
    pub ptr: Ptr,
}

/// A default value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Initializer {
    /// `.name =` or `[n] =`
    pub designator: Option<Designator>,
    /// The value, if any.
    pub value: Option<InitValue>,
    /// Documentation strings after `:`, concatenated in order.
    pub doc: Option<Expr>,
    /// The initializer.
    pub ptr: Ptr,
}

/// See [`Initializer`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Designator {
    Member(Name),
    Index(Expr),
}

/// See [`Initializer`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum InitValue {
    Scalar(Expr),
    Compound(Vec<Initializer>),
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of a thousand components has hundreds of declarations, and all are kept in memory.
    #[test]
    fn declarations_stay_small() {
        assert!(size_of::<Item>() <= 160, "{}", size_of::<Item>());
        assert!(size_of::<ParamDecl>() <= 72, "{}", size_of::<ParamDecl>());
        assert!(size_of::<CodelDecl>() <= 144, "{}", size_of::<CodelDecl>());
    }
}
