//! Unions (language reference, section 6).

use rustc_hash::{FxHashMap, FxHashSet};

use super::{
    DefKind,
    context::Elaborator,
    convert::{ConversionError, convert, explain_misfit},
    types,
    value::Const,
};
use crate::finding::role::Role;
use crate::{
    finding::{
        Finding,
        lints::LintWarning,
        values::{Purpose, ValueProblem},
    },
    item_tree::{CaseLabel, Item, Name, TypeRef, TypeRefKind},
    model::{Label, ScopeKind, Src, TypeId, TypeKind, Value},
};

impl<'a> Elaborator<'a> {
    pub(super) fn union(
        &mut self,
        name: &Name,
        switch: &'a TypeRef,
        cases: &'a [Item],
        node: Src,
    ) -> TypeId {
        let inside = self.open_type(name, ScopeKind::Union, DefKind::Union, node);
        let (switch, members) = self.within(inside.scope, Some(inside.def), |this| {
            let ty = this.type_ref(switch);
            if let TypeRefKind::Inline(_) = switch.kind {
                let name = name.text.clone();
                this.deviation(this.src(switch.ptr), LintWarning::InlineSwitch { name });
            }
            let ty = this.check_switch(ty, switch, name);
            let clashing = match &switch.kind {
                TypeRefKind::Named(path) => {
                    path.segments.last().map(|segment| segment.text.clone())
                }
                _ => None,
            };
            let mut members: Vec<TypeId> = Vec::new();
            let mut used: FxHashMap<LabelKey, TypeId> = FxHashMap::default();
            this.for_each(cases, |this, item| match item {
                Item::Case { labels, ty: member, declarator, ptr } => {
                    let base = this.type_ref(member);
                    let Some(declarator) = declarator else {
                        this.labels(labels, ty, None, &mut used);
                        return;
                    };
                    let member = this.declared_type(base, declarator);
                    if clashing.as_ref() == Some(&declarator.name.text) {
                        let at = this.src(declarator.name.ptr);
                        this.error(
                            at,
                            ValueProblem::MemberIsSwitch { name: declarator.name.text.clone() },
                        );
                    }
                    let kind = TypeKind::UnionMember { ty: member, labels: Vec::new() };
                    let node = this.src(*ptr);
                    let id = this.member(kind, DefKind::Member, &declarator.name, node);
                    let values = this.labels(labels, ty, Some((&declarator.name, id)), &mut used);
                    if let Some(id) = id {
                        let data = &mut this.spec.types[id];
                        if let TypeKind::UnionMember { labels, .. } = &mut data.kind {
                            *labels = values;
                        }
                        members.push(id);
                    }
                }
                Item::Pragma(pragma) => this.pragma(pragma),
                _ => {}
            });
            (ty, members)
        });
        self.close_type(name, &inside, TypeKind::Union { switch, members })
    }

    /// The switch type, or an unknown one if a union cannot switch on it.
    fn check_switch(&mut self, ty: TypeId, switch: &TypeRef, name: &Name) -> TypeId {
        let last = self.resolve_alias(ty);
        let fits = matches!(
            self.spec.ty(last).kind,
            TypeKind::Boolean
                | TypeKind::Char
                | TypeKind::Short
                | TypeKind::UnsignedShort
                | TypeKind::Long
                | TypeKind::UnsignedLong
                | TypeKind::LongLong
                | TypeKind::UnsignedLongLong
                | TypeKind::Enum { .. }
                | TypeKind::Unknown
        );
        // Types that the grammar does not allow here were reported as a syntax error.
        if fits || !matches!(switch.kind, TypeRefKind::Named(_)) {
            return ty;
        }
        let at = self.src(name.ptr);

        self.error(
            at,
            ValueProblem::BadSwitch {
                name: name.text.clone(),
                ty: types::display(&self.spec, ty).into(),
            },
        );
        self.unknown(at)
    }

    /// The labels of one union member.
    fn labels(
        &mut self,
        labels: &'a [CaseLabel],
        switch: TypeId,
        member: Option<(&Name, Option<TypeId>)>,
        used: &mut FxHashMap<LabelKey, TypeId>,
    ) -> Vec<Label> {
        let mut own: Vec<Label> = Vec::new();
        let mut keys: FxHashSet<LabelKey> = FxHashSet::default();
        let at = member.map(|(name, _)| self.src(name.ptr));
        let mut clash = None;
        for label in labels {
            let value = match &label.value {
                None => Label::Default,
                Some(expr) => {
                    let value = self.eval(expr);
                    if value == Const::Unknown || self.is_unknown(switch) {
                        continue;
                    }
                    match convert(&self.spec, &value, switch) {
                        Ok(value) => Label::Case(value),
                        Err(misfit) => {
                            self.bad_label(misfit, &value, switch, at, self.src(expr.ptr));
                            continue;
                        }
                    }
                }
            };
            let key = LabelKey::of(&value);
            if keys.contains(&key) {
                let at = self.src(label.ptr);
                self.error(at, ValueProblem::LabelTwice);
                continue;
            }
            if let Some(other) = used.get(&key) {
                clash = clash.or(Some((*other, self.src(label.ptr))));
            }
            keys.insert(key);
            own.push(value);
        }
        if let (Some((other, label)), Some(at)) = (clash, at) {
            let place = types::place(&self.spec, other);

            self.report(
                Finding::new(
                    ValueProblem::LabelTaken {
                        name: self.spec.ty(other).name.clone().unwrap_or_default(),
                    },
                    at,
                )
                .related(label, Role::ThisLabel)
                .related(place, Role::OtherMember),
            );
        }
        if let Some((_, Some(id))) = member {
            for key in keys {
                // The first member that has a label is the one that is named.
                used.entry(key).or_insert(id);
            }
        }
        own
    }

    fn bad_label(
        &mut self,
        misfit: ConversionError,
        value: &Const,
        switch: TypeId,
        member: Option<Src>,
        label: Src,
    ) {
        let diagnostic = Finding::new(
            explain_misfit(&self.spec, misfit, value, switch, Purpose::Label),
            member.unwrap_or(label),
        );
        let diagnostic = match member {
            Some(_) => diagnostic.related(label, Role::ThisLabel),
            None => diagnostic,
        };
        self.report(diagnostic);
    }
}

/// Key of a label, for comparisons: equal labels have equal keys.
#[derive(PartialEq, Eq, Hash)]
enum LabelKey {
    Default,
    /// A character or a string: a character may be written in single or double quotes.
    Text(String),
    Bool(bool),
    Uint(u64),
    Int(i64),
    /// The bits of a floating point number.
    Float(u64),
    Enum(TypeId),
}

impl LabelKey {
    fn of(label: &Label) -> LabelKey {
        match label {
            Label::Default => LabelKey::Default,
            Label::Case(Value::Char(text) | Value::String(text)) => LabelKey::Text(text.clone()),
            Label::Case(Value::Bool(flag)) => LabelKey::Bool(*flag),
            Label::Case(Value::Uint(number)) => LabelKey::Uint(*number),
            Label::Case(Value::Int(number)) => LabelKey::Int(*number),
            Label::Case(Value::Float(number)) => LabelKey::Float(number.to_bits()),
            Label::Case(Value::Enum(enumeration)) => LabelKey::Enum(*enumeration),
        }
    }
}
