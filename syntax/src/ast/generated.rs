//! Typed nodes. Generated from `genom.ungram` by `ast/generator.rs`; do not edit.

use crate::{
    SyntaxKind::*,
    SyntaxToken,
    ast::traits::{AstChildren, AstNode, choice, node, support},
};

node! { SourceFile: SOURCE_FILE }
impl SourceFile {
    pub fn items(&self) -> AstChildren<Item> {
        support::children(self.syntax())
    }
}

choice! { Item: Directive, Module, ConstDecl, TypedefDecl, NativeDecl, ExceptionDecl, TypeDecl, ForwardDecl, Component, Ids, Task, Port, Service, Member, Case, Property }

node! { Body: BODY }
impl Body {
    pub fn items(&self) -> AstChildren<Item> {
        support::children(self.syntax())
    }
}

node! { Directive: DIRECTIVE }
impl Directive {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(self.syntax())
    }
    pub fn path(&self) -> Option<IncludePath> {
        support::child(self.syntax())
    }
    pub fn params(&self) -> Option<MacroParams> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<MacroBody> {
        support::child(self.syntax())
    }
    pub fn condition(&self) -> Option<Condition> {
        support::child(self.syntax())
    }
    pub fn arguments(&self) -> AstChildren<PragmaArg> {
        support::children(self.syntax())
    }
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(self.syntax())
    }
    pub fn text(&self) -> Option<DirectiveText> {
        support::child(self.syntax())
    }
}

node! { Module: MODULE }
impl Module {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { ConstDecl: CONST_DECL }
impl ConstDecl {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { TypedefDecl: TYPEDEF_DECL }
impl TypedefDecl {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn declarators(&self) -> AstChildren<Declarator> {
        support::children(self.syntax())
    }
}

node! { NativeDecl: NATIVE_DECL }
impl NativeDecl {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
}

node! { ExceptionDecl: EXCEPTION_DECL }
impl ExceptionDecl {
    pub fn exceptions(&self) -> AstChildren<Exception> {
        support::children(self.syntax())
    }
}

node! { TypeDecl: TYPE_DECL }
impl TypeDecl {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
}

node! { ForwardDecl: FORWARD_DECL }
impl ForwardDecl {
    pub fn union_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), UNION_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
}

node! { Component: COMPONENT }
impl Component {
    pub fn interface_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), INTERFACE_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { Ids: IDS }
impl Ids {
    pub fn ids_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), IDS_KW)
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { Task: TASK }
impl Task {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { Port: PORT }
impl Port {
    pub fn port_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), PORT_KW)
    }
    pub fn multiple_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), MULTIPLE_KW)
    }
    pub fn in_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), IN_KW)
    }
    pub fn out_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), OUT_KW)
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { Service: SERVICE }
impl Service {
    pub fn attribute_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), ATTRIBUTE_KW)
    }
    pub fn function_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), FUNCTION_KW)
    }
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn param_list(&self) -> Option<ParamList> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { Member: MEMBER }
impl Member {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn declarators(&self) -> AstChildren<Declarator> {
        support::children(self.syntax())
    }
}

node! { Case: CASE }
impl Case {
    pub fn case_labels(&self) -> AstChildren<CaseLabel> {
        support::children(self.syntax())
    }
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn declarator(&self) -> Option<Declarator> {
        support::child(self.syntax())
    }
}

choice! { Property: StringProperty, RequiresProperty, DurationProperty, InterfacesProperty, ThrowsProperty, PriorityProperty, SchedulingProperty, StackProperty, TaskProperty, ServicesProperty, ValidateProperty, LocalProperty, CodelProperty }

node! { Name: NAME }
impl Name {
    pub fn ident_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), IDENT)
    }
}

node! { NameRef: NAME_REF }
impl NameRef {
    pub fn ident_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), IDENT)
    }
}

node! { Path: PATH }
impl Path {
    pub fn segments(&self) -> AstChildren<NameRef> {
        support::children(self.syntax())
    }
}

choice! { TypeSpec: BaseType, StringType, SequenceType, OptionalType, FixedType, NamedType, Struct, Union, Enum }

choice! { Expr: Literal, PathExpr, ParenExpr, PrefixExpr, BinaryExpr }

node! { Declarator: DECLARATOR }
impl Declarator {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn dimensions(&self) -> AstChildren<Dimension> {
        support::children(self.syntax())
    }
}

