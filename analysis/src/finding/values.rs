//! Findings about values: constants, default values, union labels, sizes and times.

use std::fmt;

use dotgen_syntax::findings;

use crate::{
    finding::names::Described,
    fixes::{FixSite, TextFix},
    model::Name,
};

/// The purpose of a value.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Purpose {
    /// The constant of this name.
    Constant(Name),
    /// The default value of a parameter.
    Default,
    /// A label of a union.
    Label,
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Purpose::Constant(name) => write!(f, "constant `{name}`"),
            Purpose::Default => f.write_str("default value"),
            Purpose::Label => f.write_str("union label"),
        }
    }
}

/// A number of things, with their noun.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CountedNoun(pub usize, pub &'static str);

impl fmt::Display for CountedNoun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.0 == 1 { "" } else { "s" };
        write!(f, "{} {}{plural}", self.0, self.1)
    }
}

findings! {
    /// An invalid value, or one that does not fit its place.
    pub enum ValueProblem {
        "octal-digit" OctalDigit { text: Name, value: i128 }
            => "`{text}` starts with 0, so it is read as octal, and ends at the first 8 or 9: its \
                value is {value}";
        "const-range" TooLong { text: Name } => "`{text}` does not fit in 64 bits";
        "const-range" Overflow { op: &'static str } => "the result of `{op}` is too large for any type";
        "const-range" StackTooLarge => "this stack size does not fit in 64 bits";
        "const-range" OutOfRange { of: Purpose, number: i128, ty: Name }
            => "{of}: {number} is out of the range of type `{ty}`";
        "fixed-unsupported" FixedLiteral
            => "fixed point numbers are not supported", "leave out the suffix `d`";
        "fixed-unsupported" FixedType => "fixed point numbers are not supported", "use `double`";
        "const-convert" NotACharacter { text: Name }
            => "{text} is no character: there is room for one, or one escape",
               "texts are written in double quotes";
        "const-convert" OtherEnum { of: Purpose, name: Name, ty: Name }
            => "{of}: `{name}` is an enumerator of another type than `{ty}`";
        "const-convert" OtherKind { of: Purpose, value: Name, ty: Name }
            => "{of}: {value} is no value of type `{ty}`";
        "const-type" NoConstants { of: Purpose, ty: Name }
            => "{of}: `{ty}` cannot hold a constant",
               "only numbers, booleans, characters, strings and enums can";
        "const-operand" HasNoValue { path: Name, what: Described }
            => "`{path}` is {what}", "only constants and enumerators have a value";
        "const-unary" Unary { op: &'static str, value: &'static str }
            => "`{op}` does not apply to {value}";
        "const-binary" Binary { op: &'static str, left: &'static str, right: &'static str }
            => "`{op}` does not apply to {left} and {right}";
        "const-div-zero" DivisionByZero { op: &'static str }
            => "the right side of `{op}` is zero", "integers cannot be divided by it";
        "const-positive" NotNatural { what: &'static str, value: &'static str }
            => "the {what} must be a non-negative integer, but this is {value}";
        "const-numeric" NotANumber { word: Name, value: &'static str }
            => "a `{word}` is a number, but this is {value}";
        "string-too-long" StringTooLong { length: usize, bound: u64 }
            => "this string has {length} characters, but its type holds {bound}";
        "size-too-large" TooLarge { what: &'static str, size: u64 }
            => "the {what} is {size}: `genom3` refuses more than 2147483647";
        "zero-size" Zero { what: &'static str } => "the {what} is 0: it holds nothing";

        "init-scalar-compound" NoDefault { ty: Name }
            => "`{ty}` cannot have a default value", "leave it out";
        "init-scalar-compound" NeedsBraces { ty: Name }
            => "`{ty}` has several parts", "write its default value in braces, `{{ … }}`";
        "init-compound-scalar" NeedsNoBraces { ty: Name }
            => "`{ty}` has a single value", "write it without braces";
        "init-array-member" ElementByName { name: Name }
            => "an array or sequence has no member `{name}`", "select an element with `[n] =`";
        "init-bounds" NoElement { position: u64, length: u64 }
            => "there is no element {position}", "the length is {length}";
        "init-member" NoMember { ty: Name, name: Name } => "`{ty}` has no member `{name}`";
        "init-struct-index" MemberByIndex { ty: Name }
            => "`{ty}` has members, not elements", "select one with `.name =`";
        "init-too-many" TooMany { ty: Name, members: CountedNoun }
            => "`{ty}` has {members}, there is none left for this value";

        "union-member-switch-clash" MemberIsSwitch { name: Name }
            => "member `{name}` has the name of the switch type", "rename it";
        "union-switch-type" BadSwitch { name: Name, ty: Name }
            => "union `{name}` cannot switch on `{ty}`",
               "only integers other than octet, char, boolean and enums can select a member";
        "union-repeated-label" LabelTwice
            => "this label already stands in front of the same member", "remove it";
        "union-duplicate-label" LabelTaken { name: Name }
            => "a label of this member already selects `{name}`",
               "every value can select one member only";

        "clock-rate-value" Negative { word: Name } => "a `{word}` cannot be negative";
        "clock-rate-multiple" NoMultiple { word: &'static str, task: Name, time: Name, rate: Name }
            => "the {word} of task `{task}`, {time} s, is no multiple of the clock-rate, {rate} s";
        "glued-unit" GluedUnit
            => "without a blank, the generator reads `u` as part of the number and `s` as the unit: \
                this is a number of seconds",
               "insert a blank for microseconds";
        "priority-range" PriorityRange { value: u64 }
            => "priority {value} is above 255, the highest that is documented";
        "period-zero" PeriodZero
            => "a period of 0 never lets the task rest", "leave it out for a task that runs on events";
        "delay-without-period" DelayWithoutPeriod { task: Name }
            => "task `{task}` has a delay but no period", "only periodic tasks can be delayed";
        "delay-range" DelayRange => "the delay must be less than the period";

        "wcet-value" WcetTwice => "a codel has one worst-case execution time", "remove one of them";
        "wcet-value" WcetEmpty => "`wcet` needs a duration, for instance `wcet 2 ms`";
        "wcet-value" WcetNoNumber { value: &'static str }
            => "an execution time is a number with a unit, but this is {value}";
        "wcet-value" WcetNegative => "an execution time cannot be negative";
        "wcet-bare" WcetBare
            => "a duration after the states is taken for the worst-case execution time",
               "write `wcet` before it";
        "wcet-pragma" PragmaForm
            => "write `#pragma wcet CODEL DURATION UNIT`, for instance `#pragma wcet compute 2 ms`";
        "wcet-pragma" PragmaUnit => "the execution time needs a unit: `s`, `ms` or `us`";
        "wcet-pragma" PragmaNoNumber { value: &'static str }
            => "an execution time is a number with a unit, but this is {value}";
        "wcet-pragma" PragmaNegative => "an execution time cannot be negative";
        "wcet-pragma" PragmaTwice { codel: Name }
            => "codel `{codel}` is given an execution time twice", "keep one of them";
        "wcet-pragma" PragmaUnknown { codel: Name } => "there is no codel `{codel}`";
        "wcet-pragma" PragmaAndClause { codel: Name }
            => "codel `{codel}` has a `wcet` in its declaration", "keep one of them";
    }
}

impl ValueProblem {
    /// The fixes, the best first, made from the text around.
    pub(crate) fn fixes(&self, here: &FixSite<'_>) -> Vec<TextFix> {
        match self {
            ValueProblem::GluedUnit => here.part_unit().into_iter().collect(),
            ValueProblem::WcetBare => vec![here.add_wcet_word()],
            _ => Vec::new(),
        }
    }
}
