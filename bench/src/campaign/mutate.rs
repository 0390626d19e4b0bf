//! Random mutations of a text, similar to typing.

use std::ops::Range;

/// Mutates a text once. Returns the new text and a description of the mutation.
pub(super) fn mutate(text: &str, random: &mut fastrand::Rng) -> Option<(String, String)> {
    let tokens = tokens(text);
    if tokens.is_empty() {
        return None;
    }
    let at = random.usize(..tokens.len());
    let token = tokens[at].clone();
    let word = &text[token.clone()];
    let line = text[..token.start].matches('\n').count() + 1;
    let (range, new, what) = match random.u8(..6) {
        0 => (token, String::new(), format!("delete `{word}`")),
        1 => (token, format!("{word} {word}"), format!("duplicate `{word}`")),
        2 => {
            let next = tokens.get(at + 1)?.clone();
            let new = format!("{}{}{word}", &text[next.clone()], &text[token.end..next.start]);
            let what = format!("swap `{word}` and `{}`", &text[next.clone()]);
            (token.start..next.end, new, what)
        }
        3 => {
            let quotes: Vec<_> = text.match_indices('"').map(|(at, _)| at).collect();
            let at = *random.choice(&quotes)?;
            let line = text[..at].matches('\n').count() + 1;
            let new = text[..at].to_owned() + &text[at + 1..];
            return Some((new, format!("line {line}: drop a quote")));
        }
        4 => {
            let is_word = |range: &&Range<usize>| text[(*range).clone()].len() > 2;
            let words: Vec<_> = tokens.iter().filter(is_word).collect();
            let token = (*random.choice(&words)?).clone();
            let old = &text[token.clone()];
            let cut = random.usize(1..old.len());
            let new: String = old[..cut - 1].to_owned() + &old[cut..];
            let line = text[..token.start].matches('\n').count() + 1;
            let all = format!("{}{new}{}", &text[..token.start], &text[token.end..]);
            return Some((all, format!("line {line}: misspell `{old}` as `{new}`")));
        }
        _ => (token.start..text.len(), String::new(), format!("cut before `{word}`")),
    };
    let new = format!("{}{new}{}", &text[..range.start], &text[range.end..]);
    Some((new, format!("line {line}: {what}")))
}

/// Words, and other ASCII characters that are not blank, outside comments.
fn tokens(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    let mut out = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &text.as_bytes()[at..];
        let start = at;
        if rest.starts_with(b"//") {
            at += rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        } else if rest.starts_with(b"/*") {
            let end = rest.windows(2).skip(2).position(|window| window == b"*/");
            at += end.map_or(rest.len(), |end| end + 4);
        } else if is_word(bytes[at]) {
            while at < bytes.len() && is_word(bytes[at]) {
                at += 1;
            }
            out.push(start..at);
        } else {
            at += 1;
            if bytes[start].is_ascii_graphic() {
                out.push(start..at);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mutations_are_reproducible_and_change_the_text() {
        let text = "component c {\n  /* é */ version \"1\";\n};\n";
        for seed in 0..200 {
            let make = || mutate(text, &mut fastrand::Rng::with_seed(seed));
            assert_eq!(make(), make());
            assert!(make().is_none_or(|make| make.0 != text), "{:?}", make());
        }
    }
}
