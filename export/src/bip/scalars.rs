//! Conditions and statements over single integers: BIP has neither arrays nor conditional expressions.
//!
//! A condition or statement in which a variable is an index gets one alternative for each value of the
//! variable.

use crate::model::{Guard, Network, Relation, Term, Variable, all, any, var};
use crate::uppaal::{guard, term};

/// Returns the integers of a variable: itself, or the elements of an array.
pub(super) fn names(variable: &Variable) -> Vec<String> {
    match variable.size {
        None => vec![variable.name.clone()],
        Some(size) => (0..size).map(|index| format!("{}_{index}", variable.name)).collect(),
    }
}

/// Returns a condition without elements of arrays.
pub(super) fn condition(of: &Guard, network: &Network) -> Guard {
    let parts = match of {
        Guard::And(list) => &list[..],
        other => std::slice::from_ref(other),
    };
    let Some(index) = parts.iter().find_map(index_in_guard) else {
        return all(parts.iter().map(|part| by_cases(part, network)));
    };
    let (with, without): (Vec<&Guard>, Vec<&Guard>) =
        parts.iter().partition(|part| substituted(part, &index, 0) != **part);
    let alternatives = values(&index, network).map(|value| {
        let with = all(with.iter().map(|part| substituted(part, &index, value)));
        all([var(&index).is(value), condition(&with, network)])
    });
    let without = all(without.into_iter().cloned());
    all([condition(&without, network), any(alternatives)])
}

/// Returns a condition without elements of arrays, if no variable is an index outside of its parts.
fn by_cases(of: &Guard, network: &Network) -> Guard {
    match of {
        Guard::Compare(left, relation, right) => {
            let (left, right) = (cases(left, network), cases(right, network));
            any(left.iter().flat_map(|(when, left)| {
                right.iter().map(move |(also, right)| {
                    all([when.clone(), also.clone(), compare(left, *relation, right)])
                })
            }))
        }
        Guard::And(list) => all(list.iter().map(|part| condition(part, network))),
        Guard::Or(list) => any(list.iter().map(|part| condition(part, network))),
    }
}

/// Returns a comparison, which is true or false if both terms are numbers.
fn compare(left: &Term, relation: Relation, right: &Term) -> Guard {
    let (Term::Number(first), Term::Number(second)) = (left, right) else {
        return Guard::Compare(left.clone(), relation, right.clone());
    };
    if relation.holds(*first, *second) { Guard::always() } else { any([]) }
}

/// Returns the statements that set targets to values, in order.
pub(super) fn statements(updates: &[(Term, Term)], network: &Network) -> Vec<String> {
    let index_of = |(target, value): &(Term, Term)| index_in(target).or_else(|| index_in(value));
    let mut out = Vec::new();
    let mut rest = updates;
    while let Some(first) = rest.first() {
        let index = index_of(first);
        // One alternative contains updates that leave the index as it is.
        let follows = |update: &&(Term, Term)| {
            let keeps = |name: &String| match &update.0 {
                Term::Element(array, _) => !name.starts_with(array.as_str()),
                _ => false,
            };
            index.as_ref().is_some_and(keeps) && index_of(update) == index
        };
        let count = rest.iter().take_while(follows).count().max(1);
        let (run, after) = rest.split_at(count);
        out.push(match index {
            None => statement(first, network),
            Some(index) => chain(values(&index, network).map(|number| {
                let run: Vec<(Term, Term)> = (run.iter())
                    .map(|(target, value)| {
                        (replaced(target, &index, number), replaced(value, &index, number))
                    })
                    .collect();
                (var(&index).is(number), statements(&run, network).join(" "))
            })),
        });
        rest = after;
    }
    out.retain(|statement| !statement.is_empty());
    out
}

/// Returns an assignment in which no variable is an index; empty if it changes nothing.
fn statement((target, value): &(Term, Term), network: &Network) -> String {
    let (targets, values) = (cases(target, network), cases(value, network));
    chain(targets.iter().flat_map(|(_, target)| {
        values.iter().map(move |(when, value)| {
            let changes = value != target;
            let text = format!("{} = {};", term(target), term(value));
            (when.clone(), if changes { text } else { String::new() })
        })
    }))
}

