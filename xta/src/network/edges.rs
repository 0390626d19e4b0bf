//! Guards, invariants, synchronisations and updates to code.

use super::scope::Scope;
use crate::ast::{Binary, Expr, ExprKind};
use crate::code::{Code, Place};
use crate::error::{Res, fail};
use crate::types::Type;

/// A bound of a clock: `clock < value`, `clock <= value`, `clock > value` or `clock >= value`.
#[derive(Debug, Clone)]
pub(crate) struct Bound {
    pub(crate) clock: u32,
    pub(crate) upper: bool,
    pub(crate) strict: bool,
    pub(crate) value: Code,
}

/// A conjunction of conditions on integers and bounds of clocks.
#[derive(Debug, Clone, Default)]
pub(crate) struct Guard {
    pub(crate) conditions: Vec<Code>,
    pub(crate) bounds: Vec<Bound>,
}

#[derive(Debug, Clone)]
pub(crate) enum Update {
    Run(Code),
    /// Assigns an integer to a clock.
    Reset(u32, Code),
}

/// The channel of an edge, by code that gives its index.
#[derive(Debug, Clone)]
pub(crate) struct Sync {
    pub(crate) channel: Code,
    pub(crate) urgent: bool,
    pub(crate) broadcast: bool,
    pub(crate) sends: bool,
}

#[derive(Debug, Clone)]
pub(crate) struct Edge {
    pub(crate) source: i32,
    pub(crate) target: i32,
    pub(crate) guard: Guard,
    pub(crate) sync: Option<Sync>,
    pub(crate) updates: Vec<Update>,
}

#[derive(Debug, Clone)]
pub(crate) struct Location {
    pub(crate) name: String,
    pub(crate) invariant: Guard,
    pub(crate) committed: bool,
    pub(crate) urgent: bool,
}

#[derive(Debug, Clone)]
pub(crate) struct Process {
    pub(crate) name: String,
    pub(crate) locations: Vec<Location>,
    pub(crate) edges: Vec<Edge>,
    /// Indices of the edges of each location.
    pub(crate) outgoing: Vec<Vec<u32>>,
    pub(crate) priority: i32,
}

