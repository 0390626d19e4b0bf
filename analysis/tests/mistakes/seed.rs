//! Common kinds of mistakes.

use super::*;

/// A kind of mistake: the correct text, and the mistake. `$` stands for a word, which stays.
const KINDS: &[(&str, &str, &str)] = &[
    ("no semicolon", ";\n", "\n"),
    ("no parenthesis", "$)\n", "$\n"),
    ("no parenthesis before a body", "$) {", "$ {"),
    ("no comma in parameters", "$, in $", "$ in $"),
    ("no angle bracket", "codel<$> $", "codel<$ $"),
    ("comma at the end of a yield", "yield $;", "yield $,;"),
    ("comma at the end of parameters", "in $)", "in $,)"),
    ("activity", "activity $", "activty $"),
    ("function", "function $", "fucntion $"),
    ("attribute", "attribute $", "atribute $"),
    ("yield", "yield $", "yeild $"),
    ("inout", "inout $", "inuot $"),
    ("code", "codel<$", "code<$"),
    ("codel", "codel $(", "cdoel $("),
    ("struct", "struct $ {", "strcut $ {"),
    ("exception", "exception $", "exeption $"),
    ("period", "period $", "perid $"),
    ("task", "task $ {", "tsak $ {"),
    ("port", "port in ", "prot in "),
    ("ids", "ids {", "idz {"),
    ("version", "version \"", "verison \""),
    ("throw", "throw $", "thorw $"),
    ("typedef", "typedef ", "typdef "),
    ("bool", "boolean $;", "bool $;"),
    ("int", "\n  long $;", "\n  int $;"),
    ("uint8_t", "octet $", "uint8_t $"),
    ("unsigned int", "unsigned long $", "unsigned int $"),
    ("hertz", "period 10 ms", "period 100 Hz"),
    ("no comma in yields", "yield $, $;", "yield $ $;"),
    ("a dot after pause", "pause::$", "pause.$"),
    ("a single colon", " $::$ ", " $:$ "),
    ("a shift", "> >", ">>"),
    ("double", "double $", "duoble $"),
    ("sequence", "sequence<", "sequnce<"),
    ("unsigned", "unsigned long $", "unsinged long $"),
    ("unsigned, a letter more", "unsigned $", "unsignned $"),
    ("local of a parameter", "(local in $", "(loacl in $"),
    ("local", "\n    local $", "\n    loacl $"),
    ("in of a codel", "(in $, ", "(im $, "),
    ("in of a service", "(in double $", "(iin double $"),
    ("out", ", out $", ", otu $"),
    ("outt", "(out $", "(outt $"),
    ("port outt", "port out $", "port outt $"),
    ("port output", "port out $", "port output $"),
    ("port input", "port in $", "port input $"),
    ("pause", "pause::$", "puase::$"),
    ("pause, a letter less", "yield pause::$", "yield paus::$"),
    ("coddel", "codel<$> $", "coddel<$> $"),
    ("coddel without states", "codel $(", "coddel $("),
    ("validate", "validate $(", "valdate $("),
    ("interrupt", "interrupts $", "interupts $"),
    ("priority", "priority $", "priotiry $"),
    ("stack", "stack $", "stak $"),
    ("delay", "delay $", "dealy $"),
    ("doc", "doc \"", "dco \""),
    ("lang", "lang ", "langg "),
    ("const", "const $ ", "conts $ "),
    ("native", "native $;", "natvie $;"),
    ("enum", "enum $ {", "emun $ {"),
    ("optional", "optional<", "optionnal<"),
    ("float", "float $", "flaot $"),
    ("wcet", " wcet ", " wect "),
    ("async", "async codel", "asnyc codel"),
    ("async coedl", "async codel", "async coedl"),
    ("component", "component $ {", "compnent $ {"),
    ("module", "module $ {", "moduel $ {"),
    ("throws of a task", "throws $", "trhows $"),
    ("version without quotes", "version \"1.0\";", "version 1.0;"),
    ("lang without quotes", "lang    \"c\";", "lang    c;"),
    ("std::string", "string $;", "std::string $;"),
    ("std::vector", "sequence<$> ", "std::vector<$> "),
    ("vector", "sequence<$", "vector<$"),
    ("brackets", "codel<$> $", "codel[$] $"),
    ("brackets of two states", "codel<$, $> $", "codel[$, $] $"),
    ("an arrow", ".$)", "->$)"),
    ("a comment of Ada", "; // ", "; -- "),
    ("and", "yield $, $;", "yield $ and $;"),
    ("and after pause", "yield pause::$, $;", "yield pause::$ and $;"),
    ("or", "yield pause::$, $;", "yield pause::$ or $;"),
    ("throw and", "throw $, $;", "throw $ and $;"),
    ("a digit first", "double $;", "2double $;"),
    ("single quotes", "version \"1.0\"", "version '1.0'"),
    ("a state", "yield pause::$, ether", "yield pause::$, ehter"),
    ("ether", "yield ether", "yield etehr"),
    ("two commas", ", in $", ",, in $"),
    ("colon", "period 5 ms;", "period 5 ms:"),
    ("equals", "period $ ms;", "period = $ ms;"),
    ("milliseconds", " ms;", " msec;"),
    ("microseconds", " us;", " usec;"),
    ("uint32_t", "unsigned long $;", "uint32_t $;"),
    ("int16_t", "short $;", "int16_t $;"),
    ("float64", "double $;", "float64 $;"),
    ("true", "= TRUE", "= true"),
    ("struct of a member", "struct $ {", "structt $ {"),
    ("switch", "switch ($", "swich ($"),
    ("case", "case $:", "csae $:"),
    ("a state without pause's colons", "pause::$", "pause $"),
];

