//! Items that are being typed: the beginning of an item, above the next one, has no findings outside of it
//! and of what uses its names.
//!
//! The environment variable `DOTGEN_TIMES` multiplies the number of beginnings.

use dotgen_syntax::{
    NodeOrToken, SyntaxNode,
    ast::{self, AstNode},
};

use super::*;

/// Number of beginnings tried in the suite.
const BEGINNINGS: u64 = 400;

/// An item of a specification: its range, the end of the first token behind it, its tokens and its names.
struct Item {
    range: std::ops::Range<usize>,
    next: usize,
    ends: Vec<usize>,
    names: Vec<String>,
}

fn items(text: &str) -> Vec<Item> {
    let root = dotgen_syntax::parse_text(text).syntax();
    let is_item = |node: &SyntaxNode| ast::Item::can_cast(node.kind());
    root.descendants().filter(is_item).filter_map(|node| item(text, &node)).collect()
}

fn item(text: &str, node: &SyntaxNode) -> Option<Item> {
    let tokens = node.descendants_with_tokens().filter_map(NodeOrToken::into_token);
    let live = tokens.filter(|token| !token.kind().is_trivia() && !token.text_range().is_empty());
    let ends: Vec<usize> = live.map(|token| token.text_range().end().into()).collect();
    let start: usize = node.text_range().start().into();
    let end = *ends.last()?;
    let mut after = node.last_token()?.next_token();
    while let Some(token) = after.take_if(|token| token.kind().is_trivia()) {
        after = token.next_token();
    }
    if text[start..].starts_with('#') {
        return None;
    }
    let next = after.map_or(text.len(), |token| token.text_range().end().into());
    let names = node.descendants().filter(|inner| ast::Name::can_cast(inner.kind()));
    let names = names.map(|name| name.text().to_string()).collect();
    Some(Item { range: start..end, next, ends, names })
}

/// The errors outside of an item, and of what uses it, while only its first tokens are written.
fn strangers(component: &Component, item: &Item, end: usize) -> Vec<String> {
    let gone = item.range.end - end;
    let mut text = component.text.clone();
    text.replace_range(end..item.range.end, "\n");
    let is_user = |error: &Diagnostic| {
        let place = text.get(error.range.clone()).unwrap_or_default();
        item.names
            .iter()
            .any(|name| place.contains(name.as_str()) || error.message.to_string().contains(name))
    };
    let inside = item.range.start..=item.next + 1 - gone;
    let is_stranger = |error: &&Diagnostic| {
        (error.path != component.path || !inside.contains(&error.range.start)) && !is_user(error)
    };
    let line = |at: usize| text[..at].matches('\n').count() + 1;
    let errors = component.errors(&text);
    let strangers = errors.iter().filter(is_stranger);
    let shown = strangers.map(|error| format!("{}: {}", line(error.range.start), error.message));
    shown.collect()
}

#[test]
fn an_unfinished_item_leaves_the_others_alone() {
    let count = dotgen_loaders::times(BEGINNINGS);
    let components = examples();
    let all: Vec<(&Component, Item)> = components
        .iter()
        .flat_map(|component| items(&component.text).into_iter().map(move |item| (component, item)))
        .collect();
    let mut random = fastrand::Rng::with_seed(0x51_7c_c1_b7_27_22_0a_95);
    let mut bad = Vec::new();
    for _ in 0..count {
        let (component, item) = &all[random.usize(..all.len())];
        let end = item.ends[random.usize(..item.ends.len())];
        let strangers = strangers(component, item, end);
        if let Some(first) = strangers.first() {
            let typed = &component.text[item.range.start..end];
            let file = component.path.file_name().unwrap_or_default();
            bad.push(format!("{file}: {} errors, {first}, after `{typed}`", strangers.len()));
        }
    }
    assert!(bad.is_empty(), "{} of {count}:\n{}", bad.len(), bad.join("\n"));
}
