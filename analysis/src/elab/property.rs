//! Properties: legal places, contents and merging (language reference, section 9).

use crate::finding::role::Role;
use dotgen_syntax::SyntaxKind;
use num_rational::Ratio;
use rustc_hash::FxHashMap;

use super::{constant::string_content, context::Elaborator, value::Const, words};
use crate::{
    finding::{
        Finding,
        names::{NameProblem, Noun},
        services::DeclarationProblem,
        values::ValueProblem,
    },
    item_tree::{Duration, Expr, ExprKind, Path, Property, PropertyKind},
    model::{ComponentId, Gap, Missing, Owner, Quantity, Seconds, Src, TypeId, TypeKind, Value},
    release::Change,
};

/// The first word of a property.
pub(super) fn keyword(kind: &PropertyKind) -> &'static str {
    match kind {
        PropertyKind::Doc(_) => "doc",
        PropertyKind::Version(_) => "version",
        PropertyKind::Lang(_) => "lang",
        PropertyKind::Email(_) => "email",
        PropertyKind::Requires(_) => "requires",
        PropertyKind::CodelsRequires(_) => "codels-requires",
        PropertyKind::ClockRate(_) => "clock-rate",
        PropertyKind::Provides(_) => "provides",
        PropertyKind::Uses(_) => "uses",
        PropertyKind::Extends(_) => "extends",
        PropertyKind::Throws(_) => "throws",
        PropertyKind::Period(_) => "period",
        PropertyKind::Delay(_) => "delay",
        PropertyKind::Priority(_) => "priority",
        PropertyKind::Scheduling => "scheduling",
        PropertyKind::Stack(_) => "stack",
        PropertyKind::Task(_) => "task",
        PropertyKind::Interrupts(_) => "interrupts",
        PropertyKind::Before(_) => "before",
        PropertyKind::After(_) => "after",
        PropertyKind::Validate(_) => "validate",
        PropertyKind::Local { .. } => "local",
        PropertyKind::Codel(_) => "codel",
    }
}

/// The declaration that a property belongs to, for messages.
pub(super) fn home(kind: &PropertyKind) -> &'static str {
    match kind {
        PropertyKind::Doc(_) => "anywhere",
        PropertyKind::Throws(_) => "in a component, task or service",
        PropertyKind::Version(_)
        | PropertyKind::Lang(_)
        | PropertyKind::Email(_)
        | PropertyKind::Requires(_)
        | PropertyKind::CodelsRequires(_)
        | PropertyKind::ClockRate(_)
        | PropertyKind::Provides(_)
        | PropertyKind::Uses(_)
        | PropertyKind::Extends(_) => "directly in a component or interface",
        PropertyKind::Period(_)
        | PropertyKind::Delay(_)
        | PropertyKind::Priority(_)
        | PropertyKind::Scheduling
        | PropertyKind::Stack(_) => "in a task",
        PropertyKind::Task(_) => "in an activity",
        PropertyKind::Interrupts(_)
        | PropertyKind::Before(_)
        | PropertyKind::After(_)
        | PropertyKind::Validate(_) => "in a service",
        PropertyKind::Local { .. } => "in a function or activity",
        PropertyKind::Codel(_) => "in a task or service",
    }
}

/// The text of a string expression. The grammar allows only strings here.
pub(super) fn text(expr: &Expr) -> Option<String> {
    match &expr.kind {
        ExprKind::Str(parts) => {
            Some(parts.iter().map(|(literal, _)| string_content(literal)).collect())
        }
        ExprKind::Paren(inner) => text(inner),
        _ => None,
    }
}