impl Scope<'_> {
    pub(crate) fn guard(&mut self, expr: &Expr, out: &mut Guard) -> Res<()> {
        if matches!(expr.kind, ExprKind::Rate) {
            return fail(expr.at, "rates of clocks (stopwatches) are not supported");
        }
        match &expr.kind {
            ExprKind::All(parts) => parts.iter().try_for_each(|part| self.guard(part, out)),
            _ if !self.mentions_clock(expr) => {
                if let Some(at) = rate(expr) {
                    return fail(at, "rates of clocks (stopwatches) are not supported");
                }
                let code = self.scalar(expr)?;
                if let Some(at) = effect(expr) {
                    return fail(at, "a condition must not assign");
                }
                out.conditions.push(code);
                Ok(())
            }
            ExprKind::Binary(operator, left, right) => {
                out.bounds.extend(self.bounds(expr.at, *operator, left, right)?);
                Ok(())
            }
            _ => fail(expr.at, "bounds of clocks can only be joined by `&&`"),
        }
    }

    /// The bounds that a comparison of a clock and an integer stands for.
    pub(crate) fn bounds(
        &mut self,
        at: u32,
        operator: Binary,
        left: &Expr,
        right: &Expr,
    ) -> Res<Vec<Bound>> {
        let (clock, value, operator) = match (self.clock(left)?, self.clock(right)?) {
            (Some(_), Some(_)) => return fail(at, "differences of clocks are not supported"),
            (Some(clock), None) => (clock, right, operator),
            (None, Some(clock)) => (clock, left, mirrored(operator)),
            (None, None) => {
                return fail(
                    at,
                    "expected a clock and an integer (differences of clocks are not supported)",
                );
            }
        };
        let value = self.scalar(value)?;
        let bound = |upper, strict| Bound { clock, upper, strict, value: value.clone() };
        Ok(match operator {
            Binary::Less => vec![bound(true, true)],
            Binary::LessEqual => vec![bound(true, false)],
            Binary::Greater => vec![bound(false, true)],
            Binary::GreaterEqual => vec![bound(false, false)],
            Binary::Equal => vec![bound(false, false), bound(true, false)],
            _ => return fail(at, "a clock is compared by `<`, `<=`, `==`, `>=` or `>`"),
        })
    }

    pub(crate) fn update(&mut self, expr: &Expr) -> Res<Update> {
        if let ExprKind::Assign(operator, target, value) = &expr.kind
            && let Some(clock) = self.clock(target)?
        {
            if operator.is_some() {
                return fail(expr.at, "a clock can only be assigned by `:=` or `=`");
            }
            if self.mentions_clock(value) {
                return fail(value.at, "a clock can only be assigned an integer");
            }
            return Ok(Update::Reset(clock, self.scalar(value)?));
        }
        if !matches!(expr.kind, ExprKind::Assign(..) | ExprKind::Step { .. } | ExprKind::Call(..)) {
            // `1` is the empty update of old models.
            let code = self.scalar(expr)?;
            return Ok(Update::Run(code));
        }
        Ok(Update::Run(self.scalar(expr)?))
    }

    /// The channel that an expression names.
    pub(crate) fn sync(&mut self, expr: &Expr, sends: bool) -> Res<Sync> {
        let Some(found) = self.located(expr)? else {
            return fail(expr.at, "expected a channel");
        };
        if !matches!(found.ty, Type::Chan { .. }) {
            return fail(expr.at, "expected a channel");
        }
        let channel = self.load(found.place.clone(), (0, i32::MAX));
        let any = self.any_channel(&found.place);
        let Some(info) = any.and_then(|any| self.program.channels.get(any)) else {
            return fail(expr.at, "expected a channel");
        };
        Ok(Sync { channel, urgent: info.urgent, broadcast: info.broadcast, sends })
    }

    /// One channel of an array of channels, all of which have one type.
    fn any_channel(&self, place: &Place) -> Option<usize> {
        let first = (place.offset & !crate::code::CONSTANT) as usize;
        self.program.constants.get(first).map(|channel| *channel as usize)
    }
}

fn mirrored(operator: Binary) -> Binary {
    match operator {
        Binary::Less => Binary::Greater,
        Binary::LessEqual => Binary::GreaterEqual,
        Binary::Greater => Binary::Less,
        Binary::GreaterEqual => Binary::LessEqual,
        other => other,
    }
}

/// Place of a part that a predicate finds.
fn part(expr: &Expr, found: fn(&ExprKind) -> bool) -> Option<u32> {
    if found(&expr.kind) {
        return Some(expr.at);
    }
    let any = |parts: &[Expr]| parts.iter().find_map(|inner| part(inner, found));
    match &expr.kind {
        ExprKind::Field(of, _) => part(of, found),
        ExprKind::All(parts) | ExprKind::Any(parts) | ExprKind::Call(_, parts) => any(parts),
        ExprKind::Choice(parts) => any(&parts[..]),
        ExprKind::Not(inner) | ExprKind::Negate(inner) => part(inner, found),
        ExprKind::Index(left, right)
        | ExprKind::Binary(_, left, right)
        | ExprKind::Assign(_, left, right) => part(left, found).or_else(|| part(right, found)),
        ExprKind::Step { place, .. } => part(place, found),
        ExprKind::Quantifier { body, .. } => part(body, found),
        _ => None,
    }
}

fn rate(expr: &Expr) -> Option<u32> {
    part(expr, |kind| matches!(kind, ExprKind::Rate))
}

/// Place of an assignment in an expression. Calls are not searched.
pub(crate) fn effect(expr: &Expr) -> Option<u32> {
    part(expr, |kind| matches!(kind, ExprKind::Assign(..) | ExprKind::Step { .. }))
}
