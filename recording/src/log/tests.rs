use super::*;

const PLAIN: &str = "0.020500000 0.020500001 0.023000000 pump report <permanent> report_start \
                     ::pump::start ::pump::pause::start";

#[test]
fn a_line_has_its_nine_columns() {
    let line = line(PLAIN.as_bytes()).expect("a line");
    assert_eq!((line.asked, line.began, line.ended), (20_500_000, 20_500_001, 23_000_000));
    let names = line.names().expect("six");
    assert_eq!(names[0], b"pump");
    assert_eq!(names[5], b"::pump::pause::start");
    assert!(line.exact);
    assert_eq!(LineKinds::default().of(&line), (0, LineSubject::Codel));
}

#[test]
fn times_are_read_alike_fast_and_with_care() {
    let tail = " pump report";
    for times in [
        "0.020500000 0.020500001 0.023000000",
        "1700000000.123456789 1700000000.999999999 1700000001.000000000",
        "9999999999.000000000 9999999999.000000000 9999999999.000000000",
        "12345678901.000000000 12345678901.000000000 12345678901.000000001",
        "0.5 0.50 0.500000000",
        "0.02050000a 0.020500001 0.023000000",
        ".020500000 0.020500001 0.023000000",
        "0.020500000 0.020500001 0.0230000001",
        "0.020500000 0.020500001 0.02300000/",
        "0.020500000 0.020500001 0.02300000:",
        "0.020500000 0.020500001 0.0230000\u{b2}",
        "0.020500000 0,020500001 0.023000000",
    ] {
        let fast = line(format!("{times}{tail}").as_bytes()).map(|line| (line.ended, line.exact));
        // A recorder never writes a blank in front.
        let careful =
            line(format!(" {times}{tail}").as_bytes()).map(|line| (line.ended, line.exact));
        assert_eq!(fast, careful, "{times}");
    }
    for number in [0u32, 1, 9, 10, 12_345_678, 99_999_999, 90_000_000] {
        let text = format!("{number:08}");
        let text = <[u8; 8]>::try_from(text.as_bytes()).expect("eight");
        assert_eq!(eight_digits(text), Some(number));
    }
}

#[test]
fn what_is_no_run_is_counted() {
    let (mut left, mut kinds) = (SkippedLines::default(), LineKinds::default());
    let cut = &PLAIN[..60];
    let genom =
        "1.000000000 1.000000000 2.000000000 genom profiling writer prof_writer wakeup sleep";
    let overload = PLAIN.replace("report_start", "genom_prof_record");
    let step = PLAIN.replace("0.023", "0.003");
    for text in [cut, genom, &overload, &step, "hello", "", "1.5 x 3", "-1.0 2.0 3.0 a b c d e f"] {
        assert_eq!(left.classify(&mut kinds, text.as_bytes(), true), None, "{text}");
    }
    assert!(left.classify(&mut kinds, PLAIN.as_bytes(), true).is_some());
    assert!(left.classify(&mut kinds, PLAIN.as_bytes(), false).is_none());
    let expected = SkippedLines { recorder: 1, overloads: 1, clock_steps: 1, cut: 2, garbage: 3 };
    assert_eq!(left, expected);
    // One word too many.
    let more = format!("{PLAIN} more");
    assert_eq!(line(more.as_bytes()).and_then(|line| line.names()), None);
}

#[test]
fn lines_come_whole_however_they_are_read() {
    let text = format!("{PLAIN}\r\nnext\n\n{}", &PLAIN[..9]);
    let read = |size: usize| {
        let (mut lines, mut all) = (Lines::default(), Vec::new());
        for piece in text.as_bytes().chunks(size) {
            lines.feed(piece, |number, line| all.push((number, line.to_vec())));
        }
        all.extend(lines.unterminated_line().map(|line| (line.0, line.1.to_vec())));
        all
    };
    let whole = read(text.len());
    assert_eq!(whole.len(), 4);
    for size in 1..70 {
        assert_eq!(read(size), whole);
    }
    assert!(line(&whole[0].1).is_some_and(|line| line.tail.ends_with(b"::pause::start")));
}

#[test]
fn a_log_is_read_up_to_any_byte() {
    let text = format!("{}{PLAIN}\n{PLAIN}\n{}", origins(false, [].into_iter()), end());
    for length in 0..=text.len() {
        let (mut lines, mut breaks) = (Lines::default(), TruncationCheck::default());
        let (mut left, mut kinds) = (SkippedLines::default(), LineKinds::default());
        let mut runs = 0;
        let mut read = |number, line: &[u8], ended| {
            breaks.line(number, line, ended);
            runs += usize::from(left.classify(&mut kinds, line, ended).is_some());
        };
        lines.feed(&text.as_bytes()[..length], |number, line| {
            read(number, line, true);
        });
        if let Some((number, line)) = lines.unterminated_line() {
            read(number, line, false);
        }
        let whole = text[..length].matches('\n').count();
        assert_eq!(runs, whole.saturating_sub(1).min(2), "{length}");
        let expected = (length > 0 && length < text.len()).then_some(whole as u64);
        assert_eq!(breaks.after(), expected, "{length}");
    }
}

#[test]
fn a_line_without_end_takes_no_memory() {
    let mut lines = Lines::default();
    for _ in 0..100 {
        lines.feed(&[b'x'; 10_000], |_, _| panic!("it has no end"));
    }
    assert!(lines.rest.len() <= MAX_LINE_BYTES);
    let mut all = Vec::new();
    lines.feed(b"\nnext\n", |_, line| all.push(line.to_vec()));
    assert_eq!(all, [b"".to_vec(), b"next".to_vec()]);
}
