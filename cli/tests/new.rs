//! `dotgen new`: what it leaves is in shape, sound, in step with its codels, and proved.

use crate::directory::{Directory, status, stderr, stdout};

#[test]
fn a_new_component_is_sound_in_step_and_proved() {
    for (tasks, interfaces) in [
        (&[][..], &[][..]),
        (&["--task", "fast=5ms", "--task", "slow=0.5s"][..], &[][..]),
        (&["--task", "plan"][..], &["--provides", "pose.gen:pose"][..]),
        (
            &["--task", "exec=10 ms", "--task", "plan"][..],
            &["--uses", "pose.gen:pose", "--provides", "pose.gen:speed"][..],
        ),
    ] {
        let pose = "struct xy { double x, y; };\ninterface pose { port out xy position; };\n\
                    interface speed { port out xy velocity; };\n";
        let directory = Directory::new(&[("pose.gen", pose)]);
        let mut arguments = vec!["new", "nav"];
        arguments.extend(tasks);
        arguments.extend(interfaces);
        let made = directory.run(&arguments);
        assert_eq!(status(&made), 0, "{}", stderr(&made));
        assert!(stderr(&made).contains("wrote `nav/nav.gen`"), "{}", stderr(&made));
        for arguments in [
            &["fmt", "--check", "nav"][..],
            &["check", "nav"][..],
            &["codels", "check", "nav"][..],
            &["verify", "nav/nav.scn"][..],
        ] {
            let run = directory.run(arguments);
            let said = format!("{arguments:?}: {}{}", stdout(&run), stderr(&run));
            assert_eq!(status(&run), 0, "{said}");
            assert!(!said.contains("warning["), "{said}");
        }
        // A second one of that name changes nothing.
        let text = || std::fs::read_to_string(directory.path().join("nav/nav.gen"));
        let before = text().expect("it is written");
        let again = directory.run(&["new", "nav", "--task", "other=1s"]);
        assert_eq!(status(&again), 2, "{}", stderr(&again));
        assert!(stderr(&again).contains("is there already"), "{}", stderr(&again));
        assert_eq!(text().expect("it is there"), before);
    }
}

#[test]
fn commands_without_a_path_are_about_their_folder() {
    let directory = Directory::new(&[]);
    assert_eq!(status(&directory.run(&["new", "nav", "--directory", "."])), 0);
    for (command, part) in [
        ("check", "checked 2 files: no problems"),
        ("codels check", ""),
        ("codels sync", "there is nothing to mend"),
        ("fmt", "2 files left as before"),
        ("verify", "nav: any number of cores"),
    ] {
        let run = directory.run(&command.split(' ').collect::<Vec<_>>());
        let said = format!("{}{}", stdout(&run), stderr(&run));
        assert_eq!(status(&run), 0, "{said}");
        assert!(said.contains(part), "{command}: {said}");
    }
    std::fs::copy(directory.path().join("nav.scn"), directory.path().join("other.scn"))
        .expect("a copy");
    let run = directory.run(&["verify"]);
    assert_eq!(status(&run), 2);
    assert!(stderr(&run).contains("name one: nav.scn, other.scn"), "{}", stderr(&run));
}

#[test]
fn wrong_answers_are_refused_with_what_to_do() {
    let directory = Directory::new(&[("bad.gen", "interface bad { port out missing p; };\n")]);
    for (arguments, part) in [
        (&["new", "c", "--provides", "bad.gen:bad"][..], "bad.gen has an error"),
        (&["new", ""][..], "a component needs a name"),
        (&["new", "2d"][..], "`2d` is not a valid name"),
        (&["new", "struct"][..], "`struct` is a keyword"),
        (&["new", "c", "--task", "t=soon"][..], "as in `10 ms`"),
        (&["new", "c", "--uses", "x.gen:x"][..], "has an error: no such file"),
        (&["new", "c", "--uses", "pose"][..], "pose.gen:pose"),
    ] {
        let run = directory.run(arguments);
        assert_eq!(status(&run), 2, "{}", stderr(&run));
        assert!(stderr(&run).contains(part), "{}", stderr(&run));
    }
    assert!(!directory.path().join("c").exists());
}
