//! Syntax trees of models and queries. `at` is a byte offset in the text.

/// A name with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Name {
    pub(crate) at: u32,
    pub(crate) text: String,
}

#[derive(Debug, Clone)]
pub(crate) struct Expr {
    pub(crate) at: u32,
    /// Levels of the tree, which bounds the recursion of all that walks the tree.
    pub(crate) depth: u16,
    pub(crate) kind: ExprKind,
}

#[derive(Debug, Clone)]
pub(crate) enum ExprKind {
    Int(i32),
    Name(String),
    Field(Box<Expr>, String),
    Index(Box<Expr>, Box<Expr>),
    Call(String, Vec<Expr>),
    Not(Box<Expr>),
    Negate(Box<Expr>),
    Binary(Binary, Box<Expr>, Box<Expr>),
    /// Conjunction of any number of operands.
    All(Vec<Expr>),
    /// Disjunction of any number of operands.
    Any(Vec<Expr>),
    Choice(Box<[Expr; 3]>),
    /// Assignment. With an operator, a compound assignment.
    Assign(Option<Binary>, Box<Expr>, Box<Expr>),
    /// `++` or `--`: the difference, and whether the value is the one after the step.
    Step {
        delta: i32,
        prefix: bool,
        place: Box<Expr>,
    },
    Quantifier {
        all: bool,
        name: Name,
        ty: Box<TypeExpr>,
        body: Box<Expr>,
    },
    /// `x'`, the rate of a clock.
    Rate,
    Deadlock,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    And,
    Or,
    Xor,
    Left,
    Right,
    Min,
    Max,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}

#[derive(Debug, Clone)]
pub(crate) struct TypeExpr {
    pub(crate) at: u32,
    pub(crate) constant: bool,
    pub(crate) urgent: bool,
    pub(crate) broadcast: bool,
    pub(crate) base: BaseType,
}

#[derive(Debug, Clone)]
pub(crate) enum BaseType {
    /// With its bounds, if any.
    Int(Option<Box<(Expr, Expr)>>),
    Bool,
    Clock,
    Chan,
    Void,
    Named(String),
    Struct(Vec<(TypeExpr, Vec<Declarator>)>),
}

/// Length of one dimension of an array.
#[derive(Debug, Clone)]
pub(crate) enum Dimension {
    Length(Expr),
    Type(TypeExpr),
}

#[derive(Debug, Clone)]
pub(crate) struct Declarator {
    pub(crate) name: Name,
    pub(crate) dimensions: Vec<Dimension>,
    pub(crate) initial: Option<Initial>,
}

#[derive(Debug, Clone)]
pub(crate) enum Initial {
    Value(Expr),
    List(u32, Vec<Initial>),
}

#[derive(Debug, Clone)]
pub(crate) enum Declaration {
    Variables(TypeExpr, Vec<Declarator>),
    Typedef(TypeExpr, Vec<Declarator>),
    Function(Function),
    /// Channels by ascending priority. `None` is `default`.
    Priority(Vec<Vec<Option<Expr>>>),
}

#[derive(Debug, Clone)]
pub(crate) struct Parameter {
    pub(crate) ty: TypeExpr,
    pub(crate) reference: bool,
    pub(crate) declarator: Declarator,
}

#[derive(Debug, Clone)]
pub(crate) struct Function {
    pub(crate) result: TypeExpr,
    pub(crate) name: Name,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) body: Vec<Statement>,
}

#[derive(Debug, Clone)]
pub(crate) enum Statement {
    Declaration(TypeExpr, Vec<Declarator>),
    Expr(Expr),
    Block(Vec<Statement>),
    If(Expr, Box<Statement>, Option<Box<Statement>>),
    /// `while`, and `for` with its start and step. The flag is set if the body runs before the test.
    Loop {
        start: Vec<Expr>,
        test: Option<Expr>,
        step: Vec<Expr>,
        body: Box<Statement>,
        after: bool,
    },
    /// `for (name : type) body`
    Each {
        name: Name,
        ty: TypeExpr,
        body: Box<Statement>,
    },
    Return(u32, Option<Expr>),
}

#[derive(Debug, Clone)]
pub(crate) struct Location {
    pub(crate) name: Name,
    pub(crate) invariant: Option<Expr>,
}

#[derive(Debug, Clone)]
pub(crate) struct Edge {
    pub(crate) at: u32,
    pub(crate) source: Name,
    pub(crate) target: Name,
    pub(crate) selects: Vec<(Name, TypeExpr)>,
    pub(crate) guard: Option<Expr>,
    /// Channel, and whether the edge sends.
    pub(crate) sync: Option<(Expr, bool)>,
    pub(crate) assigns: Vec<Expr>,
}

/// A construct that parses but is not supported, such as the rate of a location.
#[derive(Debug, Clone)]
pub(crate) struct Refused {
    pub(crate) at: u32,
    pub(crate) message: &'static str,
}

#[derive(Debug, Clone)]
pub(crate) struct Process {
    pub(crate) name: Name,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) declarations: Vec<Declaration>,
    pub(crate) locations: Vec<Location>,
    pub(crate) committed: Vec<Name>,
    pub(crate) urgent: Vec<Name>,
    pub(crate) initial: Name,
    pub(crate) edges: Vec<Edge>,
    pub(crate) refused: Vec<Refused>,
}

#[derive(Debug, Clone)]
pub(crate) struct Instance {
    pub(crate) name: Name,
    pub(crate) template: Name,
    pub(crate) arguments: Vec<Expr>,
}

#[derive(Debug, Clone)]
pub(crate) enum Item {
    Declaration(Declaration),
    Process(Process),
    Instance(Instance),
}

#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) items: Vec<Item>,
    /// Processes by ascending priority.
    pub(crate) system: Vec<Vec<Name>>,
}

/// Form of a query.
#[derive(Debug, Clone)]
pub(crate) enum Form {
    /// `A[] p`
    Always(Expr),
    /// `E<> p`
    Reachable(Expr),
    /// `sup{p}: e, …`, or `inf`.
    Extremes { highest: bool, within: Option<Expr>, of: Vec<Expr> },
    /// A form that is not supported, with the reason.
    Refused(&'static str),
}
