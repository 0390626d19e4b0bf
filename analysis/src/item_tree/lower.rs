//! From the typed syntax tree to the item tree, with the ranges of its pointers.
//!
//! A pointer is allocated for every node that a diagnostic or an editor feature may refer to, in the order of
//! lowering. Ranges hold no leading or trailing trivia. Text from a macro has the range of the call, except
//! for tokens of its arguments, which have the range of the argument.

mod codel;
mod ranges;
mod types;

use std::sync::Arc;

use dotgen_syntax::{
    ExpansionMap, Fragment, Parse, SyntaxKind, SyntaxNode, SyntaxToken, TextRange, TextSize,
    ast::{self, AstChildren, AstNode, HasBody},
    directive::{Directive, DirectiveKind, PragmaArg},
    lexer::RawTokens,
    preproc::{Element, Preprocessed},
};
use smol_str::SmolStr;

use ranges::text_size;
pub(crate) use ranges::{node_range, token_range};

use super::{
    CaseLabel, ExceptionDecl, Item, ItemTree, Name, Path, PortDecl, Pragma, Property, PropertyKind,
    Ptr, TypeRefKind,
};

/// The result of lowering a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lowered {
    /// The declarations of the file.
    pub tree: Arc<ItemTree>,
    /// The ranges of its pointers.
    pub ranges: Arc<PtrRanges>,
    /// The kind of text of each active include, by ordinal; `None` if no declaration is allowed at its place
    /// (it is in [`Lowered::misplaced`] then).
    pub fragments: Vec<Option<Fragment>>,
    /// Active includes in the middle of a declaration.
    pub misplaced: Vec<TextRange>,
}

/// The places of the pointers of one item tree.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PtrRanges {
    /// Index of the first range of each top-level item.
    starts: Vec<u32>,
    ranges: Vec<TextRange>,
}

impl PtrRanges {
    /// The place of a pointer; `None` for pointers of another tree.
    pub fn get(&self, ptr: Ptr) -> Option<TextRange> {
        let start = *self.starts.get(ptr.item as usize)?;
        let end = match self.starts.get(ptr.item as usize + 1) {
            Some(&end) => end,
            None => self.ranges.len() as u32,
        };
        let index = start.checked_add(ptr.node).filter(|&number| number < end)?;
        self.ranges.get(index as usize).copied()
    }
}

/// Lowers a file that was parsed as `fragment`. `raw` are the tokens it was parsed from.
pub fn lower(parse: &Parse, fragment: Fragment, raw: &RawTokens, pre: &Preprocessed) -> Lowered {
    let root = parse.tree();
    let mut lower = Lowering {
        map: &parse.expansion,
        raw,
        directives: directives(root.syntax(), pre),
        pre,
        next_directive: 0,
        ranges: PtrRanges::default(),
        fragments: vec![None; pre.includes.len()],
        placed: vec![false; pre.includes.len()],
    };
    let mut items = Vec::new();
    lower.items(root.items(), Some(fragment), true, &mut items);
    let end = lower.directives.len();
    lower.stray_pragmas(end, true, &mut items);
    lower.ranges.ranges.shrink_to_fit();
    let misplaced = std::iter::zip(&lower.placed, &pre.includes)
        .filter(|(placed, _)| !**placed)
        .map(|(_, include)| include.range)
        .collect();
    Lowered {
        tree: Arc::new(ItemTree { items }),
        ranges: Arc::new(lower.ranges),
        fragments: lower.fragments,
        misplaced,
    }
}

/// Collects into vectors without spare capacity: item trees of all files are kept, and most of their lists
/// have one or two elements.
trait CollectExact: Iterator + Sized {
    fn collect_exact(self) -> Vec<Self::Item> {
        let mut all: Vec<Self::Item> = self.collect();
        all.shrink_to_fit();
        all
    }
}

impl<I: Iterator> CollectExact for I {}