node! { Exception: EXCEPTION }
impl Exception {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { CaseLabel: CASE_LABEL }
impl CaseLabel {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
    pub fn default_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), DEFAULT_KW)
    }
}

node! { Dimension: DIMENSION }
impl Dimension {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { BaseType: BASE_TYPE }
node! { StringType: STRING_TYPE }
impl StringType {
    pub fn bound(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { SequenceType: SEQUENCE_TYPE }
impl SequenceType {
    pub fn element(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn bound(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { OptionalType: OPTIONAL_TYPE }
impl OptionalType {
    pub fn element(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
}

node! { FixedType: FIXED_TYPE }
impl FixedType {
    pub fn exprs(&self) -> AstChildren<Expr> {
        support::children(self.syntax())
    }
}

node! { NamedType: NAMED_TYPE }
impl NamedType {
    pub fn path(&self) -> Option<Path> {
        support::child(self.syntax())
    }
}

node! { Struct: STRUCT }
impl Struct {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { Union: UNION }
impl Union {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn switch_type(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }
}

node! { Enum: ENUM }
impl Enum {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn enumerator_list(&self) -> Option<EnumeratorList> {
        support::child(self.syntax())
    }
}

node! { EnumeratorList: ENUMERATOR_LIST }
impl EnumeratorList {
    pub fn enumerators(&self) -> AstChildren<Enumerator> {
        support::children(self.syntax())
    }
}

node! { Enumerator: ENUMERATOR }
impl Enumerator {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
}

node! { Literal: LITERAL }
node! { PathExpr: PATH_EXPR }
impl PathExpr {
    pub fn path(&self) -> Option<Path> {
        support::child(self.syntax())
    }
}

node! { ParenExpr: PAREN_EXPR }
impl ParenExpr {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { PrefixExpr: PREFIX_EXPR }
impl PrefixExpr {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { BinaryExpr: BINARY_EXPR }
impl BinaryExpr {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { ParamList: PARAM_LIST }
impl ParamList {
    pub fn params(&self) -> AstChildren<Param> {
        support::children(self.syntax())
    }
}

node! { StringProperty: STRING_PROPERTY }
impl StringProperty {
    pub fn value(&self) -> Option<Literal> {
        support::child(self.syntax())
    }
}

node! { RequiresProperty: REQUIRES_PROPERTY }
impl RequiresProperty {
    pub fn values(&self) -> AstChildren<Literal> {
        support::children(self.syntax())
    }
}

node! { DurationProperty: DURATION_PROPERTY }
impl DurationProperty {
    pub fn period_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), PERIOD_KW)
    }
    pub fn delay_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), DELAY_KW)
    }
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(self.syntax())
    }
}

node! { InterfacesProperty: INTERFACES_PROPERTY }
impl InterfacesProperty {
    pub fn uses_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), USES_KW)
    }
    pub fn name_refs(&self) -> AstChildren<NameRef> {
        support::children(self.syntax())
    }
}

node! { ThrowsProperty: THROWS_PROPERTY }
impl ThrowsProperty {
    pub fn paths(&self) -> AstChildren<Path> {
        support::children(self.syntax())
    }
}

node! { PriorityProperty: PRIORITY_PROPERTY }
impl PriorityProperty {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { SchedulingProperty: SCHEDULING_PROPERTY }
node! { StackProperty: STACK_PROPERTY }
impl StackProperty {
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(self.syntax())
    }
}

node! { TaskProperty: TASK_PROPERTY }
impl TaskProperty {
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(self.syntax())
    }
}

node! { ServicesProperty: SERVICES_PROPERTY }
impl ServicesProperty {
    pub fn name_refs(&self) -> AstChildren<NameRef> {
        support::children(self.syntax())
    }
}

node! { ValidateProperty: VALIDATE_PROPERTY }
impl ValidateProperty {
    pub fn codel(&self) -> Option<Codel> {
        support::child(self.syntax())
    }
}

node! { LocalProperty: LOCAL_PROPERTY }
impl LocalProperty {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn declarators(&self) -> AstChildren<Declarator> {
        support::children(self.syntax())
    }
}

node! { CodelProperty: CODEL_PROPERTY }
impl CodelProperty {
    pub fn async_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), ASYNC_KW)
    }
    pub fn codel_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), CODEL_KW)
    }
    pub fn codel(&self) -> Option<Codel> {
        support::child(self.syntax())
    }
}

