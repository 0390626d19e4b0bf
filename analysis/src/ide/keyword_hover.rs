//! The meanings of the words of the language.

use dotgen_syntax::{SyntaxKind, SyntaxKind::*, SyntaxToken, TokenAtOffset};

use super::{FileView, Hover, RangeInfo};
use crate::source_map::{bytes, offset};

pub(crate) fn hover(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Hover>> {
    if at > view.text().len() || !view.text().is_char_boundary(at) {
        return None;
    }
    let (token, text) = match view.root().token_at_offset(offset(at)) {
        TokenAtOffset::None => return None,
        TokenAtOffset::Single(token) => keyword_with_meaning(token)?,
        TokenAtOffset::Between(left, right) => {
            keyword_with_meaning(right).or_else(|| keyword_with_meaning(left))?
        }
    };
    Some(RangeInfo {
        range: bytes(token.text_range()),
        info: Hover { markdown: format!("`{}`: {text}", token.text()), codels: Vec::new() },
    })
}

/// A keyword, not a name, with its meaning.
fn keyword_with_meaning(token: SyntaxToken) -> Option<(SyntaxToken, &'static str)> {
    let within = token.parent()?.kind();
    let text = match (token.kind(), within) {
        (_, NAME | NAME_REF) => return None,
        (kind, _) => keyword_meaning(kind)?,
    };
    Some((token, text))
}

#[allow(clippy::too_many_lines, reason = "one line for each word")]
fn keyword_meaning(word: SyntaxKind) -> Option<&'static str> {
    Some(match word {
        COMPONENT_KW => {
            "a program of the robot with its data (`ids`), ports, tasks and services. Opened again, it is \
                added to."
        }
        INTERFACE_KW => {
            "ports, services, data and tasks that components share: they `provides` it, `extends` it, or \
                `uses` it."
        }
        MODULE_KW => "a scope for types and constants, `name::type`.",
        IDS_KW => {
            "the internal data structure of a component: what its codels share. Those that use the same \
                members exclude each other, unless all only read."
        }
        PORT_KW => {
            "data that components exchange: an `out` port is written here and read elsewhere, an `in` port \
                the other way round. Its type must have a name."
        }
        MULTIPLE_KW => {
            "a port that stands for any number of ports of its type, told apart by a name at run time."
        }
        TASK_KW => {
            "a thread of the component. In the braces of the component it is declared: with a `period` or \
                without, and with codels of its own, if it always has something to do. In an activity it \
                says which task runs it."
        }
        PERIOD_KW => {
            "how often a task runs; in seconds, or in `ms` or `us`. A task without one is aperiodic: it \
                runs when there is something to do."
        }
        DELAY_KW => {
            "how long after the beginning of its period a task runs; shorter than the period."
        }
        PRIORITY_KW => "priority of a task: a number, whose meaning is that of the middleware.",
        SCHEDULING_KW | REAL_TIME_KW => {
            "`scheduling real-time` asks the system for real-time scheduling of a task."
        }
        STACK_KW => "size of the stack of a task, in bytes, or in `k` or `M`.",
        CLOCK_RATE_KW => {
            "the tick of a component, of which every `period` and `delay` is a multiple. By default the \
                greatest common divisor of them and of one second."
        }
        ATTRIBUTE_KW => {
            "a service that reads (`out`) or sets (`in`) members of the `ids`, without any code but \
                `validate`."
        }
        FUNCTION_KW => {
            "a short service that the control task executes itself; meanwhile no other request is answered."
        }
        ACTIVITY_KW => {
            "a service that takes time: a state machine, executed by a task, from `start` until `ether`. It \
                can be interrupted, and then goes on at `stop`."
        }
        REMOTE_KW => "a service of another component that a codel may call.",
        CODEL_KW => {
            "a function in C or C++: `codel<states> name(parameters) yield states`. It implements these \
                states of a machine, and its return value chooses the next one. In a function it has no \
                states."
        }
        ASYNC_KW => {
            "the codel runs beside its task, as long as it likes. So it must not share data with codels and \
                attributes that may run meanwhile."
        }
        VALIDATE_KW => {
            "a codel that accepts or refuses the parameters of a request before anything is done."
        }
        YIELDS_KW => {
            "the states that may follow a codel, of which it returns one. `pause::x` goes on at `x`, but in \
                the next period; `ether` is the end."
        }
        PAUSE_KW => {
            "`pause::x` goes on at the state `x`, but waits first: in a periodic task for the next period."
        }
        WCET_KW => {
            "worst-case execution time of a codel, in seconds, or in `ms` or `us`. An extension: GenoM3 \
                2.99 does not accept it, but ignores `#pragma wcet CODEL TIME`."
        }
        THROWS_KW => {
            "exceptions with which codels may end a task's machine or a service, from any state."
        }
        EXCEPTION_KW => "a type that `throw` may name, with data or without.",
        INTERRUPTS_KW => {
            "services that end when this one starts: their machines go on at `stop`. `all` stands for all \
                services; a service may name itself."
        }
        BEFORE_KW => "services that this one has to run before.",
        AFTER_KW => "services that have to run before this one.",
        LOCAL_KW => {
            "data of one running service: `local type name;` declares a variable, `local in x` gives one, \
                or a parameter, to a codel."
        }
        IN_KW => {
            "read: by the codel, by the service from its request, or by the component from a port."
        }
        OUT_KW => {
            "written: by the codel, by the service into its answer, or by the component to a port."
        }
        INOUT_KW => "read and written.",
        PROVIDES_KW => "the component has the ports, services, data and tasks of an interface.",
        EXTENDS_KW => "has everything that another interface has; the same as `provides`.",
        USES_KW => {
            "the other side of an interface: its ports with the direction turned round, and its services as \
                `remote`."
        }
        REQUIRES_KW => {
            "packages, by their names for `pkg-config`, that the component needs to be built."
        }
        CODELS_REQUIRES_KW => {
            "packages, by their names for `pkg-config`, that only the codels need."
        }
        DOC_KW => "documentation; repeated texts are joined.",
        VERSION_KW => "version of the component; `0` by default.",
        LANG_KW => "language of the codels, `\"c\"` (the default) or `\"c++\"`.",
        EMAIL_KW => "whom to write to about the component.",
        NATIVE_KW => {
            "a type of the implementation, of which the specification knows the name only; it cannot leave \
                the component."
        }
        SEQUENCE_KW => {
            "any number of elements, `sequence<type>`, or up to a bound, `sequence<type, 8>`."
        }
        OPTIONAL_KW => "a value or none, `optional<type>`.",
        OCTET_KW => "an unsigned number of 8 bits.",
        SHORT_KW => "a number of 16 bits, with a sign unless `unsigned`.",
        LONG_KW => "a number of 32 bits, `long long` of 64, with a sign unless `unsigned`.",
        FLOAT_KW => "a floating-point number of 32 bits.",
        DOUBLE_KW => "a floating-point number of 64 bits.",
        STRING_KW => "a text, `string`, or one of at most so many characters, `string<16>`.",
        S_KW => "seconds.",
        MS_KW => "milliseconds.",
        US_KW => "microseconds.",
        K_KW => "1024 bytes.",
        M_KW => "1048576 bytes.",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use crate::test_support::Fixture;

    #[track_caller]
    fn check(text: &str, word: &str, beginning: &str) {
        let fixture = Fixture::new(text);
        let hover = fixture.analysis().hover(&fixture.at()).unwrap();
        let Some(hover) = hover else {
            return assert_eq!(beginning, "", "nothing is said");
        };
        let source = fixture.text(fixture.at().path.as_str());
        assert_eq!(&source[hover.range], word);
        assert!(hover.info.markdown.starts_with(beginning), "{}", hover.info.markdown);
    }

    #[test]
    fn words_of_the_language_are_explained() {
        check("comp$0onent c { };", "component", "`component`: a program");
        check(
            "component c { task t { codel<start> f() yields$0 ether; }; };",
            "yields",
            "`yields`: the states",
        );
        check(
            "component c { task t { codel<start> f() yield $0pause::start; }; };",
            "pause",
            "`pause`: `pause::x`",
        );
        check("component c { ids$0 { long x; }; };", "ids", "```genom");
        // A name that is spelled like a keyword is a name.
        check("component c { task per$0iod; };", "period", "```genom");
        check("component c { doc \"ta$0sk\"; };", "", "");
        check("// ta$0sk\n", "", "");
    }

    #[test]
    fn places_beyond_the_text_are_no_words() {
        let fixture = Fixture::new("component c { };$0");
        let mut at = fixture.at();
        at.offset += 9;
        assert!(fixture.analysis().hover(&at).unwrap().is_none());
    }
}