impl<'a> Elaborator<'a> {
    /// A property directly in the body of a component or interface.
    pub(super) fn component_property(&mut self, c: ComponentId, property: &'a Property) {
        let at = self.src(property.ptr);
        let word = keyword(&property.kind);
        match &property.kind {
            PropertyKind::Doc(doc) => {
                let mut docs = self.spec.components[c].doc.take();
                self.add_doc(&mut docs, doc);
                self.spec.components[c].doc = docs;
            }
            PropertyKind::Version(value)
            | PropertyKind::Lang(value)
            | PropertyKind::Email(value) => {
                let Some(value) = text(value) else { return };
                if self.first_in_component(c, word, &value, at) {
                    let component = &mut self.spec.components[c];
                    let slot = match word {
                        "version" => &mut component.version,
                        "lang" => &mut component.lang,
                        _ => &mut component.email,
                    };
                    *slot = Some(value);
                }
            }
            PropertyKind::Requires(list) => {
                let added = self.string_list(list, word);
                union(&mut self.spec.components[c].requires, added);
                self.note_requirements(list);
            }
            PropertyKind::CodelsRequires(list) => self.codels_requires(c, list, word, at),
            PropertyKind::ClockRate(duration) => {
                let value = self.time(duration, word, at);
                if self.once_in_component(c, word, at) {
                    self.spec.components[c].clock_rate = value;
                }
            }
            PropertyKind::Stack(size) if self.spec.release.has(Change::ComponentStack) => {
                let value = self.stack(size, at);
                if self.once_in_component(c, word, at) {
                    self.spec.components[c].stack = value;
                    self.newer(Change::ComponentStack, "a `stack` for a whole component", at);
                }
            }
            PropertyKind::Provides(names)
            | PropertyKind::Uses(names)
            | PropertyKind::Extends(names) => self.imports(c, names, word),
            PropertyKind::Throws(list) => {
                let added = self.throws(list, c, None);
                union(&mut self.spec.components[c].throws, added);
            }
            PropertyKind::Local { ty, .. } => {
                let at = self.src(ty.ptr);
                self.local_outside(at, "a component or interface");
            }
            kind => {
                let home = home(kind);
                let finding = match kind {
                    PropertyKind::Stack(_) => DeclarationProblem::StackInComponent {
                        home,
                        since: Change::ComponentStack.since(),
                    },
                    _ => DeclarationProblem::NotInComponent { word, home },
                };
                self.error(at, finding);
            }
        }
    }

    /// The packages that codels require.
    fn codels_requires(&mut self, c: ComponentId, list: &'a [Expr], word: &'static str, at: Src) {
        let added = self.string_list(list, word);
        let given = &mut self.components[c].given;
        if let Some(&first) = given.get(word) {
            self.newer_or(
                Change::MergedProperties,
                "a second `codels-requires`",
                at,
                Finding::new(DeclarationProblem::RequiresTwice, at).related(first, Role::First),
            );
        } else {
            given.insert(word, at);
        }
        union(&mut self.spec.components[c].codels_requires, added);
    }

    pub(super) fn local_outside(&mut self, at: Src, place: &'static str) {
        self.error(at, DeclarationProblem::LocalOutside { place });
    }

    /// Like [`Self::once_in_component`], for properties that may be repeated in newer releases: the first one
    /// counts.
    fn first_in_component(
        &mut self,
        c: ComponentId,
        word: &'static str,
        value: &str,
        at: Src,
    ) -> bool {
        if self.repeats_first(c, word, value) {
            self.newer(Change::MergedProperties, "a property that is repeated", at);
            return false;
        }
        self.once_in_component(c, word, at)
    }

    /// Returns true if a property of a component is already given and may be repeated: languages must then be
    /// equal.
    pub(super) fn repeats_first(&self, c: ComponentId, word: &'static str, value: &str) -> bool {
        let merges = match word {
            "version" | "email" => true,
            "lang" => self.spec.components[c].lang.as_deref() == Some(value),
            _ => false,
        };
        merges
            && self.spec.release.has(Change::MergedProperties)
            && self.components[c].given.contains_key(word)
    }

    fn once_in_component(&mut self, c: ComponentId, word: &'static str, at: Src) -> bool {
        let mut given = std::mem::take(&mut self.components[c].given);
        let first = self.once(&mut given, word, at);
        self.components[c].given = given;
        first
    }