node! { Quantity: QUANTITY }
impl Quantity {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { Codel: CODEL }
impl Codel {
    pub fn triggers(&self) -> Option<Triggers> {
        support::child(self.syntax())
    }
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
    pub fn param_list(&self) -> Option<ParamList> {
        support::child(self.syntax())
    }
    pub fn yields(&self) -> Option<Yields> {
        support::child(self.syntax())
    }
    pub fn wcets(&self) -> AstChildren<Wcet> {
        support::children(self.syntax())
    }
}

node! { Triggers: TRIGGERS }
impl Triggers {
    pub fn states(&self) -> AstChildren<State> {
        support::children(self.syntax())
    }
}

node! { Yields: YIELDS }
impl Yields {
    pub fn states(&self) -> AstChildren<State> {
        support::children(self.syntax())
    }
}

node! { Wcet: WCET }
impl Wcet {
    pub fn wcet_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), WCET_KW)
    }
    pub fn quantity(&self) -> Option<Quantity> {
        support::child(self.syntax())
    }
}

node! { State: STATE }
impl State {
    pub fn pause_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), PAUSE_KW)
    }
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(self.syntax())
    }
}

choice! { Param: TypedParam, PathParam }

node! { TypedParam: TYPED_PARAM }
impl TypedParam {
    pub fn type_spec(&self) -> Option<TypeSpec> {
        support::child(self.syntax())
    }
    pub fn declarator(&self) -> Option<Declarator> {
        support::child(self.syntax())
    }
    pub fn initializer(&self) -> Option<Initializer> {
        support::child(self.syntax())
    }
}

node! { PathParam: PATH_PARAM }
impl PathParam {
    pub fn ids_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), IDS_KW)
    }
    pub fn port_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), PORT_KW)
    }
    pub fn in_token(&self) -> Option<SyntaxToken> {
        support::token(self.syntax(), IN_KW)
    }
    pub fn path(&self) -> Option<ParamPath> {
        support::child(self.syntax())
    }
    pub fn rename(&self) -> Option<Rename> {
        support::child(self.syntax())
    }
    pub fn initializer(&self) -> Option<Initializer> {
        support::child(self.syntax())
    }
}

node! { Initializer: INITIALIZER }
impl Initializer {
    pub fn designator(&self) -> Option<Designator> {
        support::child(self.syntax())
    }
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
    pub fn initializer_list(&self) -> Option<InitializerList> {
        support::child(self.syntax())
    }
    pub fn doc(&self) -> Option<InitializerDoc> {
        support::child(self.syntax())
    }
}

node! { ParamPath: PARAM_PATH }
impl ParamPath {
    pub fn steps(&self) -> AstChildren<PathStep> {
        support::children(self.syntax())
    }
}

node! { Rename: RENAME }
impl Rename {
    pub fn name(&self) -> Option<Name> {
        support::child(self.syntax())
    }
}

choice! { PathStep: MemberStep, IndexStep }

node! { MemberStep: MEMBER_STEP }
impl MemberStep {
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(self.syntax())
    }
}

node! { IndexStep: INDEX_STEP }
impl IndexStep {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

choice! { Designator: MemberDesignator, IndexDesignator }

node! { InitializerList: INITIALIZER_LIST }
impl InitializerList {
    pub fn initializers(&self) -> AstChildren<Initializer> {
        support::children(self.syntax())
    }
}

node! { InitializerDoc: INITIALIZER_DOC }
impl InitializerDoc {
    pub fn text(&self) -> Option<Literal> {
        support::child(self.syntax())
    }
}

node! { MemberDesignator: MEMBER_DESIGNATOR }
impl MemberDesignator {
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(self.syntax())
    }
}

node! { IndexDesignator: INDEX_DESIGNATOR }
impl IndexDesignator {
    pub fn expr(&self) -> Option<Expr> {
        support::child(self.syntax())
    }
}

node! { IncludePath: INCLUDE_PATH }
node! { MacroParams: MACRO_PARAMS }
impl MacroParams {
    pub fn name_refs(&self) -> AstChildren<NameRef> {
        support::children(self.syntax())
    }
}

node! { MacroBody: MACRO_BODY }
node! { Condition: CONDITION }
node! { PragmaArg: PRAGMA_ARG }
node! { DirectiveText: DIRECTIVE_TEXT }
node! { Inactive: INACTIVE }
node! { MacroCall: MACRO_CALL }
impl MacroCall {
    pub fn name_ref(&self) -> Option<NameRef> {
        support::child(self.syntax())
    }
}