struct Lowering<'a> {
    map: &'a ExpansionMap,
    raw: &'a RawTokens,
    pre: &'a Preprocessed,
    /// Directive nodes of the tree in text order, with their preprocessor directives.
    directives: Vec<(SyntaxNode, &'a Directive, u32)>,
    /// Index of the first of them that has not been lowered.
    next_directive: usize,
    ranges: PtrRanges,
    fragments: Vec<Option<Fragment>>,
    /// For each active include, true if it is among items.
    placed: Vec<bool>,
}

/// Maximum number of directives that are located one by one.
const FEW: usize = 8;

/// The live directives of a tree.
fn directives<'a>(
    root: &SyntaxNode,
    pre: &'a Preprocessed,
) -> Vec<(SyntaxNode, &'a Directive, u32)> {
    let elements = pre.elements.iter().filter_map(|element| match element {
        &Element::Directive { first, end, index } => Some((first < end, index)),
        _ => None,
    });
    let elements: Vec<(bool, u32)> = elements.collect();
    let directive = |index: u32| Some((pre.directives.get(index as usize)?, index));
    // Locating a place takes time proportional to the text before it: suitable for a few.
    if elements.len() <= FEW && elements.iter().all(|(spelled, _)| *spelled) {
        let at = elements.iter().filter_map(|&(_, index)| {
            let (directive, index) = directive(index)?;
            let token = root.token_at_offset(directive.range.start()).right_biased()?;
            let node = token
                .parent_ancestors()
                .find(|ancestor| ancestor.kind() == SyntaxKind::DIRECTIVE)?;
            Some((node, directive, index))
        });
        return at.collect();
    }
    // A directive from a macro has no place of its own, and many are found in one walk. The tree builder
    // makes one node for each directive element, in order.
    root.descendants()
        .filter(|node| node.kind() == SyntaxKind::DIRECTIVE)
        .zip(elements)
        .filter_map(|(node, (_, index))| {
            let (directive, index) = directive(index)?;
            Some((node, directive, index))
        })
        .collect()
}