/// The seeded mistakes at each possible place: the text with the mistake, and its offset.
fn places(text: &str, right: &str, wrong: &str) -> Vec<(String, usize)> {
    let masked = mask(text);
    let mut out = Vec::new();
    for at in 0..text.len() {
        let Some((length, words)) = fits(&masked[at..], right) else {
            continue;
        };
        // Only whole words match.
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let first = right.chars().next().unwrap_or(' ');
        if (is_word(first) || first == '$') && masked[..at].ends_with(is_word) {
            continue;
        }
        let mut words = words.iter();
        let instead: String = wrong
            .split_inclusive('$')
            .map(|part| match part.strip_suffix('$') {
                Some(rest) => format!("{rest}{}", words.next().map_or("", |word| *word)),
                None => part.to_owned(),
            })
            .collect();
        let mut broken = text.to_owned();
        broken.replace_range(at..at + length, &instead);
        // The place is the first difference of the texts.
        let same = text.bytes().zip(broken.bytes());
        let same = same.take_while(|(a, b)| a == b).count();
        out.push((broken, same));
    }
    out
}

/// Length of the text that a pattern matches, and its words.
fn fits<'t>(text: &'t str, pattern: &str) -> Option<(usize, Vec<&'t str>)> {
    let (mut at, mut words) = (0, Vec::new());
    for part in pattern.split_inclusive('$') {
        let literal = part.strip_suffix('$').unwrap_or(part);
        at += text.get(at..)?.strip_prefix(literal).map(|_| literal.len())?;
        if part.ends_with('$') {
            let rest = &text[at..];
            let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
            let end = end.unwrap_or(rest.len());
            if end == 0 {
                return None;
            }
            words.push(&rest[..end]);
            at += end;
        }
    }
    Some((at, words))
}

/// The text with comments, contents of strings, and directives replaced by blanks; as many bytes, all ASCII.
fn mask(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("//") || first == '#' {
            rest.find('\n').unwrap_or(rest.len())
        } else if first == '"' {
            rest[1..].find('"').map_or(rest.len(), |end| end + 2)
        } else {
            first.len_utf8()
        };
        let (part, after) = rest.split_at(length);
        let keep = length == 1 && first.is_ascii();
        out.extend(part.bytes().map(|byte| match byte {
            b'\n' | b'"' => char::from(byte),
            _ if keep => char::from(byte),
            _ => '\u{1}',
        }));
        rest = after;
    }
    out
}

