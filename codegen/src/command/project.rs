//! General options that a project sets if the command line does not.

use std::path::Path;

use super::options;

/// The settings of a project for reading its specifications.
#[derive(Debug, Default)]
pub struct Project {
    /// Directories searched for included files, after those of the command line.
    pub include_paths: Vec<String>,
    /// Macros and their bodies; macros of the command line take precedence.
    pub defines: Vec<(String, String)>,
}

impl Project {
    /// The arguments with the options of the project. `find` returns the project for the arguments after the
    /// general options.
    pub fn complete(args: &[String], find: impl FnOnce(&[String]) -> Project) -> Vec<String> {
        let Ok(given) = options::parse(args, Path::new("")) else {
            // These arguments are invalid and will be rejected with a reason.
            return args.to_vec();
        };
        let project = find(&given.rest);
        let mut at = args.len() - given.rest.len();
        if args[..at].last().is_some_and(|argument| argument == "--") {
            at -= 1;
        }
        let mut out = args[..at].to_vec();
        for dir in project.include_paths {
            out.extend(["-I".to_owned(), dir]);
        }
        for (name, body) in project.defines {
            if given.defines.iter().all(|define| define.0 != name) {
                out.extend(["-D".to_owned(), format!("{name}={body}")]);
            }
        }
        out.extend_from_slice(&args[at..]);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(line: &str, expected: &str) {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let project = |_: &[String]| Project {
            include_paths: vec!["/p/idl".to_owned()],
            defines: vec![("A".to_owned(), "1".to_owned())],
        };
        assert_eq!(Project::complete(&words, project).join(" "), expected);
    }

    #[test]
    fn what_is_given_comes_first_and_wins() {
        check("skeleton -I own x.gen", "-I /p/idl -D A=1 skeleton -I own x.gen");
        check(
            "-I inc -DA=2 -t t -- skeleton x.gen",
            "-I inc -DA=2 -t t -I /p/idl -- skeleton x.gen",
        );
        check("-l", "-l -I /p/idl -D A=1");
        check("--nonsense x.gen", "--nonsense x.gen");
    }
}
