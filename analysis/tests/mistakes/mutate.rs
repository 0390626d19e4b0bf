//! Random changes of tokens: no fix makes a text worse, and repeated fixing terminates.

use super::*;
use dotgen_syntax::NodeOrToken;

/// Maximum number of rounds of fixing.
const MAX_ROUNDS: usize = 40;

/// The text with one token deleted, doubled, exchanged with the next one, or misspelt.
fn mutated(text: &str, random: &mut fastrand::Rng) -> String {
    let parse = dotgen_syntax::parse_text(text);
    let root = parse.syntax();
    let tokens: Vec<_> = root
        .descendants_with_tokens()
        .filter_map(NodeOrToken::into_token)
        .filter(|token| !token.kind().is_trivia() && !token.text_range().is_empty())
        .collect();
    let index = random.usize(..tokens.len().saturating_sub(1).max(1));
    let range = |token: usize| std::ops::Range::<usize>::from(tokens[token].text_range());
    let (here, next) = (range(index), range((index + 1).min(tokens.len() - 1)));
    let mut out = text.to_owned();
    match random.usize(..4) {
        0 => out.replace_range(here, ""),
        1 => out.insert_str(here.end, &format!(" {}", &text[here.clone()])),
        2 if next.start >= here.end => {
            out.replace_range(next.clone(), &text[here.clone()]);
            out.replace_range(here, &text[next]);
        }
        _ => {
            let word = &text[here.clone()];
            let cut = word.len() / 2;
            if word.is_char_boundary(cut) && word.len() > 2 && word.is_ascii() {
                out.replace_range((here.start + cut)..=(here.start + cut), "");
            }
        }
    }
    out
}

#[test]
fn no_fix_makes_it_worse_and_fixing_ends() {
    let count = dotgen_loaders::times(60);
    let components = examples();
    let mut random = fastrand::Rng::with_seed(0x9e37_79b9_7f4a_7c15);
    let mut bad = Vec::new();
    for _ in 0..count {
        let component = &components[random.usize(..components.len().max(1))];
        let mut text = mutated(&component.text, &mut random);
        let first = text.clone();
        let mut errors = component.errors(&text);
        for fix in errors.iter().flat_map(|error| &error.fixes) {
            let Some(after) = apply(&component.path, &text, fix) else {
                continue;
            };
            let left = component.errors(&after);
            if left.len() > errors.len() {
                bad.push(format!(
                    "{}: `{}` {} -> {} in\n{}",
                    component.path,
                    fix.title,
                    errors.len(),
                    left.len(),
                    difference(&component.text, &first)
                ));
            }
        }
        let mut rounds = 0;
        while let Some(after) = errors
            .iter()
            .filter_map(|error| error.fixes.first())
            .find_map(|fix| apply(&component.path, &text, fix))
        {
            rounds += 1;
            if rounds > MAX_ROUNDS - 2 {
                let error = errors.iter().find(|error| !error.fixes.is_empty());
                bad.extend(
                    error.map(|error| format!("{}, {}", error.message, error.fixes[0].title)),
                );
            }
            if rounds > MAX_ROUNDS {
                bad.push(format!(
                    "{}: fixing does not end\n{}",
                    component.path,
                    difference(&component.text, &first)
                ));
                break;
            }
            text = after;
            errors = component.errors(&text);
        }
    }
    assert!(
        bad.is_empty(),
        "{} of {count} texts:\n{}",
        bad.len(),
        bad[..bad.len().min(20)].join("\n")
    );
}

/// The lines that differ.
fn difference(a: &str, b: &str) -> String {
    let lines = a.lines().zip(b.lines()).filter(|(a, b)| a != b);
    lines.take(2).map(|(a, b)| format!("  - {a}\n  + {b}")).collect()
}
