// The tree-sitter grammar of GenoM3 specifications (`.gen` and `.idl`).
//
// The grammar reads text before preprocessing. Directives are extras: they may stand between any two tokens.
// Keywords are contextual, as in the language: the parser takes a word as a keyword only where the keyword fits.
// The grammar accepts a few texts that the compiler refuses, such as an empty struct: an include may fill it.

const PREC = { or: 1, xor: 2, and: 3, shift: 4, add: 5, multiply: 6, unary: 7 };

const comma = (rule) => seq(rule, repeat(seq(',', rule)));
const both = (singular) => choice(singular + 's', singular);
// Digraphs are shown as the character they stand for.
const open = choice('{', alias('<%', '{'));
const close = choice('}', alias('%>', '}'));
const openBracket = choice('[', alias('<:', '['));
const closeBracket = choice(']', alias(':>', ']'));
const braces = (...rules) => seq(open, ...rules, close);
const brackets = (...rules) => seq(openBracket, ...rules, closeBracket);
const directive = (word) => token(new RegExp('(#|%:)[ \\t]*' + word));

module.exports = grammar({
  name: 'genom3',

  word: ($) => $.identifier,

  externals: ($) => [
    $.preproc_text, // the rest of a directive's line, up to a comment
    $._zero, // the condition `0`
    $._parameters_begin, // a parenthesis glued to the name of a macro
    $._line_end,
    $.inactive, // the text of a group under `#if 0`
    $.macro_arguments, // `( … )` with balanced parentheses
    $._error_sentinel,
  ],

  extras: ($) => [
    /[\s\uFEFF]/,
    /\\\r?\n/,
    $.comment,
    $.pragma_operator,
    $.preproc_include,
    $.preproc_define,
    $.preproc_undef,
    $.preproc_ifdef,
    $.preproc_if,
    $.preproc_elif,
    $.preproc_else,
    $.preproc_endif,
    $.preproc_message,
    $.preproc_pragma,
    $.preproc_other,
  ],

  // `DECLARE(a) b c;` in a struct: a macro and a member, or a member whose type is a macro.
  conflicts: ($) => [[$._type, $.macro_statement]],

  rules: {
    source_file: ($) => repeat(choice($.component, $.interface, $._component_item)),

    // ---- Preprocessor ---------------------------------------------------------------------------------------------

    preproc_include: ($) =>
      seq(
        alias(directive('include'), '#include'),
        field('path', choice($.string, $.system_path, $.identifier)),
        optional($.preproc_text),
        $._line_end,
      ),
    system_path: () => token(prec(1, /<[^>\n]*>/)),
    preproc_define: ($) =>
      seq(
        alias(directive('define'), '#define'),
        field('name', $.identifier),
        optional(field('parameters', $.preproc_parameters)),
        optional(field('value', $._preproc_value)),
        $._line_end,
      ),
    preproc_parameters: ($) =>
      seq(
        alias($._parameters_begin, '('),
        optional(comma(choice(field('name', $.identifier), '...'))),
        ')',
      ),
    _preproc_value: ($) => repeat1($.preproc_text),
    preproc_undef: ($) => seq(alias(directive('undef'), '#undef'), field('name', $.identifier), repeat($.preproc_text), $._line_end),
    preproc_ifdef: ($) =>
      seq(
        choice(alias(directive('ifdef'), '#ifdef'), alias(directive('ifndef'), '#ifndef')),
        field('name', $.identifier),
        repeat($.preproc_text),
        $._line_end,
      ),
    preproc_if: ($) =>
      seq(
        alias(directive('if'), '#if'),
        choice(
          seq(field('condition', $._preproc_value), $._line_end),
          seq(field('condition', alias($._zero, $.preproc_text)), $._line_end, $.inactive),
        ),
      ),
    preproc_elif: ($) =>
      seq(
        alias(directive('elif'), '#elif'),
        choice(
          seq(field('condition', $._preproc_value), $._line_end),
          seq(field('condition', alias($._zero, $.preproc_text)), $._line_end, $.inactive),
        ),
      ),
    preproc_else: ($) => seq(alias(directive('else'), '#else'), repeat($.preproc_text), $._line_end),
    preproc_endif: ($) => seq(alias(directive('endif'), '#endif'), repeat($.preproc_text), $._line_end),
    preproc_message: ($) =>
      seq(
        choice(alias(directive('error'), '#error'), alias(directive('warning'), '#warning')),
        repeat($.preproc_text),
        $._line_end,
      ),
    preproc_pragma: ($) =>
      seq(
        alias(directive('pragma'), '#pragma'),
        field('name', choice($.identifier, $.string)),
        repeat(field('argument', $.preproc_text)),
        $._line_end,
      ),
    // The preprocessor drops the lines of unknown directives.
    preproc_other: ($) => seq(alias(directive('[A-Za-z_0-9]*'), $.directive), repeat($.preproc_text), $._line_end),

    pragma_operator: () => token(/_Pragma\s*\(\s*"([^"\\]|\\[\s\S])*"\s*\)/),

    macro_call: ($) => seq(field('name', $.identifier), field('arguments', $.macro_arguments)),
    // A macro that stands for declarations or properties.
    macro_statement: ($) => prec.right(seq($.macro_call, optional(';'))),
    _macro_name_statement: ($) => prec.right(seq(field('name', $.identifier), optional(';'))),

    // ---- Components -----------------------------------------------------------------------------------------------

    component: ($) => seq('component', field('name', $.identifier), optional(field('body', $.component_body)), ';'),
    interface: ($) => seq('interface', field('name', $.identifier), optional(field('body', $.component_body)), ';'),
    component_body: ($) => braces(repeat($._component_item)),

    _component_item: ($) =>
      choice(
        $._declaration,
        $._property,
        $.ids,
        $.task,
        $.port,
        $.attribute,
        $.function,
        $.activity,
      ),

    ids: ($) => seq('ids', field('body', $.member_list), ';'),
    task: ($) => seq('task', field('name', $.identifier), optional(field('body', $.property_list)), ';'),
    port: ($) =>
      seq(
        'port',
        optional('multiple'),
        field('direction', choice('in', 'out')),
        field('type', $._type),
        field('name', $.identifier),
        optional(field('body', $.property_list)),
        ';',
      ),
    attribute: ($) =>
      seq(
        'attribute',
        field('name', $.identifier),
        field('parameters', $.attribute_parameters),
        optional(field('body', $.property_list)),
        ';',
      ),
    function: ($) =>
      seq(
        'function',
        field('name', $.identifier),
        field('parameters', $.parameters),
        optional(field('body', $.property_list)),
        ';',
      ),
    activity: ($) =>
      seq(
        'activity',
        field('name', $.identifier),
        field('parameters', $.parameters),
        optional(field('body', $.property_list)),
        ';',
      ),

    attribute_parameters: ($) => seq('(', optional(comma($.attribute_parameter)), ')'),
    attribute_parameter: ($) => seq($._access, optional($._default_value)),
    parameters: ($) => seq('(', optional(comma($.parameter)), ')'),
    parameter: ($) =>
      seq(field('direction', $.direction), field('type', $._type), $._declarator, optional($._default_value)),
    direction: () => choice('in', 'out', 'inout'),

    // The ids member or other data that a parameter refers to, and the name that the parameter gives to the data.
    _access: ($) =>
      seq(
        field('direction', $.direction),
        choice(seq(field('path', $.path), optional($._rename)), $._rename),
      ),
    _rename: ($) => seq('::', field('alias', $.identifier)),
    path: ($) => seq(field('name', $.identifier), repeat(choice($.member_access, $.index))),
    member_access: ($) => seq('.', field('member', $.identifier)),
    index: ($) => brackets($._expression),

    // ---- Properties -----------------------------------------------------------------------------------------------

    property_list: ($) => braces(repeat(choice($._property, $.task_property, $._macro_item))),

    _property: ($) =>
      choice(
        $.text_property,
        $.requires_property,
        $.duration_property,
        $.interfaces_property,
        $.throws_property,
        $.priority_property,
        $.scheduling_property,
        $.stack_property,
        $.services_property,
        $.validate_property,
        $.local_property,
        $.codel_property,
      ),

    text_property: ($) =>
      seq(field('key', choice('doc', 'version', 'lang', 'email')), field('value', $.text), ';'),
    requires_property: ($) =>
      seq(field('key', choice(both('require'), both('codels-require'))), comma(field('value', $.text)), ';'),
    duration_property: ($) =>
      seq(field('key', choice('clock-rate', 'period', 'delay')), field('value', $._duration), ';'),
    interfaces_property: ($) =>
      seq(
        field('key', choice(both('provide'), both('use'), both('extend'))),
        comma(field('interface', $.identifier)),
        ';',
      ),
    throws_property: ($) => seq(field('key', both('throw')), comma(field('exception', $.scoped_name)), ';'),
    priority_property: ($) => seq(field('key', 'priority'), field('value', $._expression), ';'),
    scheduling_property: ($) => seq(field('key', 'scheduling'), field('value', 'real-time'), ';'),
    stack_property: ($) =>
      seq(field('key', 'stack'), field('value', $._expression), optional(field('unit', alias(choice('k', 'M'), $.unit))), ';'),
    task_property: ($) => seq(field('key', 'task'), field('task', $.identifier), ';'),
    services_property: ($) =>
      seq(
        field('key', choice(both('interrupt'), 'before', 'after')),
        comma(field('service', $.identifier)),
        ';',
      ),
    validate_property: ($) => seq('validate', $._simple_codel, ';'),
    local_property: ($) => seq('local', field('type', $._type), comma($._declarator), ';'),
    codel_property: ($) => seq(optional('async'), 'codel', choice($._simple_codel, $._state_codel), ';'),

    // Adjacent strings are one text.
    text: ($) => repeat1(choice($.string, $.identifier, $.macro_call)),

    _duration: ($) => seq($._expression, optional(field('unit', alias(choice('s', 'ms', 'us'), $.unit)))),

    // ---- Codels ---------------------------------------------------------------------------------------------------

    _simple_codel: ($) =>
      seq(field('name', $.identifier), field('parameters', $.codel_parameters), optional($.wcet)),
    _state_codel: ($) =>
      seq(
        field('triggers', $.triggers),
        field('name', $.identifier),
        field('parameters', $.codel_parameters),
        optional($.wcet),
        field('yields', $.yields),
        optional(choice($.wcet, alias($._bare_wcet, $.wcet))),
      ),
    triggers: ($) => seq('<', comma($.state), '>'),
    yields: ($) => seq(both('yield'), comma($.state)),
    state: ($) =>
      choice(seq('pause', '::', field('name', $.identifier)), field('name', choice($.identifier, alias('pause', $.identifier)))),
    wcet: ($) => seq('wcet', field('value', $._duration)),
    _bare_wcet: ($) =>
      field('value', choice($.glued_duration, seq($.number, field('unit', alias(choice('s', 'ms', 'us'), $.unit))))),

    codel_parameters: ($) => seq('(', optional(comma($.codel_parameter)), ')'),
    codel_parameter: ($) => seq(optional(field('source', $.source)), $._access),
    source: () => choice('ids', 'local', 'port', 'remote'),

    // ---- Constants and types --------------------------------------------------------------------------------------

    _declaration: ($) =>
      choice(
        $.module,
        $.constant,
        $.typedef,
        $.native,
        $.exceptions,
        $.type_declaration,
        $.forward_declaration,
        $._macro_item,
      ),
    _macro_item: ($) => choice($.macro_statement, alias($._macro_name_statement, $.macro_statement)),

    module: ($) => seq('module', field('name', $.identifier), field('body', $.module_body), ';'),
    module_body: ($) => braces(repeat($._declaration)),

    constant: ($) =>
      seq('const', field('type', $._type), field('name', $.identifier), '=', field('value', $._expression), ';'),
    typedef: ($) => seq('typedef', field('type', $._type), comma($._declarator), ';'),
    native: ($) => seq('native', field('name', $.identifier), ';'),
    exceptions: ($) => seq('exception', comma($.exception), ';'),
    exception: ($) => seq(field('name', $.identifier), optional(field('body', $.member_list))),
    type_declaration: ($) => seq(choice($.struct, $.union, $.enum), ';'),
    forward_declaration: ($) => seq(choice('struct', 'union'), field('name', $.identifier), ';'),

    struct: ($) => seq('struct', field('name', $.identifier), field('body', $.member_list)),
    member_list: ($) => braces(repeat(choice($.member, $.macro_statement))),
    member: ($) => seq(field('type', $._type), comma($._declarator), ';'),

    union: ($) =>
      seq('union', field('name', $.identifier), 'switch', '(', field('switch', $._type), ')', field('body', $.case_list)),
    case_list: ($) => braces(repeat(choice($.case, $.macro_statement))),
    case: ($) => seq(repeat1($.label), field('type', $._type), $._declarator, ';'),
    label: ($) => choice(seq('case', field('value', $._expression), ':'), seq('default', ':')),

    enum: ($) => seq('enum', field('name', $.identifier), field('body', $.enumerator_list)),
    enumerator_list: ($) => braces(optional(comma(choice($.enumerator, $.macro_call)))),
    enumerator: ($) => field('name', $.identifier),

    _declarator: ($) => field('declarator', $.declarator),
    declarator: ($) => seq(field('name', $.identifier), repeat(field('size', $.index))),

    _type: ($) =>
      choice($.primitive_type, $.string_type, $.sequence_type, $.optional_type, $.named_type, $.macro_call, $.struct, $.union, $.enum),
    primitive_type: () =>
      choice(
        'boolean',
        'octet',
        'char',
        'any',
        'float',
        'double',
        seq(optional('unsigned'), choice('short', 'long', seq('long', 'long'))),
      ),
    string_type: ($) => seq('string', optional(seq('<', field('bound', $._expression), '>'))),
    sequence_type: ($) =>
      seq('sequence', '<', field('element', $._type), optional(seq(',', field('bound', $._expression))), '>'),
    optional_type: ($) => seq('optional', '<', field('element', $._type), '>'),
    named_type: ($) => $.scoped_name,
    scoped_name: ($) => seq(optional('::'), repeat(seq(field('scope', $.identifier), '::')), field('name', $.identifier)),

    // ---- Expressions and default values ---------------------------------------------------------------------------

    _expression: ($) =>
      choice(
        $.number,
        $.glued_duration,
        $.boolean,
        $.character,
        $.concatenation,
        $.scoped_name,
        $.macro_call,
        $.parentheses,
        $.unary,
        $.binary,
      ),
    parentheses: ($) => seq('(', $._expression, ')'),
    unary: ($) =>
      prec(PREC.unary, seq(field('operator', choice('-', '+', '~', 'compl')), field('operand', $._expression))),
    binary: ($) =>
      choice(
        ...[
          [PREC.or, choice('|', 'bitor')],
          [PREC.xor, choice('^', 'xor')],
          [PREC.and, choice('&', 'bitand')],
          [PREC.shift, choice('<<', '>>')],
          [PREC.add, choice('+', '-')],
          [PREC.multiply, choice('*', '/', '%')],
        ].map(([level, operator]) =>
          prec.left(
            level,
            seq(field('left', $._expression), field('operator', operator), field('right', $._expression)),
          ),
        ),
      ),
    concatenation: ($) => prec.right(repeat1($.string)),

    _default_value: ($) => seq('=', field('default', $.initializer)),
    initializer: ($) =>
      choice(
        seq(
          choice(
            field('value', $._value),
            seq(field('designator', choice($.member_access, $.index)), '=', optional(field('value', $._value))),
          ),
          optional($._documentation),
        ),
        $._documentation,
      ),
    _value: ($) => choice($._expression, $.initializer_list),
    initializer_list: ($) => braces(optional(comma($.initializer))),
    _documentation: ($) => seq(':', field('documentation', $.text)),

    // ---- Tokens ---------------------------------------------------------------------------------------------------

    // A backslash at the end of a line joins the word with the next line.
    identifier: () => /[A-Za-z_][A-Za-z0-9_]*(\\\r?\n[A-Za-z0-9_]+)*|clock-rate|real-time|codels-requires?/,
    boolean: () => choice('TRUE', 'FALSE'),
    number: () =>
      token(
        choice(
          /([0-9]+|0[xX][0-9A-Fa-f]+)([uU][lL]?|[lL][uU]?)?/,
          /(([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)[fFlL]?/,
        ),
      ),
    // `26us` in a `wcet`. A period would read the number `26u`, in seconds.
    glued_duration: () => /[0-9]+us/,
    string: () => token(/"([^"\\]|\\[\s\S])*"/),
    character: () => token(/'([^'\\\n]|\\[^\n])*'/),
    comment: () => token(choice(/\/\/([^\\\n]|\\[^\n]|\\\r?\n)*/, /\/\*[^*]*\*+([^/*][^*]*\*+)*\//)),
  },
});
