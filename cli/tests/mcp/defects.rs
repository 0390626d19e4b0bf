//! A benchmark: seeded defects that the tools have to find and to mend, without other help.

use dotgen_syntax::NodeOrToken;
use serde_json::json;

use super::Client;
use crate::directory::Directory;

/// Specifications without other files.
const SPECIFICATIONS: [&str; 3] = [
    include_str!("../../../examples/pump/pump.gen"),
    include_str!("../../../examples/motor/motor.gen"),
    include_str!("../../../examples/drift/tank.gen"),
];

/// Number of defects.
const DEFECTS: usize = 100;

/// Slips of people, as a change of one word or sign of a specification.
const SLIPS: [(&str, Slip); 5] = [
    ("two letters exchanged", exchanged),
    ("a letter left out", left_out),
    ("a letter doubled", doubled),
    ("a sign left out", without_sign),
    ("a sign doubled", with_two_signs),
];

/// The text after a slip; `None` if the slip changes nothing there.
type Slip = fn(&str, &mut fastrand::Rng) -> Option<String>;

/// The tokens of a text, with their offsets.
fn tokens(text: &str) -> Vec<(usize, String)> {
    let root = dotgen_syntax::parse_text(text).syntax();
    let all = root.descendants_with_tokens();
    let tokens = all.filter_map(NodeOrToken::into_token);
    let tokens = tokens.filter(|token| !token.kind().is_trivia());
    tokens.map(|token| (token.text_range().start().into(), token.text().to_owned())).collect()
}

/// A random word of at least three letters: its byte range. A word that occurs once may be any name, so
/// that a slip in it is not a defect.
fn word(text: &str, random: &mut fastrand::Rng) -> std::ops::Range<usize> {
    let tokens = tokens(text);
    let is_word =
        |token: &str| token.len() > 2 && token.bytes().all(|byte| byte.is_ascii_lowercase());
    let occurs_again = |word: &str| tokens.iter().filter(|token| token.1 == word).count() > 1;
    let words: Vec<_> =
        tokens.iter().filter(|(_, token)| is_word(token) && occurs_again(token)).collect();
    let (start, word) = words[random.usize(..words.len())];
    *start..start + word.len()
}

/// A random sign that ends or separates something: its offset.
fn sign(text: &str, random: &mut fastrand::Rng) -> usize {
    let tokens = tokens(text);
    let is_sign = |token: &str| [";", ",", ")", "("].contains(&token);
    let signs: Vec<_> = tokens.iter().filter(|(_, token)| is_sign(token)).collect();
    signs[random.usize(..signs.len())].0
}

fn exchanged(text: &str, random: &mut fastrand::Rng) -> Option<String> {
    let word = word(text, random);
    let at = random.usize(word.start..word.end - 1);
    let mut bytes = text.as_bytes().to_vec();
    bytes.swap(at, at + 1);
    String::from_utf8(bytes).ok().filter(|changed| changed != text)
}

fn left_out(text: &str, random: &mut fastrand::Rng) -> Option<String> {
    let word = word(text, random);
    let at = random.usize(word);
    Some(format!("{}{}", &text[..at], &text[at + 1..]))
}

fn doubled(text: &str, random: &mut fastrand::Rng) -> Option<String> {
    let word = word(text, random);
    let at = random.usize(word);
    Some(format!("{}{}", &text[..=at], &text[at..]))
}

fn without_sign(text: &str, random: &mut fastrand::Rng) -> Option<String> {
    let at = sign(text, random);
    Some(format!("{}{}", &text[..at], &text[at + 1..]))
}

fn with_two_signs(text: &str, random: &mut fastrand::Rng) -> Option<String> {
    let at = sign(text, random);
    Some(format!("{}{}", &text[..=at], &text[at..]))
}

/// The tokens of a text without their places: blanks do not count.
fn meaning(text: &str) -> Vec<String> {
    tokens(text).into_iter().map(|(_, token)| token).collect()
}

#[test]
fn seeded_defects_are_found_and_mended_with_the_tools_alone() {
    let directory = Directory::new(&[]);
    let mut client = Client::start(&directory);
    let mut random = fastrand::Rng::with_seed(1);
    let (mut found, mut mended) = (0, 0);
    for number in 0..DEFECTS {
        let (kind, slip) = SLIPS[number % SLIPS.len()];
        let right = SPECIFICATIONS[random.usize(..SPECIFICATIONS.len())];
        let wrong = loop {
            match slip(right, &mut random) {
                Some(wrong) if meaning(&wrong) != meaning(right) => break wrong,
                _ => {}
            }
        };
        directory.write("work/it.gen", wrong.as_bytes());
        let (told, _) = client.call("check", json!({ "path": "work/it.gen" }));
        if told.contains("error[") {
            found += 1;
            let all = json!({ "path": "work/it.gen", "unsafe-fixes": true });
            client.call("fix", all);
        }
        let now = directory.read("work/it.gen");
        if meaning(&now) == meaning(right) {
            mended += 1;
        } else {
            println!(
                "{kind}: not mended{}: {}",
                if told.contains("error[") { "" } else { ", not found" },
                difference(right, &wrong)
            );
        }
    }
    println!("{DEFECTS} defects: {found} found, {mended} mended");
    assert!(found * 100 >= DEFECTS * 97, "{found} of {DEFECTS} found");
    assert!(mended * 100 >= DEFECTS * 80, "{mended} of {DEFECTS} mended");
}

/// The first line in which two texts differ.
fn difference<'t>(right: &str, wrong: &'t str) -> &'t str {
    let mut lines = right.lines().zip(wrong.lines());
    lines.find(|(right, wrong)| right != wrong).map_or("", |(_, wrong)| wrong)
}
