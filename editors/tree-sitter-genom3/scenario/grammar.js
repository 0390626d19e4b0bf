// The tree-sitter grammar of dotgen's verification scenarios (`.scn`).
//
// Keywords are contextual, as in the language: the parser takes a word as a keyword only where the keyword fits.

const comma = (rule) => seq(rule, repeat(seq(',', rule)));
/** `KEYWORD WORD;`, where the word is one of a few. */
const CHOICES = {
  semantics: ['servers', 'published'],
  policy: ['priority', 'fair', 'fifo', 'edf', 'any'],
  durations: ['interval', 'fixed', 'open'],
  ticks: ['component', 'task'],
  turns: ['codel', 'pause'],
  locks: ['queue', 'free', 'fifo'],
  ports: ['copy', 'lock'],
  pause: ['events', 'turns'],
  order: ['on', 'off'],
  async: ['held', 'free'],
  aperiodic: ['core', 'free'],
};
const CHECKS = [
  'schedulable',
  'no-overdue',
  'response',
  'within',
  'reaction',
  'age',
  'leadsto',
  'eventually',
  'always',
  'never',
  'reachable',
  'deadlock',
  'absent',
  'lasts',
  'before',
  'after',
  'between',
];
const STEPS = ['send', 'await', 'delay', 'repeat', 'choice', 'abort', 'kill', 'connect', 'stop'];