    /// Records that a property that does not merge is given; reports it if it was already given.
    pub(super) fn once(
        &mut self,
        given: &mut FxHashMap<&'static str, Src>,
        word: &'static str,
        at: Src,
    ) -> bool {
        if let Some(&first) = given.get(word) {
            self.report(
                Finding::new(DeclarationProblem::PropertyTwice { word }, at)
                    .related(first, Role::FirstGiven),
            );
            false
        } else {
            given.insert(word, at);
            true
        }
    }

    /// Adds a documentation text to those given before.
    pub(super) fn add_doc(&mut self, docs: &mut Option<String>, doc: &Expr) {
        if let Some(doc) = text(doc) {
            join_doc(docs, &doc);
        }
    }

    /// The strings of a `requires` or `codels-requires`.
    fn string_list(&mut self, list: &'a [Expr], word: &str) -> Vec<String> {
        let mut strings: Vec<String> = Vec::with_capacity(list.len());
        for expr in list {
            let Some(string) = text(expr) else { continue };
            if strings.contains(&string) {
                let at = self.src(expr.ptr);

                self.error(
                    at,
                    DeclarationProblem::ListedTwice { text: string.into(), word: word.into() },
                );
            } else {
                strings.push(string);
            }
        }
        strings
    }

    /// The exceptions of a `throws` list.
    pub(super) fn throws(
        &mut self,
        list: &'a [Path],
        component: ComponentId,
        owner: Option<Owner>,
    ) -> Vec<TypeId> {
        let mut exceptions = Vec::with_capacity(list.len());
        for path in list {
            let at = self.src(path.ptr);
            let Some(ty) = self.resolve_path(path) else {
                self.report_unresolved_exception(path, at);
                self.spec.gaps.push(Gap {
                    component: Some(component),
                    missing: Missing::Exception { name: words::path_text(path).into(), owner },
                });
                continue;
            };
            match &self.spec.ty(ty).kind {
                TypeKind::Exception { .. } => {}
                TypeKind::Unknown => {
                    self.spec.gaps.push(Gap {
                        component: Some(component),
                        missing: Missing::Exception { name: words::path_text(path).into(), owner },
                    });
                    continue;
                }
                _ => {
                    let what = words::describe(&self.spec, ty);
                    let name = words::path_text(path);

                    let mut diagnostic =
                        Finding::new(NameProblem::NotAnException { path: name.into(), what }, at);
                    if let Some(place) = self.type_place(ty) {
                        diagnostic = diagnostic.related(place, Role::Declared);
                    }
                    self.report(diagnostic);
                    continue;
                }
            }
            if exceptions.contains(&ty) {
                let name = words::path_text(path);

                self.error(at, NameProblem::ThrownTwice { path: name.into() });
            } else {
                exceptions.push(ty);
            }
        }
        exceptions
    }

    fn report_unresolved_exception(&mut self, path: &Path, at: Src) {
        if path.segments.len() > 1 || path.absolute {
            self.report_unresolved(path, true);
            return;
        }
        let Some(name) = path.segments.last() else {
            return;
        };
        let candidates = self
            .scopes
            .visible(self.scope)
            .filter(|(_, ty)| matches!(self.spec.ty(*ty).kind, TypeKind::Exception { .. }))
            .map(|(name, _)| name.as_str());
        let near = self.near(self.src(name.ptr), &name.text, candidates);

        self.unresolved(
            at,
            NameProblem::Unknown { noun: Noun::Exception, name: name.text.clone() },
            near,
        );
    }

    // Quantities

    /// The value of `period`, `delay` or `clock-rate`, in seconds.
    pub(super) fn time(
        &mut self,
        duration: &'a Duration,
        word: &str,
        property: Src,
    ) -> Option<Quantity> {
        let glued = glued_microseconds(duration);
        let value = self.eval(&duration.value);
        if value == Const::Unknown {
            return None;
        }
        let Some(number) = value.exact() else {
            let at = match &duration.unit {
                Some((_, ptr)) => self.src(*ptr),
                None => self.src(duration.value.ptr),
            };

            self.error(at, ValueProblem::NotANumber { word: word.into(), value: value.describe() });
            return None;
        };
        if number < Ratio::from_integer(0) {
            self.error(property, ValueProblem::Negative { word: word.into() });
            return None;
        }
        let unit = if glued {
            let at = self.src(duration.value.ptr);
            self.error(at, ValueProblem::GluedUnit);
            Some(SyntaxKind::S_KW)
        } else {
            duration.unit.map(|(unit, _)| unit)
        };
        Some(self.seconds(number, unit, property))
    }

