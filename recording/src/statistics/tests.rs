//! Statistics compared with numbers worked out by hand, in the form that GenoM3's own tool prints.

use super::{Collector, Group, lines};

fn collected(files: &[&str]) -> Vec<Group> {
    let mut collector = Collector::default();
    for file in files {
        file.lines().for_each(|line| collector.line(line.as_bytes(), true));
        collector.file_ended();
    }
    collector.groups_in_order()
}

/// Returns a line of task `t` of component `c`, which begins when it asks. Times are in seconds.
fn line(began: &str, ended: &str, service: &str, from: &str, to: &str) -> String {
    let stamp = |text: &str| {
        let (seconds, fraction) = text.split_once('.').unwrap_or((text, ""));
        format!("{seconds}.{fraction:0<9}")
    };
    let (began, ended) = (stamp(began), stamp(ended));
    format!("{began} {began} {ended} c t {service} f_{from} ::c::{from} ::c::{to}\n")
}

#[test]
fn times_of_execution_and_cycles() {
    let log = [
        line("1", "1.1", "s", "start", "pause::run"),
        line("2", "2.3", "s", "run", "pause::run"),
        line("4", "4.2", "s", "run", "ether"),
    ]
    .concat();
    let expected = "\
# exec instance task service state codel count min max avg std
exec c t * * * 3 0.100000000 0.300000000 0.200000000 0.081649658
exec c t s * * 3 0.100000000 0.300000000 0.200000000 0.081649658
exec c t s ::c::run f_run 2 0.200000000 0.300000000 0.250000000 0.050000000
exec c t s ::c::start f_start 1 0.100000000 0.100000000 0.100000000 0.000000000

# cycle instance task service state codel count min max avg std
cycle c t * * * 2 1.000000000 2.000000000 1.500000000 0.500000000
cycle c t s * * 2 1.000000000 2.000000000 1.500000000 0.500000000
cycle c t s ::c::run f_run 1 2.000000000 2.000000000 2.000000000 0.000000000

# trans instance task service state codel from to count/total
trans c t * * * ::c::start ::c::pause::run 1/3
trans c t * * * ::c::run ::c::pause::run 1/3
trans c t * * * ::c::run ::c::ether 1/3
trans c t s * * ::c::start ::c::pause::run 1/3
trans c t s * * ::c::run ::c::pause::run 1/3
trans c t s * * ::c::run ::c::ether 1/3
trans c t s ::c::run f_run ::c::run ::c::pause::run 1/2
trans c t s ::c::run f_run ::c::run ::c::ether 1/2
trans c t s ::c::start f_start ::c::start ::c::pause::run 1/1
";
    assert_eq!(lines(&collected(&[&log])), expected);
}

#[test]
fn a_cycle_begins_after_a_pause_and_not_at_a_start() {
    let log = [
        line("1", "1.1", "s", "start", "work"),
        line("1.2", "1.3", "s", "work", "pause::start"),
        line("3", "3.1", "s", "start", "work"),
        line("3.2", "3.3", "s", "work", "pause::more"),
        line("6", "6.1", "s", "more", "ether"),
    ]
    .concat();
    let groups = collected(&[&log]);
    let service = groups.iter().find(|group| group.key.len() == 3).expect("a service");
    // From the second start to the run after the second pause: that run ends a cycle, and the starts do not.
    let cycle = service.cycle.expect("one");
    assert_eq!((cycle.count, cycle.least), (1, 3_000_000_000));
}

#[test]
fn of_lines_of_one_time_the_last_counts_wherever_they_stand() {
    let late = line("2", "2.5", "s", "start", "ether");
    let first = line("1", "1.9", "s", "start", "ether");
    let last = line("1", "1.1", "s", "start", "ether");
    let group = |files: &[&str]| collected(files).remove(0).execution;
    let one = group(&[&[late.clone(), first.clone(), last.clone()].concat()]);
    assert_eq!((one.count, one.least, one.greatest), (2, 100_000_000, 500_000_000));
    assert_eq!(group(&[&[late, first].concat(), &last]), one);
}

#[test]
fn cut_lines_count_with_what_they_have() {
    let groups = collected(&["1.000000000 1.000000000 2.000000000 c t\nrubbish\n"]);
    let text = lines(&groups);
    assert!(text.contains("exec c t {} {}  1 1.000000000 "), "{text}");
    // Only times, without names: the list of names is shorter.
    let text = lines(&collected(&["1.000000000 1.000000000 2.000000000"]));
    assert!(text.contains("\nexec {} * * * 1 1.000000000 "), "{text}");
    let groups = collected(&["1.0 1.0 0.500000000 c t s f a b"]);
    // Half a second backwards: -1 s and half a second.
    assert!(lines(&groups).contains("exec c t s a f 1 -1.500000000 "), "{}", lines(&groups));
}

#[test]
fn steps_of_the_clock_are_no_reason_to_fail() {
    let far = line("9000000000", "9000000000.1", "s", "start", "ether");
    let near = line("1", "1.1", "s", "start", "ether");
    let log: String = (0..40).map(|number| if number % 2 == 0 { &*near } else { &*far }).collect();
    let groups = collected(&[&log]);
    assert_eq!(groups[0].execution.count, 2);
    assert_eq!(groups[0].cycle.map(|cycle| cycle.least), Some(8_999_999_999_000_000_000));
}
