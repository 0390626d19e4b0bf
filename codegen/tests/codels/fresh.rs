//! Steps of builds that are up to date.

use camino::Utf8PathBuf;
use dotgen_codegen::codels::build::{Contents, Step};
use dotgen_platform::files::disk::SystemDisk;

#[test]
fn a_step_is_as_fresh_as_the_texts_that_it_read_whatever_their_times() {
    let directory = tempfile::tempdir().expect("a directory");
    let place = Utf8PathBuf::from_path_buf(directory.path().to_owned()).expect("a name");
    let [source, header, output] = ["a.c", "a.h", "a.o"].map(|name| place.join(name));
    let write = |path: &Utf8PathBuf, text: &str| {
        std::fs::write(path, text).expect("written");
        // All times are the same, as after a copy that keeps them.
        let file = std::fs::File::options().append(true).open(path).expect("a file");
        file.set_modified(std::time::SystemTime::UNIX_EPOCH).expect("a time");
    };
    let step = Step {
        source: Some(source.clone()),
        output: output.clone(),
        command: vec!["cc".to_owned(), "-c".to_owned()],
        inputs: vec![source.clone()],
    };
    let is_fresh = |step: &Step| step.is_fresh(&mut Contents::new(&SystemDisk));
    write(&source, "int a;");
    write(&header, "int b;");
    write(&output, "code");
    let list = Utf8PathBuf::from(format!("{output}.d"));
    write(&list, &format!("{output}: {source} {header}\n"));
    assert!(!is_fresh(&step), "nothing is recorded");
    let recorded = step.recorded(&mut Contents::new(&SystemDisk)).expect("all inputs are there");
    write(&step.record(), &recorded);
    assert!(is_fresh(&step));
    for (path, text) in [(&source, "int a;"), (&header, "int b;")] {
        write(path, "int c;");
        assert!(!is_fresh(&step), "{path} has another text");
        write(path, text);
        assert!(is_fresh(&step), "{path} has its text again");
    }
    let optimized = Step { command: vec!["cc".to_owned(), "-O1".to_owned()], ..step.clone() };
    assert!(!is_fresh(&optimized), "another command");
    std::fs::remove_file(&header).expect("removed");
    assert!(!is_fresh(&step), "an input is missing");
    write(&header, "int b;");
    std::fs::remove_file(&output).expect("removed");
    assert!(!is_fresh(&step), "the output is missing");
}