impl Lowering<'_> {
    // Pointers.

    fn ptr(&mut self, range: TextRange) -> Ptr {
        let item = self.ranges.starts.len().saturating_sub(1);
        let start = self.ranges.starts.last().copied().unwrap_or(0);
        let node = self.ranges.ranges.len() as u32 - start;
        self.ranges.ranges.push(range);
        Ptr { item: item as u32, node }
    }

    fn node(&mut self, node: &SyntaxNode) -> Ptr {
        let range = self.node_range(node);
        self.ptr(range)
    }

    fn token(&mut self, token: &SyntaxToken) -> Ptr {
        let range = self.token_range(token);
        self.ptr(range)
    }

    /// The keyword of a declaration, or the declaration if it has none.
    fn keyword(&mut self, token: Option<SyntaxToken>, node: &SyntaxNode) -> Ptr {
        match token {
            Some(token) => self.token(&token),
            None => self.node(node),
        }
    }

    fn token_range(&self, token: &SyntaxToken) -> TextRange {
        token_range(token, self.map, self.raw)
    }

    fn node_range(&self, node: &SyntaxNode) -> TextRange {
        node_range(node, self.map, self.raw)
    }

    fn name(&mut self, name: Option<ast::Name>) -> Option<Name> {
        self.ident(name?.ident_token())
    }

    fn name_ref(&mut self, name: Option<ast::NameRef>) -> Option<Name> {
        self.ident(name?.ident_token())
    }

    fn ident(&mut self, token: Option<SyntaxToken>) -> Option<Name> {
        let token = token?;
        Some(Name { text: self.map.text(&token), ptr: self.token(&token) })
    }

    fn names(&mut self, names: AstChildren<ast::NameRef>) -> Vec<Name> {
        names.filter_map(|name| self.name_ref(Some(name))).collect_exact()
    }

    // Items.

    /// Lowers a list of items into `out`. `fragment` is the kind of text of files included here; `top` is
    /// true for the top-level items.
    fn items(
        &mut self,
        items: impl Iterator<Item = ast::Item>,
        fragment: Option<Fragment>,
        top: bool,
        out: &mut Vec<Item>,
    ) {
        for item in items {
            if let ast::Item::Directive(directive) = &item {
                let found = self.directives[self.next_directive..]
                    .iter()
                    .position(|(node, ..)| node == directive.syntax());
                if let Some(skipped) = found {
                    let at = self.next_directive + skipped;
                    self.stray_pragmas(at, top, out);
                    self.next_directive = at + 1;
                    self.emit(top, out, |lowering| lowering.directive(at, fragment));
                }
            } else {
                self.emit(top, out, |lowering| lowering.item(item));
            }
        }
    }

    /// The items of a body; empty without a body.
    fn body(&mut self, owner: &impl HasBody) -> Vec<Item> {
        let mut out = Vec::new();
        if let Some(body) = owner.body() {
            self.items(body.items(), body.fragment(), false, &mut out);
        }
        out.shrink_to_fit();
        out
    }

    /// Pragmas between the last directive lowered and `end`: they are inside a declaration and count as
    /// written after it.
    fn stray_pragmas(&mut self, end: usize, top: bool, out: &mut Vec<Item>) {
        for at in self.next_directive..end {
            if matches!(self.directives[at].1.kind, DirectiveKind::Pragma(_)) {
                self.emit(top, out, |lowering| lowering.directive(at, None));
            }
        }
        self.next_directive = end;
    }

    fn emit(
        &mut self,
        top: bool,
        out: &mut Vec<Item>,
        lower: impl FnOnce(&mut Self) -> Option<Item>,
    ) {
        if top {
            self.ranges.starts.push(self.ranges.ranges.len() as u32);
        }
        match lower(self) {
            Some(item) => out.push(item),
            // Top-level items are numbered without gaps.
            None if top => {
                if let Some(start) = self.ranges.starts.pop() {
                    self.ranges.ranges.truncate(start as usize);
                }
            }
            None => {}
        }
    }

    fn item(&mut self, item: ast::Item) -> Option<Item> {
        let node = item.syntax().clone();
        Some(match item {
            ast::Item::Directive(_) => return None,
            ast::Item::Module(module) => Item::Module {
                ptr: self.node(&node),
                name: self.name(module.name()),
                items: self.body(&module),
            },
            ast::Item::ConstDecl(constant) => Item::Const(super::ConstDecl {
                ptr: self.node(&node),
                ty: self.type_ref(constant.type_spec(), &node),
                name: self.name(constant.name()),
                value: self.expr(constant.expr(), &node),
            }),
            ast::Item::TypedefDecl(typedef) => Item::Typedef {
                ptr: self.node(&node),
                ty: self.type_ref(typedef.type_spec(), &node),
                declarators: self.declarators(typedef.declarators()),
            },
            ast::Item::NativeDecl(native) => {
                Item::Native { ptr: self.node(&node), name: self.name(native.name()) }
            }
            ast::Item::ExceptionDecl(exception) => Item::Exceptions {
                ptr: self.node(&node),
                exceptions: exception
                    .exceptions()
                    .filter_map(|exception| self.exception(&exception))
                    .collect_exact(),
            },
            ast::Item::TypeDecl(known_type) => {
                let ty = self.type_ref(known_type.type_spec(), &node);
                match ty.kind {
                    TypeRefKind::Inline(declaration) => Item::Type(declaration),
                    _ => return None,
                }
            }
            ast::Item::ForwardDecl(declaration) => {
                let ptr = self.node(&node);
                let union = declaration.union_token().is_some();
                Item::Forward { union, name: self.name(declaration.name()), ptr }
            }
            ast::Item::Component(component) => Item::Component {
                ptr: self.node(&node),
                interface: component.is_interface(),
                name: self.name(component.name()),
                body: component.body().is_some().then(|| self.body(&component)),
            },
            ast::Item::Ids(id) => Item::Ids {
                ptr: self.node(&node),
                keyword: self.keyword(id.ids_token(), &node),
                members: self.body(&id),
            },
            ast::Item::Task(task) => Item::Task {
                ptr: self.node(&node),
                name: self.name(task.name()),
                properties: self.body(&task),
            },
            ast::Item::Port(port) => Item::Port(self.port(&port)),
            ast::Item::Service(service) => Item::Service(self.service(&service)),
            ast::Item::Member(member) => Item::Member {
                ptr: self.node(&node),
                ty: self.type_ref(member.type_spec(), &node),
                declarators: self.declarators(member.declarators()),
            },
            ast::Item::Case(case) => self.case(&case),
            ast::Item::Property(property) => Item::Property(self.property(&property)?),
        })
    }

    /// Lowers a port.
    fn port(&mut self, port: &ast::Port) -> PortDecl {
        PortDecl {
            ptr: self.node(port.syntax()),
            keyword: self.keyword(port.port_token(), port.syntax()),
            multiple: port.multiple_token().is_some(),
            out: match (port.in_token(), port.out_token()) {
                (Some(_), _) => Some(false),
                (_, Some(_)) => Some(true),
                _ => None,
            },
            ty: self.type_ref(port.type_spec(), port.syntax()),
            name: self.name(port.name()),
            properties: self.body(port),
        }
    }

    /// Lowers a case of a union.
    fn case(&mut self, case: &ast::Case) -> Item {
        Item::Case {
            ptr: self.node(case.syntax()),
            labels: case
                .case_labels()
                .map(|label| CaseLabel {
                    ptr: self.node(label.syntax()),
                    value: label
                        .default_token()
                        .is_none()
                        .then(|| self.expr(label.expr(), label.syntax())),
                })
                .collect_exact(),
            ty: self.type_ref(case.type_spec(), case.syntax()),
            declarator: case.declarator().and_then(|declarator| self.declarator(&declarator)),
        }
    }

    fn exception(&mut self, exception: &ast::Exception) -> Option<ExceptionDecl> {
        Some(ExceptionDecl { name: self.name(exception.name())?, members: self.body(exception) })
    }

    fn directive(&mut self, at: usize, fragment: Option<Fragment>) -> Option<Item> {
        let (node, directive, index) = self.directives[at].clone();
        match &directive.kind {
            DirectiveKind::Include(_) => {
                let ordinal = self.pre.include_ordinal(index)?;
                if fragment.is_some() {
                    *self.fragments.get_mut(ordinal as usize)? = fragment;
                    *self.placed.get_mut(ordinal as usize)? = true;
                }
                Some(Item::Include { ordinal, ptr: self.ptr(directive.range) })
            }
            DirectiveKind::Pragma(pragma) => {
                let word = pragma.name.as_ref()?.text.clone();
                let ptr = self.ptr(directive.range);
                let arguments = |lowering: &mut Self| -> Vec<(SmolStr, Ptr)> {
                    pragma
                        .args
                        .iter()
                        .map(|arg| (arg.text.clone(), lowering.ptr(arg.range)))
                        .collect_exact()
                };
                Some(Item::Pragma(match word.as_str() {
                    "require" | "requires" => Pragma::Requires { arguments: arguments(self), ptr },
                    "provide" | "provides" => Pragma::Provides { arguments: arguments(self), ptr },
                    "masquerade" => Pragma::Masquerade {
                        arguments: arguments(self),
                        ty: pragma.args.get(1).and_then(|argument| self.path_in(&node, argument)),
                        ptr,
                    },
                    "wcet" => {
                        let directive = ast::Directive::cast(node)?;
                        // The first name is the word after `#pragma`.
                        let mut names =
                            directive.syntax().children().filter_map(ast::NameRef::cast);
                        Pragma::Wcet {
                            codel: self.name_ref(names.nth(1)),
                            duration: directive.quantity().map(|quantity| self.duration(&quantity)),
                            ptr,
                        }
                    }
                    _ => return None,
                }))
            }
            _ => None,
        }
    }

    /// A pragma argument read as a path. `directive` is its node.
    fn path_in(&mut self, directive: &SyntaxNode, argument: &PragmaArg) -> Option<Path> {
        let ptr = self.ptr(argument.range);
        let start = argument.range.start();
        // In a `_Pragma`, or with quotes escaped, the parts have no place of their own.
        let spelled = directive.text_range().contains_range(argument.range).then(|| {
            let within = argument.range - directive.text_range().start();
            directive.text().slice(within).to_string()
        });
        let inside = spelled.and_then(|slice| slice.find(argument.text.as_str()));
        let mut offset = 0;
        let mut segments = Vec::new();
        for part in argument.text.split("::") {
            let name = part.trim();
            if !name.is_empty() {
                let at = offset + part.find(name).unwrap_or(0);
                let range = match inside {
                    Some(inside) => {
                        TextRange::at(start + text_size(inside + at), TextSize::of(name))
                    }
                    None => argument.range,
                };
                segments.push(Name { text: name.into(), ptr: self.ptr(range) });
            }
            offset += part.len() + 2;
        }
        (!segments.is_empty()).then(|| Path {
            absolute: argument.text.trim_start().starts_with("::"),
            segments,
            ptr,
        })
    }

    fn property(&mut self, property: &ast::Property) -> Option<Property> {
        let node = property.syntax();
        let ptr = self.node(node);
        let keyword = property.keyword_token();
        let word = keyword.as_ref().map(SyntaxToken::kind);
        let keyword = self.keyword(keyword, node);
        use PropertyKind as P;
        let kind = match property {
            ast::Property::StringProperty(property) => {
                let value = self.literal(property.value(), node);
                match word? {
                    SyntaxKind::DOC_KW => P::Doc(value),
                    SyntaxKind::VERSION_KW => P::Version(value),
                    SyntaxKind::LANG_KW => P::Lang(value),
                    SyntaxKind::EMAIL_KW => P::Email(value),
                    _ => return None,
                }
            }
            ast::Property::RequiresProperty(property) => {
                let values = property
                    .values()
                    .map(|literal| self.literal(Some(literal), node))
                    .collect_exact();
                match word? {
                    SyntaxKind::REQUIRES_KW => P::Requires(values),
                    _ => P::CodelsRequires(values),
                }
            }
            ast::Property::DurationProperty(property) => {
                let duration = self.duration_or_missing(property.quantity(), node);
                match word? {
                    SyntaxKind::CLOCK_RATE_KW => P::ClockRate(duration),
                    SyntaxKind::PERIOD_KW => P::Period(duration),
                    _ => P::Delay(duration),
                }
            }
            ast::Property::InterfacesProperty(property) => {
                let names = self.names(property.name_refs());
                match word? {
                    SyntaxKind::PROVIDES_KW => P::Provides(names),
                    SyntaxKind::USES_KW => P::Uses(names),
                    _ => P::Extends(names),
                }
            }
            ast::Property::ThrowsProperty(property) => {
                P::Throws(property.paths().filter_map(|path| self.path(&path)).collect_exact())
            }
            ast::Property::PriorityProperty(property) => {
                P::Priority(self.expr(property.expr(), node))
            }
            ast::Property::SchedulingProperty(_) => P::Scheduling,
            ast::Property::StackProperty(property) => {
                P::Stack(self.duration_or_missing(property.quantity(), node))
            }
            ast::Property::TaskProperty(property) => P::Task(self.name_ref(property.name_ref())),
            ast::Property::ServicesProperty(property) => {
                let names = self.names(property.name_refs());
                match word? {
                    SyntaxKind::INTERRUPTS_KW => P::Interrupts(names),
                    SyntaxKind::BEFORE_KW => P::Before(names),
                    _ => P::After(names),
                }
            }
            ast::Property::ValidateProperty(property) => {
                P::Validate(Box::new(self.codel(&property.codel()?, false)))
            }
            ast::Property::LocalProperty(property) => P::Local {
                ty: self.type_ref(property.type_spec(), node),
                declarators: self.declarators(property.declarators()),
            },
            ast::Property::CodelProperty(property) => {
                P::Codel(Box::new(self.codel(&property.codel()?, property.is_async())))
            }
        };
        Some(Property { kind, ptr, keyword })
    }
}
