; Highlights of GenoM3 specifications. No two patterns match one node: the order of patterns does not matter.

; ---- Tokens

(comment) @comment
(string) @string
(character) @character
(number) @number
(glued_duration) @number
(boolean) @boolean
(unit) @keyword.modifier
(primitive_type) @type.builtin
["sequence" "optional" "string"] @type.builtin
["{" "}" "[" "]" "(" ")" "<" ">"] @punctuation.bracket
[";" "," "::" "." ":"] @punctuation.delimiter
["=" "|" "^" "&" "<<" ">>" "+" "-" "*" "/" "%" "~" "..."] @operator
["bitor" "xor" "bitand" "compl"] @keyword.operator

; ---- Keywords

["component" "interface" "module" "struct" "union" "enum" "exception" "typedef" "native"] @keyword.type
(ids "ids" @keyword.type)
(task "task" @keyword.type)
(port "port" @keyword.type)
(task_property "task" @keyword)
["attribute" "function" "activity" "codel" "validate"] @keyword.function
["const" "async" "multiple"] @keyword.modifier
(local_property "local" @keyword.modifier)
["switch" "case" "default"] @keyword.conditional
["yield" "yields" "pause"] @keyword.return
["throw" "throws"] @keyword.exception
["provide" "provides" "use" "uses" "extend" "extends"] @keyword.import
[
  "doc" "version" "lang" "email" "require" "requires" "codels-require" "codels-requires" "clock-rate" "period" "delay"
  "priority" "scheduling" "stack" "interrupt" "interrupts" "before" "after" "wcet"
] @keyword
"real-time" @constant.builtin
(direction) @keyword.modifier
(port direction: _ @keyword.modifier)
(source) @keyword.modifier

; ---- Preprocessor

["#include" "#define" "#undef" "#ifdef" "#ifndef" "#if" "#elif" "#else" "#endif" "#error" "#warning" "#pragma"] @keyword.directive
(directive) @keyword.directive
(pragma_operator) @keyword.directive
(system_path) @string.special.path
(preproc_include path: (identifier) @constant.macro)
(preproc_define name: (identifier) @constant.macro)
(preproc_parameters name: (identifier) @variable.parameter)
(preproc_undef name: (identifier) @constant.macro)
(preproc_ifdef name: (identifier) @constant.macro)
(preproc_pragma name: (identifier) @keyword)
(preproc_pragma argument: (preproc_text) @string.special)
(preproc_message (preproc_text) @string)
(inactive) @comment
(macro_call name: (identifier) @function.macro)
(macro_statement name: (identifier) @function.macro)
(text (identifier) @constant.macro)

; ---- Declared names

(component name: (identifier) @type)
(interface name: (identifier) @type)
(module name: (identifier) @module)
(task name: (identifier) @type)
(port name: (identifier) @variable)
(attribute name: (identifier) @function)
(function name: (identifier) @function)
(activity name: (identifier) @function)
(codel_property name: (identifier) @function.call)
(validate_property name: (identifier) @function.call)
(constant name: (identifier) @constant)
(typedef declarator: (declarator name: (identifier) @type.definition))
(native name: (identifier) @type.definition)
(exception name: (identifier) @type)
(struct name: (identifier) @type)
(union name: (identifier) @type)
(enum name: (identifier) @type)
(forward_declaration name: (identifier) @type)
(enumerator name: (identifier) @constant)
(member declarator: (declarator name: (identifier) @variable.member))
(case declarator: (declarator name: (identifier) @variable.member))
(parameter declarator: (declarator name: (identifier) @variable.parameter))
(local_property declarator: (declarator name: (identifier) @variable))

; ---- References

(scoped_name scope: (identifier) @module)
(named_type (scoped_name name: (identifier) @type))
(throws_property exception: (scoped_name name: (identifier) @type))
(binary (scoped_name name: (identifier) @constant))
(unary (scoped_name name: (identifier) @constant))
(parentheses (scoped_name name: (identifier) @constant))
(constant value: (scoped_name name: (identifier) @constant))
(index (scoped_name name: (identifier) @constant))
(label value: (scoped_name name: (identifier) @constant))
(string_type bound: (scoped_name name: (identifier) @constant))
(sequence_type bound: (scoped_name name: (identifier) @constant))
(duration_property value: (scoped_name name: (identifier) @constant))
(priority_property value: (scoped_name name: (identifier) @constant))
(stack_property value: (scoped_name name: (identifier) @constant))
(wcet value: (scoped_name name: (identifier) @constant))
(initializer value: (scoped_name name: (identifier) @constant))
(path name: (identifier) @variable.parameter)
(member_access member: (identifier) @variable.member)
(attribute_parameter alias: (identifier) @variable.parameter)
(codel_parameter alias: (identifier) @variable.parameter)
(interfaces_property interface: (identifier) @type)
(services_property service: (identifier) @function)
(task_property task: (identifier) @type)
((state name: (identifier) @constant.builtin) (#match? @constant.builtin "^(start|stop|ether)$"))
((state name: (identifier) @label) (#not-match? @label "^(start|stop|ether)$"))