module.exports = grammar({
  name: 'genom3_scenario',

  word: ($) => $.identifier,
  // `tank.level <= 5 and` compares, `tank.keep <= 5 ms` limits a time.
  conflicts: ($) => [[$._factor, $.comparison]],

  extras: ($) => [/[ \t\r\n\f\uFEFF]/, $.comment],

  rules: {
    source_file: ($) => optional($.scenario),

    scenario: ($) => seq('scenario', field('name', $.identifier), field('body', $.scenario_body)),
    scenario_body: ($) => seq('{', repeat(choice($._item, ';')), '}'),

    // ---- Items ----------------------------------------------------------------------------------------------------

    _item: ($) =>
      choice(
        $.use,
        $.times_file,
        $.weights_file,
        $.unit_setting,
        $.cores,
        $.affinity,
        $.setting,
        $.duration,
        $.loop,
        $.connection,
        $.slots,
        $.client,
        $.measure,
        $.check,
      ),

    use: ($) => seq('use', field('file', $.string), ';'),
    times_file: ($) => seq('times', field('file', $.string), ';'),
    weights_file: ($) => seq('weights', field('file', $.string), ';'),
    unit_setting: ($) => seq('unit', field('value', $.number), field('unit', $.unit), ';'),
    cores: ($) => seq('cores', field('count', choice($.number, alias('free', $.choice_word))), ';'),
    affinity: ($) => seq('affinity', field('task', $.path), field('core', $.number), ';'),
    setting: ($) =>
      choice(
        ...Object.entries(CHOICES).map(([key, words]) =>
          seq(field('key', key), field('value', alias(choice(...words), $.choice_word)), ';'),
        ),
        seq(field('key', 'exceptions'), field('value', alias(choice('on', 'off'), $.choice_word)), optional(field('of', $.path)), ';'),
        seq(field('key', 'idle'), field('value', alias(choice('drop', 'keep'), $.choice_word)), optional(field('of', $.path)), ';'),
      ),
    duration: ($) => seq('duration', field('codel', $.path), field('value', $._times), field('unit', $.unit), ';'),
    loop: ($) =>
      seq(
        'loop',
        field('limit', choice($.number, alias(choice('free', 'once'), $.choice_word))),
        optional(field('of', $.path)),
        ';',
      ),
    connection: ($) =>
      seq('connect', field('input', $.path), 'to', field('output', choice(alias('none', $.choice_word), $.path)), ';'),
    slots: ($) => seq('slots', field('of', $.path), field('count', $.number), ';'),

    // ---- Clients --------------------------------------------------------------------------------------------------

    client: ($) => seq('client', field('name', $.identifier), field('body', $.steps)),
    measure: ($) =>
      seq(
        'on',
        optional(seq(field('name', alias($._check_name, $.label)), ':')),
        field('event', choice('late', 'lost', 'stale', seq('violation', 'of'))),
        comma(field('of', $.path)),
        optional(seq('after', field('age', $.number), field('unit', $.unit))),
        optional($.bound),
        field('body', $.steps),
      ),
    steps: ($) => seq('{', repeat(choice($._step, ';')), '}'),
    _step: ($) => choice($.send, $.await, $.delay, $.repeat, $.choice, $.abort, $.kill, $.connect, $.stop),

    _label: ($) => seq(field('label', $.label), ':'),
    label: ($) => choice($.identifier, ...STEPS.map((word) => alias(word, $.identifier))),
    send: ($) => seq(optional($._label), 'send', field('service', $.path), ';'),
    await: ($) =>
      seq(
        optional($._label),
        'await',
        choice(
          seq(field('event', alias('accepted', $.choice_word)), optional(field('service', $.path))),
          seq(
            field('event', alias('ended', $.choice_word)),
            optional(field('ending', alias(choice('ok', 'failed'), $.choice_word))),
            optional(field('service', $.path)),
          ),
          // A component may be called `ok` or `failed`.
          seq(field('event', alias('ended', $.choice_word)), field('service', alias($._path_of_ending, $.path))),
        ),
        ';',
      ),
    delay: ($) => seq(optional($._label), 'delay', field('value', $._times), field('unit', $.unit), ';'),
    repeat: ($) => seq(optional($._label), 'repeat', field('count', choice($.number, '*')), field('body', $.steps)),
    choice: ($) =>
      prec.right(
        seq(optional($._label), 'choice', field('branch', $.steps), repeat(seq('or', field('branch', $.steps)))),
      ),
    abort: ($) => seq(optional($._label), 'abort', field('target', $.path), ';'),
    kill: ($) => seq(optional($._label), 'kill', field('component', $.path), ';'),
    stop: ($) => seq(optional($._label), 'stop', ';'),
    connect: ($) => seq(optional($._label), 'connect', field('component', $.path), ';'),

    // ---- Checks ---------------------------------------------------------------------------------------------------

    check: ($) =>
      seq(
        'check',
        optional(seq(field('name', alias($._check_name, $.label)), ':')),
        choice(
          seq(field('kind', choice('schedulable', 'no-overdue')), field('of', choice($.path, '*'))),
          seq(field('kind', 'response'), field('of', choice($.path, '*')), optional($.bound)),
          seq(
            field('kind', 'within'),
            field('trigger', $._predicate),
            '=>',
            field('response', $._predicate),
            choice(
              seq(repeat(seq('then', field('response', $._predicate))), optional($.bound)),
              seq('in', field('value', $._times), field('unit', $.unit)),
            ),
          ),
          seq(
            field('kind', choice('reaction', 'age')),
            field('from', $.path),
            '->',
            field('to', $.path),
            optional(seq('via', comma(field('via', $.path)))),
            optional($.bound),
          ),
          seq(field('kind', 'leadsto'), field('trigger', $._predicate), '=>', field('response', $._predicate)),
          seq(field('kind', choice('eventually', 'always', 'never', 'reachable')), field('predicate', $._formula)),
          field('kind', 'deadlock'),
          seq(field('kind', 'absent'), field('predicate', $._predicate), 'after', field('trigger', $._predicate), 'for', $._time),
          seq(field('kind', 'lasts'), field('predicate', $._predicate), choice($.bound, seq('>=', $._time))),
          seq(field('trigger', $._predicate), field('kind', 'precedes'), field('predicate', $._predicate)),
          seq(field('kind', 'before'), field('end', $._predicate), $._claim),
          seq(field('kind', 'after'), field('trigger', $._predicate), optional(seq('until', field('end', $._predicate))), $._claim),
          seq(field('kind', 'between'), field('trigger', $._factor), 'and', field('end', $._factor), $._claim),
        ),
        ';',
      ),
    _check_name: ($) => choice($.identifier, ...CHECKS.map((word) => alias(word, $.identifier))),
    bound: ($) => seq('<=', $._time),
    _time: ($) => seq(field('value', $.number), field('unit', $.unit)),
    _claim: ($) =>
      seq(field('claim', alias(choice('never', 'always', 'eventually'), $.claim)), field('predicate', $._formula)),

    _formula: ($) => choice($._predicate, $.implies),
    implies: ($) => seq(field('left', $._predicate), '=>', field('right', $._formula)),
    _predicate: ($) => choice($.or, $.and, $._factor),
    _factor: ($) => choice($.not, $.leave, $.parentheses, $.comparison, $.path),
    comparison: ($) =>
      seq(
        field('left', $.path),
        field('operator', choice('<', '<=', '>', '>=', '==', '!=')),
        field('right', choice($.number, $.real, $.identifier)),
      ),
    or: ($) => prec.left(1, seq(field('left', $._predicate), 'or', field('right', $._predicate))),
    and: ($) => prec.left(2, seq(field('left', $._predicate), 'and', field('right', $._predicate))),
    not: ($) => prec(3, seq('not', field('operand', $._predicate))),
    leave: ($) => seq('leave', field('of', $.path)),
    parentheses: ($) => seq('(', $._formula, ')'),

    // ---- Values and names -----------------------------------------------------------------------------------------

    path: ($) => seq(field('name', $.identifier), repeat(seq('.', field('name', $.identifier)))),
    _path_of_ending: ($) =>
      seq(
        field('name', alias(choice('ok', 'failed'), $.identifier)),
        repeat1(seq('.', field('name', $.identifier))),
      ),
    _times: ($) => choice($.number, $.interval),
    interval: ($) => seq('[', field('lower', $.number), ',', field('upper', choice($.number, '*')), ']'),
    unit: () => choice('s', 'ms', 'us'),

    identifier: () => /[A-Za-z_][A-Za-z0-9_]*|no-overdue/,
    number: () => /[0-9]+/,
    real: () => /-[0-9]+|-?[0-9]+\.[0-9]+([eE][+-]?[0-9]+)?/,
    string: () => /"[^"\n]*"/,
    comment: () => token(choice(/\/\/[^\n]*/, /\/\*[^*]*\*+([^/*][^*]*\*+)*\//)),
  },
});
