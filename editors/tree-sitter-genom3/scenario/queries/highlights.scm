; Highlights of verification scenarios. No two patterns match one node: the order of patterns does not matter.

(comment) @comment
(string) @string.special.path
(number) @number
(real) @number
(unit) @keyword.modifier
(choice_word) @constant.builtin
["{" "}" "[" "]" "(" ")"] @punctuation.bracket
[";" "," "." ":"] @punctuation.delimiter
["=>" "->" "<" "<=" ">" ">=" "==" "!="] @operator
"*" @constant.builtin

["scenario" "client"] @keyword.type
(measure "on" @keyword.type)
["use" "times" "weights"] @keyword.import
[
  "unit" "cores" "affinity" "duration" "loop" "connect" "slots" "semantics" "policy" "durations" "ticks" "turns" "locks"
  "ports" "order" "async" "aperiodic" "exceptions" "idle" "check"
] @keyword
(setting key: "pause" @keyword)
["send" "await" "delay" "abort" "kill"] @keyword.coroutine
(stop "stop" @keyword.coroutine)
"repeat" @keyword.repeat
"choice" @keyword.conditional
(choice "or" @keyword.conditional)
(or "or" @keyword.operator)
["and" "not" "leave" "then" "via" "to" "late" "lost" "stale" "violation" "of" "for" "in" "until"] @keyword.operator
(claim) @keyword.operator
(measure "after" @keyword.operator)
(check kind: "absent" "after" @keyword.operator)
[
  "schedulable" "no-overdue" "response" "within" "reaction" "age" "leadsto" "eventually" "always" "never" "reachable" "deadlock"
  "absent" "lasts" "precedes" "before" "between"
] @function.builtin
(check kind: "after" @function.builtin)

(scenario name: (identifier) @type)
(client name: (identifier) @function)
(label) @label
(path . (identifier) @module)
(path (identifier) (identifier) @variable.member)
(comparison right: (identifier) @constant)
