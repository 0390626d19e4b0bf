//! Services, codels, their parameters and default values.

use dotgen_syntax::{
    SyntaxKind,
    ast::{self, AstNode},
};

use super::{CollectExact, Lowering};
use crate::item_tree::{
    CodelDecl, Designator, InitValue, Initializer, ParamDecl, ParamSpec, PathStep, ServiceDecl,
    StateRef, WcetClause,
};
use crate::model::{ParamDir, ServiceKind, SourceKind};

impl Lowering<'_> {
    pub(super) fn service(&mut self, service: &ast::Service) -> ServiceDecl {
        ServiceDecl {
            ptr: self.node(service.syntax()),
            kind: if service.attribute_token().is_some() {
                ServiceKind::Attribute
            } else if service.function_token().is_some() {
                ServiceKind::Function
            } else {
                ServiceKind::Activity
            },
            name: self.name(service.name()),
            params: self.params(service.param_list()),
            properties: self.body(service),
        }
    }

    pub(super) fn codel(&mut self, codel: &ast::Codel, is_async: bool) -> CodelDecl {
        CodelDecl {
            ptr: self.node(codel.syntax()),
            is_async,
            triggers: codel.triggers().map(|trigger| self.states(trigger.states())),
            name: self.name(codel.name()),
            params: self.params(codel.param_list()),
            yields: codel.yields().map(|yields| self.states(yields.states())),
            wcet: codel
                .wcets()
                .map(|wcet| WcetClause {
                    ptr: self.node(wcet.syntax()),
                    bare: wcet.is_bare(),
                    duration: wcet
                        .quantity()
                        .filter(|quantity| quantity.expr().is_some())
                        .map(|quantity| self.duration(&quantity)),
                })
                .collect_exact(),
        }
    }

    fn states(&mut self, states: ast::AstChildren<ast::State>) -> Vec<StateRef> {
        states
            .filter_map(|state| {
                Some(StateRef {
                    ptr: self.node(state.syntax()),
                    paused: state.is_paused(),
                    name: self.name_ref(state.name_ref())?,
                })
            })
            .collect_exact()
    }

    fn params(&mut self, list: Option<ast::ParamList>) -> Vec<ParamDecl> {
        list.into_iter()
            .flat_map(|param_list| param_list.params())
            .filter_map(|param| self.param(&param))
            .collect_exact()
    }

    fn param(&mut self, param: &ast::Param) -> Option<ParamDecl> {
        let ptr = self.node(param.syntax());
        let (dir, spec, init) = match param {
            ast::Param::TypedParam(typed_param) => (
                typed_param.dir_token(),
                ParamSpec::Typed {
                    ty: Box::new(self.type_ref(typed_param.type_spec(), typed_param.syntax())),
                    declarator: typed_param
                        .declarator()
                        .and_then(|declarator| self.declarator(&declarator))
                        .map(Box::new),
                },
                typed_param.initializer(),
            ),
            ast::Param::PathParam(path_param) => {
                let source = path_param.source_token().and_then(|token| {
                    let source = match token.kind() {
                        SyntaxKind::IDS_KW => SourceKind::Ids,
                        SyntaxKind::LOCAL_KW => SourceKind::Local,
                        SyntaxKind::PORT_KW => SourceKind::Port,
                        SyntaxKind::REMOTE_KW => SourceKind::Remote,
                        _ => return None,
                    };
                    Some((source, self.token(&token)))
                });
                let path: Vec<PathStep> = path_param
                    .path()
                    .into_iter()
                    .flat_map(|path| path.steps())
                    .filter_map(|step| self.path_step(&step))
                    .collect_exact();
                let rename = path_param.rename().and_then(|rename| self.name(rename.name()));
                if path.is_empty() && rename.is_none() {
                    return None;
                }
                let spec = ParamSpec::Path { source, path, rename: rename.map(Box::new) };
                (path_param.dir_token(), spec, path_param.initializer())
            }
        };
        let dir = match dir?.kind() {
            SyntaxKind::IN_KW => ParamDir::In,
            SyntaxKind::OUT_KW => ParamDir::Out,
            _ => ParamDir::Inout,
        };
        Some(ParamDecl { dir, spec, init: init.map(|init| Box::new(self.initializer(&init))), ptr })
    }

    fn path_step(&mut self, step: &ast::PathStep) -> Option<PathStep> {
        Some(match step {
            ast::PathStep::MemberStep(member_step) => {
                PathStep::Member(self.name_ref(member_step.name_ref())?)
            }
            ast::PathStep::IndexStep(index_step) => {
                PathStep::Index(self.expr(index_step.expr(), index_step.syntax()))
            }
        })
    }

    fn initializer(&mut self, initializer: &ast::Initializer) -> Initializer {
        let node = initializer.syntax();
        Initializer {
            ptr: self.node(node),
            designator: initializer.designator().and_then(|designator| {
                Some(match designator {
                    ast::Designator::MemberDesignator(member_designator) => {
                        Designator::Member(self.name_ref(member_designator.name_ref())?)
                    }
                    ast::Designator::IndexDesignator(index_designator) => Designator::Index(
                        self.expr(index_designator.expr(), index_designator.syntax()),
                    ),
                })
            }),
            value: match (initializer.initializer_list(), initializer.expr()) {
                (Some(list), _) => Some(InitValue::Compound(
                    list.initializers()
                        .map(|initializer| self.initializer(&initializer))
                        .collect_exact(),
                )),
                (None, Some(expr)) => Some(InitValue::Scalar(self.expr(Some(expr), node))),
                (None, None) => None,
            },
            doc: initializer.doc().map(|doc| self.literal(doc.text(), doc.syntax())),
        }
    }
}
