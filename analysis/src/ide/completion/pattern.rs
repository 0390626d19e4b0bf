//! Names of codels in the pattern of the component's other codels.

use rustc_hash::FxHashMap;

use super::names::VisibleNames;
use crate::{
    ide::context::{BodyKind, Context},
    model::{CodelKind, Component},
};

/// A pattern: `{c}` is the component, `{o}` the task or service, `{s}` the state; in capitals if they are
/// written in camel case.
type Pattern = String;

/// A name for a codel of the task or service around the cursor, with a state if it belongs to a machine;
/// unused in the component.
pub(super) fn codel_name(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    state: Option<&str>,
) -> String {
    let (_, frame) = context.body();
    let owner = context.name_of(frame).unwrap_or_default();
    let fallback = match (owner.is_empty(), state) {
        (true, _) => "codel".to_owned(),
        (false, Some(_)) => "{o}_{s}".to_owned(),
        (false, None) => "{o}_codel".to_owned(),
    };
    let component = names.component();
    let pattern = component.and_then(|component| {
        most_common_pattern(names, component, state.is_some(), context.body().0)
    });
    let pattern = pattern.unwrap_or(fallback);
    let own = component.map_or("", |component| component.name.as_str());
    let state = state.unwrap_or_default();
    let name = pattern
        .replace("{c}", own)
        .replace("{o}", &owner)
        .replace("{s}", state)
        .replace("{O}", &camel(&owner))
        .replace("{S}", &camel(state));
    names.unused_name_like(&name)
}

/// The pattern of most codels of the component.
fn most_common_pattern(
    names: &VisibleNames<'_, '_>,
    component: &Component,
    machine: bool,
    body: BodyKind,
) -> Option<Pattern> {
    let mut counts: FxHashMap<Pattern, usize> = FxHashMap::default();
    for (kind, owner, codels) in names.owners() {
        for codel in codels {
            if machine != (codel.kind == CodelKind::Fsm) || machine && kind != body {
                continue;
            }
            let state = codel.triggers.first().map_or("", |trigger| trigger.name.as_str());
            if let Some(found) = pattern_of(&codel.name, &component.name, owner, state) {
                *counts.entry(found).or_default() += 1;
            }
        }
    }
    // Ties are resolved in a fixed order.
    let best = counts.into_iter().max_by(|a, b| (a.1, &b.0).cmp(&(b.1, &a.0)));
    best.map(|(pattern, _)| pattern)
}

/// The pattern of one name; `None` if it does not distinguish codels.
fn pattern_of(name: &str, component: &str, owner: &str, state: &str) -> Option<Pattern> {
    let parts = [
        (owner.to_owned(), "{o}"),
        (camel(owner), "{O}"),
        (state.to_owned(), "{s}"),
        (camel(state), "{S}"),
        (component.to_owned(), "{c}"),
    ];
    let mut parts: Vec<_> = parts.into_iter().filter(|part| !part.0.is_empty()).collect();
    // A longer word may contain a shorter one.
    parts.sort_by_key(|part| std::cmp::Reverse(part.0.len()));
    let mut out = name.to_owned();
    for (word, place) in parts {
        if let Some(at) = whole_word_offset(&out, &word) {
            out.replace_range(at..at + word.len(), place);
        }
    }
    let tells = |text: &str| out.contains(text);
    let owner_told = tells("{o}") || tells("{O}");
    let state_told = state.is_empty() || tells("{s}") || tells("{S}");
    (owner_told && state_told).then_some(out)
}

/// The offset of a word in a name, bounded by `_`, a change of case, or a part that was already found.
fn whole_word_offset(name: &str, word: &str) -> Option<usize> {
    let bytes = name.as_bytes();
    let mut from = 0;
    while let Some(found) = name.get(from..)?.find(word) {
        let at = from + found;
        let end = at + word.len();
        let starts = at == 0
            || matches!(bytes.get(at - 1), Some(b'_' | b'}'))
            || bytes.get(at).is_some_and(u8::is_ascii_uppercase);
        let ends = bytes
            .get(end)
            .is_none_or(|byte| matches!(byte, b'_' | b'{') || byte.is_ascii_uppercase());
        let inside = name
            .get(..at)
            .is_some_and(|name| name.matches('{').count() > name.matches('}').count());
        if starts && ends && !inside {
            return Some(at);
        }
        from = at + 1;
    }
    None
}

/// `set_color` as `SetColor`.
fn camel(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for part in name.split('_') {
        let mut chars = part.chars();
        out.extend(chars.next().map(|character| character.to_ascii_uppercase()));
        out.push_str(chars.as_str());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_name_component_owner_and_state() {
        let of = |name, owner, state| pattern_of(name, "tank", owner, state);
        assert_eq!(of("tank_fill_start", "fill", "start").as_deref(), Some("{c}_{o}_{s}"));
        assert_eq!(of("SetColorStart", "set_color", "start").as_deref(), Some("{O}{S}"));
        assert_eq!(of("fill", "fill", "").as_deref(), Some("{o}"));
        // `all` is not a part of `fallen`, and without the state two codels have the same name.
        assert_eq!(of("fallen", "all", ""), None);
        assert_eq!(of("tank_fill", "fill", "start"), None);
    }
}