    /// A quantity of time, with its anonymous constant.
    pub(super) fn seconds(
        &mut self,
        number: Seconds,
        unit: Option<SyntaxKind>,
        src: Src,
    ) -> Quantity {
        let value = match unit {
            Some(SyntaxKind::MS_KW) => number / Ratio::from_integer(1_000),
            Some(SyntaxKind::US_KW) => number / Ratio::from_integer(1_000_000),
            _ => number,
        };
        let number = self.anonymous(TypeKind::Double, src);
        let kind = TypeKind::Const { ty: number, value: Value::Float(to_f64(value)) };
        let ty = self.anonymous(kind, src);
        Quantity { value, ty, src }
    }

    /// The value of `priority`.
    pub(super) fn priority(&mut self, expr: &'a Expr, src: Src) -> Option<Quantity> {
        let value = self.non_negative_integer(expr, "priority")?;
        if value > 255 {
            let at = self.src(expr.ptr);

            self.error(at, ValueProblem::PriorityRange { value });
        }
        Some(self.amount(value, src))
    }

    /// The value of `stack`, in bytes.
    pub(super) fn stack(&mut self, size: &'a Duration, src: Src) -> Option<Quantity> {
        let value = self.non_negative_integer(&size.value, "stack size")?;
        let factor = match size.unit {
            Some((SyntaxKind::K_KW, _)) => 1 << 10,
            Some((SyntaxKind::M_KW, _)) => 1 << 20,
            _ => 1,
        };
        if let Some(bytes) = value.checked_mul(factor) {
            Some(self.amount(bytes, src))
        } else {
            let at = self.src(size.value.ptr);
            self.error(at, ValueProblem::StackTooLarge);
            None
        }
    }

    fn amount(&mut self, value: u64, src: Src) -> Quantity {
        let number = self.anonymous(TypeKind::UnsignedLong, src);
        let kind = TypeKind::Const { ty: number, value: Value::Uint(value) };
        let ty = self.anonymous(kind, src);
        Quantity { value: Ratio::from_integer(i128::from(value)), ty, src }
    }
}

/// Returns true if a duration is an integer literal with `us` glued to it, which older tools read as an
/// unsigned literal and the unit `s` (deviation D29).
pub(super) fn glued_microseconds(duration: &Duration) -> bool {
    duration.glued
        && match (last_integer(&duration.value), duration.unit) {
            (Some(_), Some((SyntaxKind::US_KW, _))) => true,
            (Some(text), Some((SyntaxKind::S_KW, _))) => text.ends_with('u'),
            _ => false,
        }
}

/// The integer literal at the end of an expression.
fn last_integer(expr: &Expr) -> Option<&str> {
    match &expr.kind {
        ExprKind::Int(text) => Some(text),
        ExprKind::Unary { operand, .. } => last_integer(operand),
        ExprKind::Binary { right, .. } => last_integer(right),
        _ => None,
    }
}

/// Maximum length of a documentation in bytes: two interfaces that import each other would double it at every
/// step.
const MAX_DOC: usize = 1 << 20;

/// Adds to a documentation, on a new line.
pub(super) fn join_doc(docs: &mut Option<String>, doc: &str) {
    match docs {
        Some(docs) if docs.len() > MAX_DOC => {}
        Some(docs) => {
            docs.push('\n');
            docs.push_str(doc);
        }
        None => *docs = Some(doc.to_owned()),
    }
}

/// Appends the elements that the list does not have yet.
pub(super) fn union<T: PartialEq>(list: &mut Vec<T>, added: impl IntoIterator<Item = T>) {
    for element in added {
        if !list.contains(&element) {
            list.push(element);
        }
    }
}

/// The nearest float.
pub(crate) fn to_f64(value: Seconds) -> f64 {
    *value.numer() as f64 / *value.denom() as f64
}