/// Returns the alternative whose condition holds; at most one holds.
fn chain(alternatives: impl Iterator<Item = (Guard, String)>) -> String {
    let mut out = Vec::new();
    for (condition, text) in alternatives.filter(|(_, text)| !text.is_empty()) {
        if condition.is_true() {
            return text;
        }
        out.push(format!("if ({}) then {text}", guard(&condition)));
    }
    out.join("\n      else ") + &" fi".repeat(out.len())
}

/// Returns the values of an integer.
fn values(name: &str, network: &Network) -> impl Iterator<Item = i64> {
    let mut variables = network.variables.iter();
    let variable = variables.find(|variable| names(variable).iter().any(|integer| integer == name));
    0..=variable.map_or(0, |variable| variable.most)
}

/// Returns an integer that is an index.
fn index_in_guard(of: &Guard) -> Option<String> {
    match of {
        Guard::Compare(left, _, right) => index_in(left).or_else(|| index_in(right)),
        Guard::And(list) | Guard::Or(list) => list.iter().find_map(index_in_guard),
    }
}

fn index_in(of: &Term) -> Option<String> {
    match of {
        Term::Number(_) | Term::Variable(_) => None,
        Term::Element(_, index) => integer_in(index),
        Term::Sum(term, _) => index_in(term),
        Term::If(choice, yes, no) => {
            index_in_guard(choice).or_else(|| index_in(yes)).or_else(|| index_in(no))
        }
    }
}

/// Returns an integer of an index.
fn integer_in(index: &Term) -> Option<String> {
    match index {
        Term::Variable(name) => Some(name.clone()),
        Term::Element(array, inner) => integer_in(inner).or_else(|| element(array, inner)),
        Term::Sum(term, _) => integer_in(term),
        Term::Number(_) | Term::If(..) => index_in(index),
    }
}

/// Returns the integer that is an element of an array, if the index is a number.
fn element(array: &str, index: &Term) -> Option<String> {
    match index {
        Term::Number(number) => Some(format!("{array}_{number}")),
        _ => None,
    }
}

/// Returns a condition with a number for a variable.
fn substituted(of: &Guard, name: &str, number: i64) -> Guard {
    match of {
        Guard::Compare(left, relation, right) => {
            Guard::Compare(replaced(left, name, number), *relation, replaced(right, name, number))
        }
        Guard::And(list) => all(list.iter().map(|part| substituted(part, name, number))),
        Guard::Or(list) => any(list.iter().map(|part| substituted(part, name, number))),
    }
}

/// Returns a term with a number for a variable.
fn replaced(of: &Term, name: &str, number: i64) -> Term {
    let inner = |term: &Term| Box::new(replaced(term, name, number));
    match of {
        Term::Variable(variable) if variable == name => Term::Number(number),
        Term::Number(_) | Term::Variable(_) => of.clone(),
        Term::Element(array, index) if element(array, index).as_deref() == Some(name) => {
            Term::Number(number)
        }
        Term::Element(array, index) => Term::Element(array.clone(), inner(index)),
        Term::Sum(term, more) => plus(replaced(term, name, number), *more),
        Term::If(choice, yes, no) => {
            Term::If(Box::new(substituted(choice, name, number)), inner(yes), inner(no))
        }
    }
}

fn plus(term: Term, number: i64) -> Term {
    match term {
        Term::Number(first) => Term::Number(first + number),
        Term::Sum(term, first) => plus(*term, first + number),
        term => term.plus(number),
    }
}

/// Returns the values of a term in which no variable is an index, each with the condition under which the
/// term has the value. There is none for an element outside of its array.
fn cases(of: &Term, network: &Network) -> Vec<(Guard, Term)> {
    match of {
        Term::Number(_) | Term::Variable(_) => vec![(Guard::always(), of.clone())],
        Term::Element(array, index) => {
            let name = element(array, index).filter(|name| {
                network.variables.iter().any(|variable| names(variable).contains(name))
            });
            name.map(|name| (Guard::always(), var(&name))).into_iter().collect()
        }
        Term::Sum(term, number) => {
            let sum = |(when, term): (Guard, Term)| (when, plus(term, *number));
            cases(term, network).into_iter().map(sum).collect()
        }
        Term::If(choice, yes, no) => {
            let choice = condition(choice, network);
            let with = |choice: Guard, term: &Term| -> Vec<(Guard, Term)> {
                let cases = cases(term, network).into_iter();
                cases.map(|(when, term)| (all([choice.clone(), when]), term)).collect()
            };
            [with(choice.clone(), yes), with(choice.negated(), no)].concat()
        }
    }
}