/// A text without the parts that formatting may change.
fn bare(text: &str) -> String {
    text.split_whitespace().collect()
}

#[derive(Default)]
struct Score {
    all: usize,
    restored: usize,
    on_line: usize,
    alone: usize,
}

#[test]
fn the_first_fix_restores_what_was_meant() {
    let mut components = examples();
    let published = published();
    // The examples alone have fewer places for mistakes.
    let least = if published.is_empty() { 100 } else { 150 };
    components.extend(published);
    let print = std::env::var_os("MISTAKES").is_some();
    let mut score = Score::default();
    let mut notes = Vec::new();
    for (name, right, wrong) in KINDS {
        let all: Vec<(&Component, String, usize)> = components
            .iter()
            .flat_map(|component| {
                let places = places(&component.text, right, wrong).into_iter();
                places.map(move |(text, at)| (component, text, at))
            })
            .collect();
        // The first and one further on, usually in another component.
        let mut chosen = vec![0, all.len() / 2];
        chosen.dedup();
        for (component, broken, at) in chosen.iter().filter_map(|place| all.get(*place)) {
            let errors = component.errors(broken);
            let line = |at: usize| broken[..at.min(broken.len())].matches('\n').count();
            let on_line = errors.iter().any(|error| {
                error.path == component.path
                    && line(error.range.start) == line(at.saturating_sub(0))
            });
            let fix = errors.iter().find_map(|error| error.fixes.first());
            let fixed = fix.and_then(|fix| apply(&component.path, broken, fix));
            let restored = fixed.is_some_and(|fix| bare(&fix) == bare(&component.text));
            score.all += 1;
            score.restored += usize::from(restored);
            score.on_line += usize::from(on_line);
            score.alone += usize::from(errors.len() == 1);
            if !(restored && on_line && errors.len() == 1) {
                notes.push(format!(
                    "{name} in {} line {}: restored {restored}, on its line {on_line}, {} errors {:?}, fix \
                        {:?}",
                    component.path.file_name().unwrap_or_default(),
                    line(*at) + 1,
                    errors.len(),
                    errors.iter().take(2).map(|error| (line(error.range.start) + 1, &error.message)).collect::<Vec<_>>(),
                    fix.map(|fix| &fix.title),
                ));
            }
        }
    }
    let Score { all, restored, on_line, alone } = score;
    if print {
        for note in &notes {
            println!("{note}");
        }
        println!(
            "{all} mistakes: {restored} restored, {on_line} on their line, {alone} are one error"
        );
    }
    assert!(all >= least, "only {all} mistakes were seeded");
    let enough = |count: usize, percent: usize| count * 100 >= percent * all;
    assert!(
        enough(restored, 90) && enough(on_line, 96) && enough(alone, 90),
        "{all} mistakes: {restored} restored, {on_line} on their line, {alone} are one error\n{}",
        notes.join("\n")
    );
}

#[test]
fn a_misspelt_path_of_an_include_is_restored() {
    let folder = root().join("examples/outdoor").canonicalize().unwrap();
    let folder = Utf8PathBuf::from_path_buf(folder).unwrap();
    let path = folder.join("misspelt.gen");
    let component = Component { text: String::new(), includes: vec![folder.join("idl")], path };
    for (right, wrong) in [("rob.gen", "rbo.gen"), ("idl/rob.gen", "ild/rob.gen")] {
        let text = |text: &str| format!("#include \"{text}\"\n");
        assert!(component.errors(&text(right)).is_empty(), "{right}");
        let broken = text(wrong);
        let errors = component.errors(&broken);
        assert_eq!(errors.len(), 1, "{errors:#?}");
        let fix = errors[0].fixes.first().expect("it has a fix");
        assert_eq!(apply(&component.path, &broken, fix), Some(text(right)), "{wrong}");
    }
}
