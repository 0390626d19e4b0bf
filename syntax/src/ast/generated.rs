//! Typed nodes. Generated from `genom.ungram` by `ast/generator.rs`; do not edit.

use crate::{
    SyntaxKind::{self, *},
    SyntaxNode, SyntaxToken,
    ast::traits::{AstChildren, AstNode, support},
};

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SourceFile {
    syntax: SyntaxNode,
}
impl AstNode for SourceFile {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == SOURCE_FILE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl SourceFile {
    pub fn items(&self) -> AstChildren<Item> {
        support::children(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Item {
    Directive(Directive),
    Module(Module),
    ConstDecl(ConstDecl),
    TypedefDecl(TypedefDecl),
    NativeDecl(NativeDecl),
    ExceptionDecl(ExceptionDecl),
    TypeDecl(TypeDecl),
    ForwardDecl(ForwardDecl),
    Component(Component),
    Ids(Ids),
    Task(Task),
    Port(Port),
    Service(Service),
    Member(Member),
    Case(Case),
    Property(Property),
}
impl AstNode for Item {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == DIRECTIVE
            || kind == MODULE
            || kind == CONST_DECL
            || kind == TYPEDEF_DECL
            || kind == NATIVE_DECL
            || kind == EXCEPTION_DECL
            || kind == TYPE_DECL
            || kind == FORWARD_DECL
            || kind == COMPONENT
            || kind == IDS
            || kind == TASK
            || kind == PORT
            || kind == SERVICE
            || kind == MEMBER
            || kind == CASE
            || Property::can_cast(kind)
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        match syntax.kind() {
            DIRECTIVE => Directive::cast(syntax).map(Item::Directive),
            MODULE => Module::cast(syntax).map(Item::Module),
            CONST_DECL => ConstDecl::cast(syntax).map(Item::ConstDecl),
            TYPEDEF_DECL => TypedefDecl::cast(syntax).map(Item::TypedefDecl),
            NATIVE_DECL => NativeDecl::cast(syntax).map(Item::NativeDecl),
            EXCEPTION_DECL => ExceptionDecl::cast(syntax).map(Item::ExceptionDecl),
            TYPE_DECL => TypeDecl::cast(syntax).map(Item::TypeDecl),
            FORWARD_DECL => ForwardDecl::cast(syntax).map(Item::ForwardDecl),
            COMPONENT => Component::cast(syntax).map(Item::Component),
            IDS => Ids::cast(syntax).map(Item::Ids),
            TASK => Task::cast(syntax).map(Item::Task),
            PORT => Port::cast(syntax).map(Item::Port),
            SERVICE => Service::cast(syntax).map(Item::Service),
            MEMBER => Member::cast(syntax).map(Item::Member),
            CASE => Case::cast(syntax).map(Item::Case),
            kind if Property::can_cast(kind) => Property::cast(syntax).map(Item::Property),
            _ => None,
        }
    }
    fn syntax(&self) -> &SyntaxNode {
        match self {
            Item::Directive(node) => node.syntax(),
            Item::Module(node) => node.syntax(),
            Item::ConstDecl(node) => node.syntax(),
            Item::TypedefDecl(node) => node.syntax(),
            Item::NativeDecl(node) => node.syntax(),
            Item::ExceptionDecl(node) => node.syntax(),
            Item::TypeDecl(node) => node.syntax(),
            Item::ForwardDecl(node) => node.syntax(),
            Item::Component(node) => node.syntax(),
            Item::Ids(node) => node.syntax(),
            Item::Task(node) => node.syntax(),
            Item::Port(node) => node.syntax(),
            Item::Service(node) => node.syntax(),
            Item::Member(node) => node.syntax(),
            Item::Case(node) => node.syntax(),
            Item::Property(node) => node.syntax(),
        }
    }
}
impl From<Directive> for Item {
    fn from(node: Directive) -> Item {
        Item::Directive(node)
    }
}
impl From<Module> for Item {
    fn from(node: Module) -> Item {
        Item::Module(node)
    }
}
impl From<ConstDecl> for Item {
    fn from(node: ConstDecl) -> Item {
        Item::ConstDecl(node)
    }
}
impl From<TypedefDecl> for Item {
    fn from(node: TypedefDecl) -> Item {
        Item::TypedefDecl(node)
    }
}
impl From<NativeDecl> for Item {
    fn from(node: NativeDecl) -> Item {
        Item::NativeDecl(node)
    }
}
impl From<ExceptionDecl> for Item {
    fn from(node: ExceptionDecl) -> Item {
        Item::ExceptionDecl(node)
    }
}
impl From<TypeDecl> for Item {
    fn from(node: TypeDecl) -> Item {
        Item::TypeDecl(node)
    }
}
impl From<ForwardDecl> for Item {
    fn from(node: ForwardDecl) -> Item {
        Item::ForwardDecl(node)
    }
}
impl From<Component> for Item {
    fn from(node: Component) -> Item {
        Item::Component(node)
    }
}
impl From<Ids> for Item {
    fn from(node: Ids) -> Item {
        Item::Ids(node)
    }
}
impl From<Task> for Item {
    fn from(node: Task) -> Item {
        Item::Task(node)
    }
}
impl From<Port> for Item {
    fn from(node: Port) -> Item {
        Item::Port(node)
    }
}
impl From<Service> for Item {
    fn from(node: Service) -> Item {
        Item::Service(node)
    }
}
impl From<Member> for Item {
    fn from(node: Member) -> Item {
        Item::Member(node)
    }
}
impl From<Case> for Item {
    fn from(node: Case) -> Item {
        Item::Case(node)
    }
}
impl From<Property> for Item {
    fn from(node: Property) -> Item {
        Item::Property(node)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Body {
    syntax: SyntaxNode,
}
impl AstNode for Body {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == BODY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Body {
    pub fn l_curly_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_CURLY)
    }
    pub fn items(&self) -> AstChildren<Item> {
        support::children(&self.syntax)
    }
    pub fn r_curly_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_CURLY)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Directive {
    syntax: SyntaxNode,
}
impl AstNode for Directive {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == DIRECTIVE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Directive {
    pub fn hash_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, HASH)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(&self.syntax)
    }
    pub fn path(&self) -> Option<IncludePath> {
        support::child(&self.syntax)
    }
    pub fn params(&self) -> Option<MacroParams> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<MacroBody> {
        support::child(&self.syntax)
    }
    pub fn condition(&self) -> Option<Condition> {
        support::child(&self.syntax)
    }
    pub fn arguments(&self) -> AstChildren<PragmaArg> {
        support::children(&self.syntax)
    }
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(&self.syntax)
    }
    pub fn text(&self) -> Option<DirectiveText> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Module {
    syntax: SyntaxNode,
}
impl AstNode for Module {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MODULE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Module {
    pub fn module_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, MODULE_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ConstDecl {
    syntax: SyntaxNode,
}
impl AstNode for ConstDecl {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == CONST_DECL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ConstDecl {
    pub fn const_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, CONST_KW)
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn eq_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, EQ)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TypedefDecl {
    syntax: SyntaxNode,
}
impl AstNode for TypedefDecl {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == TYPEDEF_DECL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl TypedefDecl {
    pub fn typedef_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, TYPEDEF_KW)
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn declarators(&self) -> AstChildren<Declarator> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct NativeDecl {
    syntax: SyntaxNode,
}
impl AstNode for NativeDecl {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == NATIVE_DECL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl NativeDecl {
    pub fn native_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, NATIVE_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ExceptionDecl {
    syntax: SyntaxNode,
}
impl AstNode for ExceptionDecl {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == EXCEPTION_DECL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ExceptionDecl {
    pub fn exception_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, EXCEPTION_KW)
    }
    pub fn exceptions(&self) -> AstChildren<Exception> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TypeDecl {
    syntax: SyntaxNode,
}
impl AstNode for TypeDecl {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == TYPE_DECL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl TypeDecl {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ForwardDecl {
    syntax: SyntaxNode,
}
impl AstNode for ForwardDecl {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == FORWARD_DECL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ForwardDecl {
    pub fn struct_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, STRUCT_KW)
    }
    pub fn union_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, UNION_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Component {
    syntax: SyntaxNode,
}
impl AstNode for Component {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == COMPONENT
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Component {
    pub fn component_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, COMPONENT_KW)
    }
    pub fn interface_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, INTERFACE_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Ids {
    syntax: SyntaxNode,
}
impl AstNode for Ids {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == IDS
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Ids {
    pub fn ids_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, IDS_KW)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Task {
    syntax: SyntaxNode,
}
impl AstNode for Task {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == TASK
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Task {
    pub fn task_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, TASK_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Port {
    syntax: SyntaxNode,
}
impl AstNode for Port {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PORT
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Port {
    pub fn port_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, PORT_KW)
    }
    pub fn multiple_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, MULTIPLE_KW)
    }
    pub fn in_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, IN_KW)
    }
    pub fn out_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, OUT_KW)
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Service {
    syntax: SyntaxNode,
}
impl AstNode for Service {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == SERVICE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Service {
    pub fn attribute_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, ATTRIBUTE_KW)
    }
    pub fn function_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, FUNCTION_KW)
    }
    pub fn activity_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, ACTIVITY_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn param_list(&self) -> Option<ParamList> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Member {
    syntax: SyntaxNode,
}
impl AstNode for Member {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MEMBER
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Member {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn declarators(&self) -> AstChildren<Declarator> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Case {
    syntax: SyntaxNode,
}
impl AstNode for Case {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == CASE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Case {
    pub fn case_labels(&self) -> AstChildren<CaseLabel> {
        support::children(&self.syntax)
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn declarator(&self) -> Option<Declarator> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Property {
    StringProperty(StringProperty),
    RequiresProperty(RequiresProperty),
    DurationProperty(DurationProperty),
    InterfacesProperty(InterfacesProperty),
    ThrowsProperty(ThrowsProperty),
    PriorityProperty(PriorityProperty),
    SchedulingProperty(SchedulingProperty),
    StackProperty(StackProperty),
    TaskProperty(TaskProperty),
    ServicesProperty(ServicesProperty),
    ValidateProperty(ValidateProperty),
    LocalProperty(LocalProperty),
    CodelProperty(CodelProperty),
}
impl AstNode for Property {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == STRING_PROPERTY
            || kind == REQUIRES_PROPERTY
            || kind == DURATION_PROPERTY
            || kind == INTERFACES_PROPERTY
            || kind == THROWS_PROPERTY
            || kind == PRIORITY_PROPERTY
            || kind == SCHEDULING_PROPERTY
            || kind == STACK_PROPERTY
            || kind == TASK_PROPERTY
            || kind == SERVICES_PROPERTY
            || kind == VALIDATE_PROPERTY
            || kind == LOCAL_PROPERTY
            || kind == CODEL_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        match syntax.kind() {
            STRING_PROPERTY => StringProperty::cast(syntax).map(Property::StringProperty),
            REQUIRES_PROPERTY => RequiresProperty::cast(syntax).map(Property::RequiresProperty),
            DURATION_PROPERTY => DurationProperty::cast(syntax).map(Property::DurationProperty),
            INTERFACES_PROPERTY => {
                InterfacesProperty::cast(syntax).map(Property::InterfacesProperty)
            }
            THROWS_PROPERTY => ThrowsProperty::cast(syntax).map(Property::ThrowsProperty),
            PRIORITY_PROPERTY => PriorityProperty::cast(syntax).map(Property::PriorityProperty),
            SCHEDULING_PROPERTY => {
                SchedulingProperty::cast(syntax).map(Property::SchedulingProperty)
            }
            STACK_PROPERTY => StackProperty::cast(syntax).map(Property::StackProperty),
            TASK_PROPERTY => TaskProperty::cast(syntax).map(Property::TaskProperty),
            SERVICES_PROPERTY => ServicesProperty::cast(syntax).map(Property::ServicesProperty),
            VALIDATE_PROPERTY => ValidateProperty::cast(syntax).map(Property::ValidateProperty),
            LOCAL_PROPERTY => LocalProperty::cast(syntax).map(Property::LocalProperty),
            CODEL_PROPERTY => CodelProperty::cast(syntax).map(Property::CodelProperty),
            _ => None,
        }
    }
    fn syntax(&self) -> &SyntaxNode {
        match self {
            Property::StringProperty(node) => node.syntax(),
            Property::RequiresProperty(node) => node.syntax(),
            Property::DurationProperty(node) => node.syntax(),
            Property::InterfacesProperty(node) => node.syntax(),
            Property::ThrowsProperty(node) => node.syntax(),
            Property::PriorityProperty(node) => node.syntax(),
            Property::SchedulingProperty(node) => node.syntax(),
            Property::StackProperty(node) => node.syntax(),
            Property::TaskProperty(node) => node.syntax(),
            Property::ServicesProperty(node) => node.syntax(),
            Property::ValidateProperty(node) => node.syntax(),
            Property::LocalProperty(node) => node.syntax(),
            Property::CodelProperty(node) => node.syntax(),
        }
    }
}
impl From<StringProperty> for Property {
    fn from(node: StringProperty) -> Property {
        Property::StringProperty(node)
    }
}
impl From<RequiresProperty> for Property {
    fn from(node: RequiresProperty) -> Property {
        Property::RequiresProperty(node)
    }
}
impl From<DurationProperty> for Property {
    fn from(node: DurationProperty) -> Property {
        Property::DurationProperty(node)
    }
}
impl From<InterfacesProperty> for Property {
    fn from(node: InterfacesProperty) -> Property {
        Property::InterfacesProperty(node)
    }
}
impl From<ThrowsProperty> for Property {
    fn from(node: ThrowsProperty) -> Property {
        Property::ThrowsProperty(node)
    }
}
impl From<PriorityProperty> for Property {
    fn from(node: PriorityProperty) -> Property {
        Property::PriorityProperty(node)
    }
}
impl From<SchedulingProperty> for Property {
    fn from(node: SchedulingProperty) -> Property {
        Property::SchedulingProperty(node)
    }
}
impl From<StackProperty> for Property {
    fn from(node: StackProperty) -> Property {
        Property::StackProperty(node)
    }
}
impl From<TaskProperty> for Property {
    fn from(node: TaskProperty) -> Property {
        Property::TaskProperty(node)
    }
}
impl From<ServicesProperty> for Property {
    fn from(node: ServicesProperty) -> Property {
        Property::ServicesProperty(node)
    }
}
impl From<ValidateProperty> for Property {
    fn from(node: ValidateProperty) -> Property {
        Property::ValidateProperty(node)
    }
}
impl From<LocalProperty> for Property {
    fn from(node: LocalProperty) -> Property {
        Property::LocalProperty(node)
    }
}
impl From<CodelProperty> for Property {
    fn from(node: CodelProperty) -> Property {
        Property::CodelProperty(node)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Name {
    syntax: SyntaxNode,
}
impl AstNode for Name {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == NAME
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Name {
    pub fn ident_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, IDENT)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct NameRef {
    syntax: SyntaxNode,
}
impl AstNode for NameRef {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == NAME_REF
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl NameRef {
    pub fn ident_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, IDENT)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Path {
    syntax: SyntaxNode,
}
impl AstNode for Path {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PATH
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Path {
    pub fn colon2_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, COLON2)
    }
    pub fn segments(&self) -> AstChildren<NameRef> {
        support::children(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum TypeSpec {
    BaseType(BaseType),
    StringType(StringType),
    SequenceType(SequenceType),
    OptionalType(OptionalType),
    FixedType(FixedType),
    NamedType(NamedType),
    Struct(Struct),
    Union(Union),
    Enum(Enum),
}
impl AstNode for TypeSpec {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == BASE_TYPE
            || kind == STRING_TYPE
            || kind == SEQUENCE_TYPE
            || kind == OPTIONAL_TYPE
            || kind == FIXED_TYPE
            || kind == NAMED_TYPE
            || kind == STRUCT
            || kind == UNION
            || kind == ENUM
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        match syntax.kind() {
            BASE_TYPE => BaseType::cast(syntax).map(TypeSpec::BaseType),
            STRING_TYPE => StringType::cast(syntax).map(TypeSpec::StringType),
            SEQUENCE_TYPE => SequenceType::cast(syntax).map(TypeSpec::SequenceType),
            OPTIONAL_TYPE => OptionalType::cast(syntax).map(TypeSpec::OptionalType),
            FIXED_TYPE => FixedType::cast(syntax).map(TypeSpec::FixedType),
            NAMED_TYPE => NamedType::cast(syntax).map(TypeSpec::NamedType),
            STRUCT => Struct::cast(syntax).map(TypeSpec::Struct),
            UNION => Union::cast(syntax).map(TypeSpec::Union),
            ENUM => Enum::cast(syntax).map(TypeSpec::Enum),
            _ => None,
        }
    }
    fn syntax(&self) -> &SyntaxNode {
        match self {
            TypeSpec::BaseType(node) => node.syntax(),
            TypeSpec::StringType(node) => node.syntax(),
            TypeSpec::SequenceType(node) => node.syntax(),
            TypeSpec::OptionalType(node) => node.syntax(),
            TypeSpec::FixedType(node) => node.syntax(),
            TypeSpec::NamedType(node) => node.syntax(),
            TypeSpec::Struct(node) => node.syntax(),
            TypeSpec::Union(node) => node.syntax(),
            TypeSpec::Enum(node) => node.syntax(),
        }
    }
}
impl From<BaseType> for TypeSpec {
    fn from(node: BaseType) -> TypeSpec {
        TypeSpec::BaseType(node)
    }
}
impl From<StringType> for TypeSpec {
    fn from(node: StringType) -> TypeSpec {
        TypeSpec::StringType(node)
    }
}
impl From<SequenceType> for TypeSpec {
    fn from(node: SequenceType) -> TypeSpec {
        TypeSpec::SequenceType(node)
    }
}
impl From<OptionalType> for TypeSpec {
    fn from(node: OptionalType) -> TypeSpec {
        TypeSpec::OptionalType(node)
    }
}
impl From<FixedType> for TypeSpec {
    fn from(node: FixedType) -> TypeSpec {
        TypeSpec::FixedType(node)
    }
}
impl From<NamedType> for TypeSpec {
    fn from(node: NamedType) -> TypeSpec {
        TypeSpec::NamedType(node)
    }
}
impl From<Struct> for TypeSpec {
    fn from(node: Struct) -> TypeSpec {
        TypeSpec::Struct(node)
    }
}
impl From<Union> for TypeSpec {
    fn from(node: Union) -> TypeSpec {
        TypeSpec::Union(node)
    }
}
impl From<Enum> for TypeSpec {
    fn from(node: Enum) -> TypeSpec {
        TypeSpec::Enum(node)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Expr {
    Literal(Literal),
    PathExpr(PathExpr),
    ParenExpr(ParenExpr),
    PrefixExpr(PrefixExpr),
    BinaryExpr(BinaryExpr),
}
impl AstNode for Expr {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == LITERAL
            || kind == PATH_EXPR
            || kind == PAREN_EXPR
            || kind == PREFIX_EXPR
            || kind == BINARY_EXPR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        match syntax.kind() {
            LITERAL => Literal::cast(syntax).map(Expr::Literal),
            PATH_EXPR => PathExpr::cast(syntax).map(Expr::PathExpr),
            PAREN_EXPR => ParenExpr::cast(syntax).map(Expr::ParenExpr),
            PREFIX_EXPR => PrefixExpr::cast(syntax).map(Expr::PrefixExpr),
            BINARY_EXPR => BinaryExpr::cast(syntax).map(Expr::BinaryExpr),
            _ => None,
        }
    }
    fn syntax(&self) -> &SyntaxNode {
        match self {
            Expr::Literal(node) => node.syntax(),
            Expr::PathExpr(node) => node.syntax(),
            Expr::ParenExpr(node) => node.syntax(),
            Expr::PrefixExpr(node) => node.syntax(),
            Expr::BinaryExpr(node) => node.syntax(),
        }
    }
}
impl From<Literal> for Expr {
    fn from(node: Literal) -> Expr {
        Expr::Literal(node)
    }
}
impl From<PathExpr> for Expr {
    fn from(node: PathExpr) -> Expr {
        Expr::PathExpr(node)
    }
}
impl From<ParenExpr> for Expr {
    fn from(node: ParenExpr) -> Expr {
        Expr::ParenExpr(node)
    }
}
impl From<PrefixExpr> for Expr {
    fn from(node: PrefixExpr) -> Expr {
        Expr::PrefixExpr(node)
    }
}
impl From<BinaryExpr> for Expr {
    fn from(node: BinaryExpr) -> Expr {
        Expr::BinaryExpr(node)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Declarator {
    syntax: SyntaxNode,
}
impl AstNode for Declarator {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == DECLARATOR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Declarator {
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn dimensions(&self) -> AstChildren<Dimension> {
        support::children(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Exception {
    syntax: SyntaxNode,
}
impl AstNode for Exception {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == EXCEPTION
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Exception {
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CaseLabel {
    syntax: SyntaxNode,
}
impl AstNode for CaseLabel {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == CASE_LABEL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl CaseLabel {
    pub fn case_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, CASE_KW)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn colon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, COLON)
    }
    pub fn default_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, DEFAULT_KW)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Dimension {
    syntax: SyntaxNode,
}
impl AstNode for Dimension {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == DIMENSION
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Dimension {
    pub fn l_brack_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_BRACK)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn r_brack_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_BRACK)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct BaseType {
    syntax: SyntaxNode,
}
impl AstNode for BaseType {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == BASE_TYPE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl BaseType {
    pub fn unsigned_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, UNSIGNED_KW)
    }
    pub fn boolean_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, BOOLEAN_KW)
    }
    pub fn octet_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, OCTET_KW)
    }
    pub fn char_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, CHAR_KW)
    }
    pub fn any_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, ANY_KW)
    }
    pub fn float_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, FLOAT_KW)
    }
    pub fn double_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, DOUBLE_KW)
    }
    pub fn short_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SHORT_KW)
    }
    pub fn long_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, LONG_KW)
    }
    pub fn wchar_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, WCHAR_KW)
    }
    pub fn wstring_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, WSTRING_KW)
    }
    pub fn object_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, OBJECT_KW)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct StringType {
    syntax: SyntaxNode,
}
impl AstNode for StringType {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == STRING_TYPE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl StringType {
    pub fn string_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, STRING_KW)
    }
    pub fn l_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_ANGLE)
    }
    pub fn bound(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn r_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_ANGLE)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SequenceType {
    syntax: SyntaxNode,
}
impl AstNode for SequenceType {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == SEQUENCE_TYPE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl SequenceType {
    pub fn sequence_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEQUENCE_KW)
    }
    pub fn l_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_ANGLE)
    }
    pub fn element(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn comma_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, COMMA)
    }
    pub fn bound(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn r_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_ANGLE)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct OptionalType {
    syntax: SyntaxNode,
}
impl AstNode for OptionalType {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == OPTIONAL_TYPE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl OptionalType {
    pub fn optional_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, OPTIONAL_KW)
    }
    pub fn l_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_ANGLE)
    }
    pub fn element(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn r_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_ANGLE)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FixedType {
    syntax: SyntaxNode,
}
impl AstNode for FixedType {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == FIXED_TYPE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl FixedType {
    pub fn fixed_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, FIXED_KW)
    }
    pub fn l_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_ANGLE)
    }
    pub fn exprs(&self) -> AstChildren<Expr> {
        support::children(&self.syntax)
    }
    pub fn r_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_ANGLE)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct NamedType {
    syntax: SyntaxNode,
}
impl AstNode for NamedType {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == NAMED_TYPE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl NamedType {
    pub fn path(&self) -> Option<Path> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Struct {
    syntax: SyntaxNode,
}
impl AstNode for Struct {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == STRUCT
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Struct {
    pub fn struct_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, STRUCT_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Union {
    syntax: SyntaxNode,
}
impl AstNode for Union {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == UNION
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Union {
    pub fn union_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, UNION_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn switch_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SWITCH_KW)
    }
    pub fn l_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_PAREN)
    }
    pub fn switch_type(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn r_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_PAREN)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Enum {
    syntax: SyntaxNode,
}
impl AstNode for Enum {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == ENUM
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Enum {
    pub fn enum_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, ENUM_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn enumerator_list(&self) -> Option<EnumeratorList> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct EnumeratorList {
    syntax: SyntaxNode,
}
impl AstNode for EnumeratorList {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == ENUMERATOR_LIST
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl EnumeratorList {
    pub fn l_curly_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_CURLY)
    }
    pub fn enumerators(&self) -> AstChildren<Enumerator> {
        support::children(&self.syntax)
    }
    pub fn r_curly_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_CURLY)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Enumerator {
    syntax: SyntaxNode,
}
impl AstNode for Enumerator {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == ENUMERATOR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Enumerator {
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Literal {
    syntax: SyntaxNode,
}
impl AstNode for Literal {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == LITERAL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Literal {
    pub fn true_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, TRUE_KW)
    }
    pub fn false_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, FALSE_KW)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PathExpr {
    syntax: SyntaxNode,
}
impl AstNode for PathExpr {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PATH_EXPR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl PathExpr {
    pub fn path(&self) -> Option<Path> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ParenExpr {
    syntax: SyntaxNode,
}
impl AstNode for ParenExpr {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PAREN_EXPR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ParenExpr {
    pub fn l_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_PAREN)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn r_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_PAREN)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PrefixExpr {
    syntax: SyntaxNode,
}
impl AstNode for PrefixExpr {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PREFIX_EXPR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl PrefixExpr {
    pub fn minus_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, MINUS)
    }
    pub fn plus_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, PLUS)
    }
    pub fn tilde_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, TILDE)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct BinaryExpr {
    syntax: SyntaxNode,
}
impl AstNode for BinaryExpr {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == BINARY_EXPR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl BinaryExpr {
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ParamList {
    syntax: SyntaxNode,
}
impl AstNode for ParamList {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PARAM_LIST
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ParamList {
    pub fn l_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_PAREN)
    }
    pub fn params(&self) -> AstChildren<Param> {
        support::children(&self.syntax)
    }
    pub fn r_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_PAREN)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct StringProperty {
    syntax: SyntaxNode,
}
impl AstNode for StringProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == STRING_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl StringProperty {
    pub fn doc_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, DOC_KW)
    }
    pub fn version_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, VERSION_KW)
    }
    pub fn lang_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, LANG_KW)
    }
    pub fn email_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, EMAIL_KW)
    }
    pub fn value(&self) -> Option<Literal> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct RequiresProperty {
    syntax: SyntaxNode,
}
impl AstNode for RequiresProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == REQUIRES_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl RequiresProperty {
    pub fn requires_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, REQUIRES_KW)
    }
    pub fn codels_requires_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, CODELS_REQUIRES_KW)
    }
    pub fn values(&self) -> AstChildren<Literal> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct DurationProperty {
    syntax: SyntaxNode,
}
impl AstNode for DurationProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == DURATION_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl DurationProperty {
    pub fn clock_rate_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, CLOCK_RATE_KW)
    }
    pub fn period_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, PERIOD_KW)
    }
    pub fn delay_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, DELAY_KW)
    }
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct InterfacesProperty {
    syntax: SyntaxNode,
}
impl AstNode for InterfacesProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INTERFACES_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl InterfacesProperty {
    pub fn provides_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, PROVIDES_KW)
    }
    pub fn uses_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, USES_KW)
    }
    pub fn extends_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, EXTENDS_KW)
    }
    pub fn name_refs(&self) -> AstChildren<NameRef> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ThrowsProperty {
    syntax: SyntaxNode,
}
impl AstNode for ThrowsProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == THROWS_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ThrowsProperty {
    pub fn throws_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, THROWS_KW)
    }
    pub fn paths(&self) -> AstChildren<Path> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PriorityProperty {
    syntax: SyntaxNode,
}
impl AstNode for PriorityProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PRIORITY_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl PriorityProperty {
    pub fn priority_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, PRIORITY_KW)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SchedulingProperty {
    syntax: SyntaxNode,
}
impl AstNode for SchedulingProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == SCHEDULING_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl SchedulingProperty {
    pub fn scheduling_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SCHEDULING_KW)
    }
    pub fn real_time_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, REAL_TIME_KW)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct StackProperty {
    syntax: SyntaxNode,
}
impl AstNode for StackProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == STACK_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl StackProperty {
    pub fn stack_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, STACK_KW)
    }
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TaskProperty {
    syntax: SyntaxNode,
}
impl AstNode for TaskProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == TASK_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl TaskProperty {
    pub fn task_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, TASK_KW)
    }
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ServicesProperty {
    syntax: SyntaxNode,
}
impl AstNode for ServicesProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == SERVICES_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ServicesProperty {
    pub fn interrupts_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, INTERRUPTS_KW)
    }
    pub fn before_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, BEFORE_KW)
    }
    pub fn after_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, AFTER_KW)
    }
    pub fn name_refs(&self) -> AstChildren<NameRef> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ValidateProperty {
    syntax: SyntaxNode,
}
impl AstNode for ValidateProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == VALIDATE_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ValidateProperty {
    pub fn validate_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, VALIDATE_KW)
    }
    pub fn codel(&self) -> Option<Codel> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LocalProperty {
    syntax: SyntaxNode,
}
impl AstNode for LocalProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == LOCAL_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl LocalProperty {
    pub fn local_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, LOCAL_KW)
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn declarators(&self) -> AstChildren<Declarator> {
        support::children(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CodelProperty {
    syntax: SyntaxNode,
}
impl AstNode for CodelProperty {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == CODEL_PROPERTY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl CodelProperty {
    pub fn async_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, ASYNC_KW)
    }
    pub fn codel_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, CODEL_KW)
    }
    pub fn codel(&self) -> Option<Codel> {
        support::child(&self.syntax)
    }
    pub fn semicolon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, SEMICOLON)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Quantity {
    syntax: SyntaxNode,
}
impl AstNode for Quantity {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == QUANTITY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Quantity {
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn s_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, S_KW)
    }
    pub fn ms_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, MS_KW)
    }
    pub fn us_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, US_KW)
    }
    pub fn k_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, K_KW)
    }
    pub fn m_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, M_KW)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Codel {
    syntax: SyntaxNode,
}
impl AstNode for Codel {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == CODEL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Codel {
    pub fn triggers(&self) -> Option<Triggers> {
        support::child(&self.syntax)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
    pub fn param_list(&self) -> Option<ParamList> {
        support::child(&self.syntax)
    }
    pub fn yields(&self) -> Option<Yields> {
        support::child(&self.syntax)
    }
    pub fn wcets(&self) -> AstChildren<Wcet> {
        support::children(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Triggers {
    syntax: SyntaxNode,
}
impl AstNode for Triggers {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == TRIGGERS
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Triggers {
    pub fn l_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_ANGLE)
    }
    pub fn states(&self) -> AstChildren<State> {
        support::children(&self.syntax)
    }
    pub fn r_angle_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_ANGLE)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Yields {
    syntax: SyntaxNode,
}
impl AstNode for Yields {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == YIELDS
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Yields {
    pub fn yields_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, YIELDS_KW)
    }
    pub fn states(&self) -> AstChildren<State> {
        support::children(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Wcet {
    syntax: SyntaxNode,
}
impl AstNode for Wcet {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == WCET
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Wcet {
    pub fn wcet_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, WCET_KW)
    }
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct State {
    syntax: SyntaxNode,
}
impl AstNode for State {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == STATE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl State {
    pub fn pause_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, PAUSE_KW)
    }
    pub fn colon2_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, COLON2)
    }
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Param {
    TypedParam(TypedParam),
    PathParam(PathParam),
}
impl AstNode for Param {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == TYPED_PARAM || kind == PATH_PARAM
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        match syntax.kind() {
            TYPED_PARAM => TypedParam::cast(syntax).map(Param::TypedParam),
            PATH_PARAM => PathParam::cast(syntax).map(Param::PathParam),
            _ => None,
        }
    }
    fn syntax(&self) -> &SyntaxNode {
        match self {
            Param::TypedParam(node) => node.syntax(),
            Param::PathParam(node) => node.syntax(),
        }
    }
}
impl From<TypedParam> for Param {
    fn from(node: TypedParam) -> Param {
        Param::TypedParam(node)
    }
}
impl From<PathParam> for Param {
    fn from(node: PathParam) -> Param {
        Param::PathParam(node)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TypedParam {
    syntax: SyntaxNode,
}
impl AstNode for TypedParam {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == TYPED_PARAM
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl TypedParam {
    pub fn in_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, IN_KW)
    }
    pub fn out_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, OUT_KW)
    }
    pub fn inout_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, INOUT_KW)
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(&self.syntax)
    }
    pub fn declarator(&self) -> Option<Declarator> {
        support::child(&self.syntax)
    }
    pub fn eq_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, EQ)
    }
    pub fn initializer(&self) -> Option<Initializer> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PathParam {
    syntax: SyntaxNode,
}
impl AstNode for PathParam {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PATH_PARAM
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl PathParam {
    pub fn ids_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, IDS_KW)
    }
    pub fn local_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, LOCAL_KW)
    }
    pub fn port_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, PORT_KW)
    }
    pub fn remote_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, REMOTE_KW)
    }
    pub fn in_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, IN_KW)
    }
    pub fn out_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, OUT_KW)
    }
    pub fn inout_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, INOUT_KW)
    }
    pub fn path(&self) -> Option<ParamPath> {
        support::child(&self.syntax)
    }
    pub fn rename(&self) -> Option<Rename> {
        support::child(&self.syntax)
    }
    pub fn eq_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, EQ)
    }
    pub fn initializer(&self) -> Option<Initializer> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Initializer {
    syntax: SyntaxNode,
}
impl AstNode for Initializer {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INITIALIZER
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Initializer {
    pub fn designator(&self) -> Option<Designator> {
        support::child(&self.syntax)
    }
    pub fn eq_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, EQ)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn initializer_list(&self) -> Option<InitializerList> {
        support::child(&self.syntax)
    }
    pub fn doc(&self) -> Option<InitializerDoc> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ParamPath {
    syntax: SyntaxNode,
}
impl AstNode for ParamPath {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PARAM_PATH
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl ParamPath {
    pub fn steps(&self) -> AstChildren<PathStep> {
        support::children(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Rename {
    syntax: SyntaxNode,
}
impl AstNode for Rename {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == RENAME
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl Rename {
    pub fn colon2_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, COLON2)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum PathStep {
    MemberStep(MemberStep),
    IndexStep(IndexStep),
}
impl AstNode for PathStep {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MEMBER_STEP || kind == INDEX_STEP
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        match syntax.kind() {
            MEMBER_STEP => MemberStep::cast(syntax).map(PathStep::MemberStep),
            INDEX_STEP => IndexStep::cast(syntax).map(PathStep::IndexStep),
            _ => None,
        }
    }
    fn syntax(&self) -> &SyntaxNode {
        match self {
            PathStep::MemberStep(node) => node.syntax(),
            PathStep::IndexStep(node) => node.syntax(),
        }
    }
}
impl From<MemberStep> for PathStep {
    fn from(node: MemberStep) -> PathStep {
        PathStep::MemberStep(node)
    }
}
impl From<IndexStep> for PathStep {
    fn from(node: IndexStep) -> PathStep {
        PathStep::IndexStep(node)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MemberStep {
    syntax: SyntaxNode,
}
impl AstNode for MemberStep {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MEMBER_STEP
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl MemberStep {
    pub fn dot_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, DOT)
    }
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct IndexStep {
    syntax: SyntaxNode,
}
impl AstNode for IndexStep {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INDEX_STEP
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl IndexStep {
    pub fn l_brack_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_BRACK)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn r_brack_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_BRACK)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Designator {
    MemberDesignator(MemberDesignator),
    IndexDesignator(IndexDesignator),
}
impl AstNode for Designator {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MEMBER_DESIGNATOR || kind == INDEX_DESIGNATOR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        match syntax.kind() {
            MEMBER_DESIGNATOR => MemberDesignator::cast(syntax).map(Designator::MemberDesignator),
            INDEX_DESIGNATOR => IndexDesignator::cast(syntax).map(Designator::IndexDesignator),
            _ => None,
        }
    }
    fn syntax(&self) -> &SyntaxNode {
        match self {
            Designator::MemberDesignator(node) => node.syntax(),
            Designator::IndexDesignator(node) => node.syntax(),
        }
    }
}
impl From<MemberDesignator> for Designator {
    fn from(node: MemberDesignator) -> Designator {
        Designator::MemberDesignator(node)
    }
}
impl From<IndexDesignator> for Designator {
    fn from(node: IndexDesignator) -> Designator {
        Designator::IndexDesignator(node)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct InitializerList {
    syntax: SyntaxNode,
}
impl AstNode for InitializerList {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INITIALIZER_LIST
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl InitializerList {
    pub fn l_curly_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_CURLY)
    }
    pub fn initializers(&self) -> AstChildren<Initializer> {
        support::children(&self.syntax)
    }
    pub fn r_curly_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_CURLY)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct InitializerDoc {
    syntax: SyntaxNode,
}
impl AstNode for InitializerDoc {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INITIALIZER_DOC
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl InitializerDoc {
    pub fn colon_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, COLON)
    }
    pub fn text(&self) -> Option<Literal> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MemberDesignator {
    syntax: SyntaxNode,
}
impl AstNode for MemberDesignator {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MEMBER_DESIGNATOR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl MemberDesignator {
    pub fn dot_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, DOT)
    }
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(&self.syntax)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct IndexDesignator {
    syntax: SyntaxNode,
}
impl AstNode for IndexDesignator {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INDEX_DESIGNATOR
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl IndexDesignator {
    pub fn l_brack_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_BRACK)
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(&self.syntax)
    }
    pub fn r_brack_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_BRACK)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct IncludePath {
    syntax: SyntaxNode,
}
impl AstNode for IncludePath {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INCLUDE_PATH
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MacroParams {
    syntax: SyntaxNode,
}
impl AstNode for MacroParams {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MACRO_PARAMS
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl MacroParams {
    pub fn l_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, L_PAREN)
    }
    pub fn name_refs(&self) -> AstChildren<NameRef> {
        support::children(&self.syntax)
    }
    pub fn r_paren_token(&self) -> Option<SyntaxToken> {
        support::token(&self.syntax, R_PAREN)
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MacroBody {
    syntax: SyntaxNode,
}
impl AstNode for MacroBody {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MACRO_BODY
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Condition {
    syntax: SyntaxNode,
}
impl AstNode for Condition {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == CONDITION
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PragmaArg {
    syntax: SyntaxNode,
}
impl AstNode for PragmaArg {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == PRAGMA_ARG
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct DirectiveText {
    syntax: SyntaxNode,
}
impl AstNode for DirectiveText {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == DIRECTIVE_TEXT
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Inactive {
    syntax: SyntaxNode,
}
impl AstNode for Inactive {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == INACTIVE
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MacroCall {
    syntax: SyntaxNode,
}
impl AstNode for MacroCall {
    fn can_cast(kind: SyntaxKind) -> bool {
        kind == MACRO_CALL
    }
    fn cast(syntax: SyntaxNode) -> Option<Self> {
        Self::can_cast(syntax.kind()).then_some(Self { syntax })
    }
    fn syntax(&self) -> &SyntaxNode {
        &self.syntax
    }
}
impl MacroCall {
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(&self.syntax)
    }
}
