//! Recordings that break off.

use super::*;
use crate::replay::Rule;

fn about() -> RunInfo {
    RunInfo {
        scenario: "sailing".to_owned(),
        unit: "1/1000000".to_owned(),
        clock: "real".to_owned(),
        outside: true,
        simulated: false,
        end: 70,
    }
}

fn step(time: u64) -> Step {
    Step {
        time,
        rule: Rule::Tick,
        of: "sail.main".to_owned(),
        what: String::new(),
        to: String::new(),
        executed: None,
    }
}

/// A recording of two chunks, each with three steps and a message of a port.
fn written() -> Vec<u8> {
    let mut writer = Writer::new(Vec::new(), &about()).expect("memory");
    for chunk in 0..2 {
        for time in 0..3 {
            let time = chunk * 30 + time * 10;
            writer.step(time, &step(time)).expect("memory");
        }
        let schema = || ("sail.wind".to_owned(), b"{}".to_vec());
        (writer.data(chunk, "/sail/wind", b"{}", schema)).expect("memory");
        writer.flush().expect("memory");
    }
    writer.finish(&about()).expect("memory")
}

#[test]
fn a_recording_is_read_up_to_any_byte() {
    let bytes = written();
    let whole = read(&bytes).expect("a recording");
    assert_eq!(whole.broken, None);
    assert_eq!((whole.about.clone(), whole.data), (about(), 2));
    assert_eq!(whole.steps, [0, 10, 20, 30, 40, 50].map(step));
    let data = read_data(&bytes).expect("a recording");
    let topics: Vec<&str> = data.topics.values().map(String::as_str).collect();
    assert_eq!((topics, data.broken), (vec!["/sail/wind"], None));
    let messages = data.messages.iter().map(|message| (message.at, message.text.as_slice()));
    assert_eq!(messages.collect::<Vec<_>>(), [(0, b"{}".as_slice()), (1, b"{}")]);
    let mut counts = Vec::new();
    for length in 0..bytes.len() {
        let Ok(cut) = read(&bytes[..length]) else {
            // Nothing is known of the run before its description.
            assert!(counts.is_empty(), "{length}");
            continue;
        };
        assert!(cut.broken.is_some(), "{length}");
        let count = cut.steps.len();
        assert_eq!(cut.steps, whole.steps[..count], "{length}");
        assert!(counts.last() <= Some(&count), "{length}");
        counts.push(count);
        // A run without end ends with its last step.
        let last = cut.steps.last().map_or(0, |step| step.time);
        assert!([last, 70].contains(&cut.about.end), "{length}");
        assert_eq!(cut.about.scenario, "sailing");
        assert!(cut.about.outside);
    }
    counts.dedup();
    // Steps of a chunk that is not whole are read, too.
    assert_eq!(counts, [0, 1, 2, 3, 4, 5, 6]);
}

#[test]
fn a_chunk_is_in_the_file_when_it_is_flushed() {
    let mut writer = Writer::new(Vec::new(), &about()).expect("memory");
    writer.step(1, &step(1)).expect("memory");
    writer.flush().expect("memory");
    writer.step(2, &step(2)).expect("memory");
    // As a run leaves it that is killed.
    let written = writer.out.into_inner().into_inner();
    let read = read(&written).expect("a recording");
    assert_eq!(read.steps, [step(1)]);
    assert!(read.broken.is_some());
    assert_eq!(read.about.end, 1);
}

#[test]
fn zeros_of_a_power_cut_end_a_recording() {
    let bytes = written();
    for length in 0..bytes.len() {
        let mut zeroed = bytes[..length].to_vec();
        zeroed.resize(bytes.len(), 0);
        if let Ok(read) = read(&zeroed) {
            assert!(read.broken.is_some(), "{length}");
        }
        // A byte that is wrong, whatever it makes of the file.
        let mut wrong = bytes.clone();
        wrong[length] ^= 0xff;
        let _ = read(&wrong);
    }
}

#[test]
fn a_wrong_byte_of_a_chunk_is_damage_and_ends_the_steps_before_the_chunk() {
    let bytes = written();
    let whole = read(&bytes).expect("a recording");
    let second = bytes.windows(9).rposition(|window| window == b"\"time\":30").expect("a step");
    let chunk = {
        let damaged =
            |bytes: &[u8]| read(bytes).expect("a recording").broken.expect("a break").damaged;
        let mut wrong = bytes.clone();
        wrong[second + 7] ^= 7;
        let read = read(&wrong).expect("a recording");
        assert_eq!(read.steps, whole.steps[..3], "only the intact chunk");
        assert_eq!(read.about.end, 20, "the run ends with the last intact step");
        damaged(&wrong).expect("a place")
    };
    assert_eq!(bytes[chunk], mcap::records::op::CHUNK);
    assert!(chunk < second && second - chunk < 300, "{chunk} {second}");
    // Before the chunk, and outside of chunks, too: every byte of the data of the run counts.
    let end = bytes.windows(9).rposition(|window| window == [0x0f, 4, 0, 0, 0, 0, 0, 0, 0]);
    for at in 8..end.expect("the end of the data") {
        let mut wrong = bytes.clone();
        wrong[at] ^= 1;
        if let Ok(read) = read(&wrong) {
            let broken =
                read.broken.unwrap_or_else(|| panic!("byte {at} is wrong, and nobody saw"));
            assert!(broken.damaged.is_some(), "{at}: {broken}");
            assert!(whole.steps.starts_with(&read.steps), "{at}");
        }
    }
}

#[test]
fn a_length_is_at_most_what_is_left() {
    // Each length of a name is as long as four bytes can say: that much memory is not asked for.
    let bytes = written();
    for name in ["dotgen.run", "scenario", "sailing", STEPS] {
        let at = bytes.windows(name.len()).position(|window| window == name.as_bytes());
        let mut wrong = bytes.clone();
        wrong[at.expect("a name") - 1] = 0xff;
        let damaged = match read(&wrong) {
            Ok(read) => read.broken.expect("a break").to_string(),
            Err(error) => error,
        };
        assert!(damaged.contains("damaged at byte"), "{name}: {damaged}");
    }
}

#[test]
fn other_files_are_refused() {
    for bytes in [&b""[..], b"some text, and no recording"] {
        assert!(read(bytes).is_err());
    }
}
