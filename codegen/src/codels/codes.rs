//! What each kind of drift means: the table from which manual pages and help are generated, as
//! [`dotgen_analysis::codes`] has it for everything that the specification alone tells.

use super::drift::DriftCode;

/// A kind of drift as its users know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CodelCode {
    /// The kind; it has the code and the severity.
    pub code: DriftCode,
    /// What is reported, in one line.
    pub meaning: &'static str,
    /// Why it matters.
    pub why: &'static str,
    /// The specification of an example that triggers it, and nothing else.
    pub specification: &'static str,
    /// The codels of the example.
    pub source: &'static str,
    /// What to do.
    pub fix: &'static str,
}

/// All kinds.
pub const CODES: &[CodelCode] = &[
    CodelCode {
        code: DriftCode::MissingDefinition,
        meaning: "a codel whose function no source defines",
        why: "The component does not link, or the dynamic loader refuses it at run time.",
        specification: "component c {\n  function f() { codel c_f(); };\n  function g() { codel c_g(); };\n};\n",
        source: "genom_event c_f(const genom_context self)\n{\n  return genom_ok;\n}\n",
        fix: "Let dotgen write a stub (quick fix, or `dotgen codels stub`), or take the codel out of the \
            specification.",
    },
    CodelCode {
        code: DriftCode::SignatureMismatch,
        meaning: "a codel whose function has another prototype than the specification wants",
        why: "Codels are compiled apart from the code that calls them. Where the generated prototype is not included in \
              the same file, no compiler sees the difference, and the function reads its arguments from the wrong places.",
        specification: "component c {\n  function f(in long n) { codel c_f(local in n); };\n};\n",
        source: "genom_event c_f(double n, const genom_context self)\n{\n  return genom_ok;\n}\n",
        fix: "Update the signature: the quick fix keeps the body and the names that it uses.",
    },
    CodelCode {
        code: DriftCode::UndeclaredYield,
        meaning: "a codel that returns an event its specification does not yield",
        why: "The state machine that the specification shows, checks and computes times from is not the one \
            that runs.",
        specification: "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        source: "genom_event c_start(const genom_context self)\n{\n  if (ready()) return c_run;\n  return c_ether;\n}\ngenom_event c_run(const genom_context self)\n{\n  return c_pause_run;\n}\n",
        fix: "Add the state to the `yield` list, or return one that is in it.",
    },
    CodelCode {
        code: DriftCode::NeverYielded,
        meaning: "a codel that never returns a state its specification yields",
        why: "The state machine that the specification shows, and that timing is computed from, has a transition that \
              does not exist. It does no harm while the code is being written.",
        specification: "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run, ether;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        source: "genom_event c_start(const genom_context self)\n{\n  return c_run;\n}\ngenom_event c_run(const genom_context self)\n{\n  return c_pause_run;\n}\n",
        fix: "Remove the state from the `yield` list, or return it.",
    },
    CodelCode {
        code: DriftCode::UndeclaredThrow,
        meaning: "a codel that raises an exception nobody declares for it",
        why: "Clients are generated from the specification: they do not expect an exception that the service does not \
              `throw`.",
        specification: "component c {\n  exception e_late;\n  function f() { codel c_f(); };\n};\n",
        source: "genom_event c_f(const genom_context self)\n{\n  return c_e_late(self);\n}\n",
        fix: "Add the exception to the `throw` of the service or task, or do not raise it.",
    },
    CodelCode {
        code: DriftCode::Orphan,
        meaning: "a function that looks like a codel and that no specification names",
        why: "It is left over from a codel that is gone, or the codel has another name now.",
        specification: "component c {\n  function f() { codel c_f(); };\n};\n",
        source: "genom_event c_f(const genom_context self)\n{\n  return genom_ok;\n}\n\n/** Codel c_old of function old.\n *\n * Returns genom_ok.\n */\ngenom_event c_old(const genom_context self)\n{\n  return genom_ok;\n}\n",
        fix: "Rename it when a codel of a near name has no function, declare a codel for it, or remove it. A helper is \
              better `static`.",
    },
    CodelCode {
        code: DriftCode::StaleComment,
        meaning: "the generated comment of a codel says something else than its specification",
        why: "\"Triggered by\", \"Yields to\" and \"Throws\" are read by whoever changes the code.",
        specification: "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        source: "/** Codel c_start of task t.\n *\n * Triggered by c_start.\n * Yields to c_ether.\n */\ngenom_event c_start(const genom_context self)\n{\n  return c_run;\n}\ngenom_event c_run(const genom_context self)\n{\n  return c_pause_run;\n}\n",
        fix: "Refresh the comment.",
    },
    CodelCode {
        code: DriftCode::UnknownMember,
        meaning: "code that uses a member which its mapped type does not have",
        why: "It does not compile. The member was renamed in the specification, or taken out of it.",
        specification: "component c {\n  ids { double speed; };\n  function f() { codel c_f(inout ::ids); };\n};\n",
        source: "genom_event c_f(c_ids *ids, const genom_context self)\n{\n  ids->sped = 1.;\n  return genom_ok;\n}\n",
        fix: "Use the name that the specification has now; the quick fix changes it in all sources, where one member \
              can be meant.",
    },
];

/// The entry of a kind.
pub fn entry(code: DriftCode) -> Option<&'static CodelCode> {
    CODES.iter().find(|it| it.code == code)
}
