// Writes genom3.tmLanguage.json, the TextMate grammar of GenoM3 specifications.
//
//   node syntaxes/build.mjs            write it
//   node syntaxes/build.mjs --check    fail if the committed file is not what this script writes
//
// GenoM3's keywords are contextual: `task`, `port` or `doc` are ordinary names wherever the language does not expect the
// keyword. So each statement is a begin/end rule that starts at its first word and ends at its `;`: keywords are looked
// for at the start of statements only, and each rule knows which names it holds.
//
// The grammar colours what position alone can tell. What needs meaning (is this name a port or an IDS member?) is left
// to the server's semantic tokens.
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const re = String.raw;
const SUFFIX = '.genom3';
const ID = re`[A-Za-z_]\w*`;

// ---- Building blocks ----------------------------------------------------------------------------------------------

const scope = (value) => (typeof value === 'string' ? { name: value + SUFFIX } : value);
/** `captures` is a list (1, 2, …, holes allowed) of scopes or of capture objects. */
const captures = (list) => Object.fromEntries(list.flatMap((c, i) => (c ? [[i + 1, scope(c)]] : [])));
/** A single-line pattern whose whole match has the scope `name`. */
const token = (name, match) => ({ name: name + SUFFIX, match });
/** A single-line pattern with a scope for each group. */
const match = (regex, ...groups) => ({ match: regex, captures: captures(groups) });
const include = (...names) => names.map((name) => ({ include: '#' + name }));
const any = (...patterns) => ({ patterns: patterns.flat() });
const delimited = (name, begin, end, delimiters, patterns, options = {}) => ({
  ...(name && { name: name + SUFFIX }),
  begin,
  beginCaptures: { 0: { name: `${delimiters}.begin${SUFFIX}` } },
  end,
  endCaptures: { 0: { name: `${delimiters}.end${SUFFIX}` } },
  ...options,
  patterns,
});
const block = (kind, patterns) => delimited(`meta.block.${kind}`, re`\{|<%`, re`\}|%>`, 'punctuation.section.block', patterns);
const parens = (kind, patterns) => delimited(`meta.${kind}`, re`\(`, re`\)|(?=;|\}|%>)`, 'punctuation.section.parens', patterns);
const string = (name) => delimited(name, '"', '"', 'punctuation.definition.string', [token('constant.character.escape', re`\\[\\\"]`)]);

// A statement also ends before a line that can only begin another one: a forgotten `;` costs one line its colours, not
// the rest of the file.
const NEXT_STATEMENT =
  re`(?=^\s*(?:(?:component|interface|task|function|activity|attribute|module)\s+[A-Za-z_]` +
  re`|ids\s*\{|(?:async\s+)?codel\s*<|port\s+(?:multiple\s+)?(?:in|out)\s|const\s|typedef\s|(?:#|%:)))`;
const END = re`(;)|(?=\}|%>)|` + NEXT_STATEMENT;
const statement = (name, begin, groups, patterns, end = END) => ({
  ...(name && { name: name + SUFFIX }),
  begin,
  beginCaptures: captures(groups),
  end,
  endCaptures: captures(['punctuation.terminator.statement']),
  patterns,
});

/** `a::b::last`, optionally absolute. */
const scopedName = (last, lookahead = '') =>
  match(
    re`((?:::\s*)?(?:\b${ID}\s*::\s*)*)\b(${ID})\b${lookahead}`,
    any(match(re`(${ID})`, 'entity.name.namespace'), match('(::)', 'punctuation.separator.scope')),
    last,
  );

const r = {};

// ---- Comments -----------------------------------------------------------------------------------------------------

r.comments = any(
  delimited('comment.block', re`/\*`, re`\*/`, 'punctuation.definition.comment', include('codetag')),
  {
    name: 'comment.line.double-slash' + SUFFIX,
    begin: '//',
    beginCaptures: { 0: { name: 'punctuation.definition.comment' + SUFFIX } },
    end: re`(?<!\\)(?=\n)`,
    patterns: include('codetag', 'line-continuation'),
  },
);
r.codetag = token('keyword.codetag.notation', re`\b(?:TODO|FIXME|XXX|HACK|NOTE|BUG)\b`);
r['line-continuation'] = token('constant.character.escape.line-continuation', re`\\(?=\s*$)`);

// ---- Preprocessor -------------------------------------------------------------------------------------------------

const MACRO = 'entity.name.function.preprocessor';
/** A directive: `word` is the rest of the first group, from the directive's name on, with its closing parenthesis. */
const directive = (word, kind, patterns, groups = []) => ({
  name: `meta.preprocessor.${kind}${SUFFIX}`,
  begin: re`^\s*((?:#|%:)\s*` + word,
  beginCaptures: captures([`keyword.control.directive.${kind}`, ...groups]),
  end: re`(?<!\\)(?=\n)`,
  patterns,
});
const quotedPath = (name, open, body, close) => ({
  name: name + SUFFIX,
  match: `(${open})(${body})(${close})`,
  captures: captures(['punctuation.definition.string.begin', null, 'punctuation.definition.string.end']),
});
r.preprocessor = any(
  {
    begin: re`^\s*((?:#|%:)\s*if)\s+(0)\s*(?=$|//|/\*)`,
    beginCaptures: captures(['keyword.control.directive.conditional', 'constant.numeric.integer.octal']),
    end: re`(?=^\s*(?:#|%:)\s*(?:else|elif|endif)\b)`,
    contentName: 'comment.block.inactive' + SUFFIX,
    patterns: include('inactive-nested'),
  },
  directive(re`include)\b`, 'include', [
    ...include('comments'),
    quotedPath('string.quoted.other.angle.include', '<', re`[^>\n]*`, '>'),
    quotedPath('string.quoted.double.include', '"', re`[^"\n]*`, '"'),
    token(MACRO, ID),
    ...include('line-continuation'),
  ]),
  directive(
    re`define)\s+(${ID})(?=\()`,
    'define',
    [
      delimited(null, re`\G\(`, re`\)`, 'punctuation.section.parens', [
        token('keyword.operator.variadic', re`\.\.\.`),
        token('variable.parameter.preprocessor', ID),
        token('punctuation.separator.list', ','),
      ]),
      ...include('macro-body'),
    ],
    [MACRO],
  ),
  directive(re`define)\b(?:\s+(${ID}))?`, 'define', include('macro-body'), [MACRO]),
  directive(re`(?:ifdef|ifndef))\b(?:\s+(${ID}))?`, 'conditional', include('comments'), [MACRO]),
  directive(re`undef)\b(?:\s+(${ID}))?`, 'undef', include('comments'), [MACRO]),
  directive(re`(?:if|elif))\b`, 'conditional', [
    ...include('comments', 'line-continuation'),
    token('keyword.operator.word.defined', re`\bdefined\b`),
    ...include('numbers', 'characters'),
    token('keyword.operator.preprocessor', re`&&|\|\||==|!=|<=|>=|<<|>>|[-+*/%!~&|^<>?:,]`),
    token(MACRO, ID),
  ]),
  directive(re`(?:else|endif))\b`, 'conditional', include('comments')),
  directive(re`(?:error|warning))\b`, 'diagnostic', [
    ...include('comments', 'line-continuation'),
    token('string.unquoted.message', re`[^\s/\\](?:[^/\\\n]|/(?![/*])|\\(?!\s*$))*`),
  ]),
  directive(re`line)\b`, 'line', include('comments', 'numbers', 'strings')),
  directive(
    re`pragma)\s+(requires?)\b`,
    'pragma',
    [...include('comments', 'strings', 'line-continuation'), token('string.unquoted.package', re`[^\s"]+`)],
    ['keyword.other.pragma.requires'],
  ),
  directive(
    re`pragma)\s+(provides?)\b`,
    'pragma',
    [...include('comments', 'line-continuation'), token('entity.other.inherited-class.interface', ID)],
    ['keyword.other.pragma.provides'],
  ),
  directive(
    re`pragma)\s+(masquerade)\b`,
    'pragma',
    [
      ...include('comments', 'strings', 'line-continuation'),
      match(re`\G\s*([^\s"]+)`, 'string.unquoted.template'),
      scopedName('entity.name.type'),
    ],
    ['keyword.other.pragma.masquerade'],
  ),
  directive(re`pragma)\s+(wcet)\b(?:\s+(${ID}))?`, 'pragma', include('comments', 'duration', 'expression'), [
    'keyword.other.wcet',
    'entity.name.function.codel',
  ]),
  directive(re`pragma)\b(?:\s+(${ID}))?`, 'pragma', include('comments', 'strings', 'line-continuation'), ['keyword.other.pragma']),
  directive(re`)(?=\s*\S|\s*$)`, 'other', include('comments')),
);
r['inactive-nested'] = any({
  begin: re`^\s*(?:#|%:)\s*if(?:n?def)?\b`,
  end: re`^\s*(?:#|%:)\s*endif\b`,
  patterns: include('inactive-nested'),
});
// The text of a macro can be any part of a statement: keywords are shown as such wherever they stand.
r['macro-body'] = any(
  include('comments', 'line-continuation'),
  token('keyword.operator.paste.preprocessor', '##'),
  token('keyword.operator.stringize.preprocessor', re`#(?=\s*[A-Za-z_])`),
  token('variable.language.preprocessor', re`\b__VA_ARGS__\b`),
  token(
    'storage.type',
    re`\b(?:component|interface|task|function|activity|attribute|codel|port|ids|module|const|typedef|native|exception|struct|union|enum)\b`,
  ),
  token('storage.modifier', re`\b(?:async|in|out|inout|local|remote|multiple|validate)\b`),
  token('keyword.control', re`\b(?:yields?|throws?|pause)\b`),
  token('keyword.other.wcet', re`\bwcet\b`),
  include('primitive-type', 'duration', 'numbers', 'strings', 'characters', 'booleans', 'operators'),
);
r['pragma-operator'] = {
  name: 'meta.preprocessor.pragma' + SUFFIX,
  begin: re`\b(_Pragma)\s*(\()`,
  beginCaptures: captures(['keyword.control.directive.pragma', 'punctuation.section.parens.begin']),
  end: re`\)`,
  endCaptures: { 0: { name: 'punctuation.section.parens.end' + SUFFIX } },
  patterns: include('comments', 'strings'),
};

// ---- Literals and expressions -------------------------------------------------------------------------------------

r.strings = string('string.quoted.double');
r['doc-strings'] = string('string.quoted.double.documentation');
r.characters = {
  name: 'string.quoted.single' + SUFFIX,
  match: re`(')(?:(\\.)|[^'\\\n])*(')`,
  captures: captures(['punctuation.definition.string.begin', 'constant.character.escape', 'punctuation.definition.string.end']),
};
r.booleans = token('constant.language.boolean', re`\b(?:TRUE|FALSE)\b`);
const INTEGER_SUFFIX = re`(?:(?:[uU][lL]|[lL][uU]|[uUlL])(?!\w))?`;
r.numbers = any(
  token(
    'constant.numeric.float',
    re`(?<![\w.])(?:\d+\.\d*|\.\d+)(?:[eE][-+]?\d+)?([fFlL](?!\w))?|(?<![\w.])\d+[eE][-+]?\d+([fFlL](?!\w))?`,
  ),
  token('constant.numeric.integer.hexadecimal', re`(?<![\w.])0[xX][0-9A-Fa-f]+` + INTEGER_SUFFIX),
  token('constant.numeric.integer.octal', re`(?<![\w.])0[0-7]+(?![89])` + INTEGER_SUFFIX),
  token('constant.numeric.integer.decimal', re`(?<![\w.])\d+` + INTEGER_SUFFIX),
);
r.duration = any(
  match(
    re`(?<![\w.])((?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?)\s*(ms|us|s)\b`,
    'constant.numeric.duration',
    'keyword.other.unit.time',
  ),
  match(re`(?<=[\w)])\s+(ms|us|s)\b`, 'keyword.other.unit.time'),
);
const OPERATOR_WORD = token('keyword.operator.word', re`\b(?:xor|bitand|bitor|compl|not)\b`);
const ARITHMETIC = token('keyword.operator.arithmetic', '[-+*/%]');
const BITWISE = token('keyword.operator.bitwise', '[&|^~]');
r.operators = any(OPERATOR_WORD, token('keyword.operator.shift', '<<|>>'), ARITHMETIC, BITWISE);
r.expression = any(
  include('comments', 'preprocessor', 'numbers', 'strings', 'characters', 'booleans', 'operators'),
  parens('group', include('expression')),
  scopedName('variable.other.constant'),
);
// Between `<` and `>` a `>` closes: the shift to the right cannot be told from two closings, and is not offered.
r['expression-in-angle'] = any(
  include('comments', 'numbers', 'strings', 'booleans'),
  OPERATOR_WORD,
  token('keyword.operator.shift', '<<'),
  ARITHMETIC,
  BITWISE,
  include('list-separator'),
  scopedName('variable.other.constant'),
);
r['list-separator'] = token('punctuation.separator.list', ',');

// ---- Types --------------------------------------------------------------------------------------------------------

r['primitive-type'] = token(
  'support.type.primitive',
  re`\b(?:unsigned\s+(?:long\s+long|long|short)|long\s+long|long|short|unsigned|boolean|octet|char|any|float|double|string|wstring|wchar|object|fixed)\b`,
);
const generic = (words, name, patterns) => ({
  begin: re`\b(${words})\s*(<)(?![%:])`,
  beginCaptures: captures([name, 'punctuation.definition.generic.begin']),
  end: '(>)|(?=[;{}])',
  endCaptures: captures(['punctuation.definition.generic.end']),
  patterns,
});
r['generic-type'] = any(
  generic('sequence|optional', 'support.type.generic', [
    ...include('comments', 'generic-type', 'primitive-type'),
    {
      begin: ',',
      beginCaptures: { 0: { name: 'punctuation.separator.list' + SUFFIX } },
      end: '(?=>|;)',
      patterns: include('expression-in-angle'),
    },
    scopedName('entity.name.type'),
  ]),
  generic('string|fixed', 'support.type.primitive', include('expression-in-angle')),
);
r.type = any(
  include('comments', 'preprocessor', 'generic-type', 'primitive-type', 'constructed-type'),
  scopedName('entity.name.type', re`(?!\s*\()`),
);
r.array = delimited(null, re`\[|<:`, re`\]|:>|(?=[;{}])`, 'punctuation.definition.array', include('expression'));
/** The declared name is the one that something other than a name follows. */
const DECLARED = re`\b(${ID})\b(?=\s*(?:[,;=)\[{]|<:|<%|:(?!:)))`;
const declarators = (name) => [match(DECLARED, name), ...include('array', 'list-separator')];
const constructed = (word, patterns) => ({
  begin: re`\b(${word})\b(?:\s+(${ID}))?`,
  beginCaptures: captures([`storage.type.${word}`, `entity.name.type.${word}`]),
  end: re`(?<=\}|%>)|(?=[;,)])`,
  patterns: [...patterns, ...include('comments', 'preprocessor')],
});
r['constructed-type'] = any(
  constructed('struct', include('members')),
  constructed('union', [
    token('keyword.control.switch', re`\bswitch\b`),
    parens('switch', include('type')),
    ...include('members'),
  ]),
  constructed('enum', [
    block('enum', [...include('comments', 'preprocessor'), token('variable.other.enummember', ID), ...include('list-separator')]),
  ]),
);
r.members = block('members', [
  ...include('comments', 'preprocessor', 'pragma-operator'),
  {
    begin: re`\b(case)\b`,
    beginCaptures: captures(['keyword.control.case']),
    end: '(?<!:):(?!:)|(?=[;{}])',
    endCaptures: { 0: { name: 'punctuation.separator.case' + SUFFIX } },
    patterns: include('expression'),
  },
  match(re`\b(default)\s*(:)(?!:)`, 'keyword.control.default', 'punctuation.separator.case'),
  token('punctuation.terminator.statement', ';'),
  ...declarators('variable.other.member'),
  ...include('type'),
]);

// ---- IDL statements -----------------------------------------------------------------------------------------------

r['idl-statements'] = any(
  statement(
    'meta.module',
    re`\b(module)\b(?:\s+(${ID}))?`,
    ['storage.type.module', 'entity.name.namespace.module'],
    [
      ...include('comments', 'preprocessor'),
      block('module', include('comments', 'preprocessor', 'pragma-operator', 'idl-statements')),
    ],
    re`(;)|(?=\}|%>)`,
  ),
  statement('meta.constant', re`\b(const)\b`, ['storage.type.const'], [
    ...include('comments', 'preprocessor'),
    {
      begin: '=',
      beginCaptures: { 0: { name: 'keyword.operator.assignment' + SUFFIX } },
      end: re`(?=;|\}|%>)`,
      patterns: include('expression'),
    },
    match(re`\b(${ID})\b(?=\s*=)`, 'variable.other.constant'),
    ...include('type'),
  ]),
  statement('meta.typedef', re`\b(typedef)\b`, ['storage.type.typedef'], [...declarators('entity.name.type.alias'), ...include('type')]),
  statement(
    'meta.native',
    re`\b(native)\b(?:\s+(${ID}))?`,
    ['storage.type.native', 'entity.name.type.native'],
    include('comments'),
  ),
  statement('meta.exception', re`\b(exception)\b`, ['storage.type.exception'], [
    ...include('comments', 'preprocessor', 'members', 'list-separator'),
    token('entity.name.type.exception', ID),
  ]),
  statement(null, re`(?=\b(?:struct|union|enum)\b)`, [], include('comments', 'preprocessor', 'constructed-type')),
);

// ---- Properties ---------------------------------------------------------------------------------------------------

const PROPERTY = 'keyword.other.property.';
r.properties = any(
  statement('meta.property.doc', re`\b(doc)\b`, [PROPERTY + 'doc'], include('comments', 'preprocessor', 'doc-strings')),
  statement('meta.property', re`\b(version|lang|email)\b`, [PROPERTY + '$1'], include('comments', 'preprocessor', 'strings')),
  statement(
    'meta.property.requires',
    re`\b(codels-requires?|requires?)\b`,
    [PROPERTY + 'requires'],
    include('comments', 'preprocessor', 'strings', 'list-separator'),
  ),
  statement('meta.property.duration', re`\b(clock-rate|period|delay)\b`, [PROPERTY + '$1'], include('duration', 'expression')),
  statement('meta.property', re`\b(priority)\b`, [PROPERTY + 'priority'], include('expression')),
  statement('meta.property', re`\b(scheduling)\b`, [PROPERTY + 'scheduling'], [
    ...include('comments'),
    token('constant.language.scheduling', re`\breal-time\b`),
  ]),
  statement('meta.property', re`\b(stack)\b`, [PROPERTY + 'stack'], [
    match(re`(?<![\w.])(\d+)\s*([kM])\b`, 'constant.numeric.integer.decimal', 'keyword.other.unit.size'),
    match(re`(?<=[\w)])\s+([kM])\b`, 'keyword.other.unit.size'),
    ...include('expression'),
  ]),
  statement('meta.property.interface', re`\b(provides?|uses?|extends?)\b`, [PROPERTY + 'interface'], [
    ...include('comments', 'preprocessor', 'list-separator'),
    token('entity.other.inherited-class.interface', ID),
  ]),
  statement('meta.property.throw', re`\b(throws?)\b`, ['keyword.control.throw'], [
    ...include('comments', 'preprocessor', 'list-separator'),
    scopedName('entity.name.type.exception'),
  ]),
  statement('meta.property.services', re`\b(interrupts?|before|after)\b`, [PROPERTY + '$1'], [
    ...include('comments', 'preprocessor', 'list-separator'),
    token('variable.language.all', re`\ball\b`),
    token('entity.name.function.service', ID),
  ]),
);

// ---- Codels -------------------------------------------------------------------------------------------------------

const STATE = any(
  token('variable.language.state', re`\b(?:start|stop|ether)\b`),
  token('variable.other.enummember.state', ID),
);
// A name after `yield` or a comma is a state, whatever it is called: `yield wcet wcet 3 ms`.
const PAUSED_STATE = re`(?:(pause)\s*(::)\s*)?(${ID})?`;
const PAUSED_STATE_GROUPS = ['keyword.control.pause', 'punctuation.separator.scope', STATE];
r.states = any(
  match(re`\b(pause)\s*(::)\s*(${ID})?`, ...PAUSED_STATE_GROUPS),
  match(`(${ID})`, STATE),
  include('list-separator'),
);
const implementedStates = delimited('meta.states', '<(?![%:])', '>|(?=[;{}()])', 'punctuation.definition.states', include('comments', 'preprocessor', 'states'));
r.codels = any(
  statement('meta.codel', re`(?:\b(async)\s+)?\b(codel)\b`, ['storage.modifier.async', 'storage.type.codel'], [
    implementedStates,
    ...include('codel-call'),
  ]),
  statement('meta.codel', re`\b(async)\b(?=\s*$)`, ['storage.modifier.async'], [
    ...include('comments'),
    {
      begin: re`\b(codel)\b`,
      beginCaptures: captures(['storage.type.codel']),
      end: re`(?=;|\}|%>)`,
      patterns: [implementedStates, ...include('codel-call')],
    },
  ]),
  statement('meta.codel.validate', re`\b(validate)\b`, ['storage.type.codel.validate'], include('codel-call')),
);
r['codel-call'] = any(
  include('comments', 'preprocessor'),
  {
    begin: re`\b(${ID})\s*(\()`,
    beginCaptures: captures(['entity.name.function.codel', 'punctuation.section.parens.begin']),
    end: re`(\))|(?=[;}]|%>)`,
    endCaptures: captures(['punctuation.section.parens.end']),
    contentName: 'meta.codel.parameters' + SUFFIX,
    patterns: include('codel-parameters'),
  },
  match(re`\b(yields?)\b\s*` + PAUSED_STATE, 'keyword.control.yield', ...PAUSED_STATE_GROUPS),
  match(re`(,)\s*` + PAUSED_STATE, 'punctuation.separator.list', ...PAUSED_STATE_GROUPS),
  {
    name: 'meta.wcet' + SUFFIX,
    begin: re`\b(wcet)\b(?!\s*[,;])`,
    beginCaptures: captures(['keyword.other.wcet']),
    end: re`(?=;|\}|%>|,|\byields?\b)|` + NEXT_STATEMENT,
    patterns: include('duration', 'expression'),
  },
  include('duration', 'numbers', 'states'),
);
const DIRECTION = re`\b(inout|in|out)\b`;
const RENAMED = match(re`(::)\s*(${ID})`, 'keyword.operator.rename', 'variable.parameter.renamed');
const MEMBER = match(re`(\.)\s*(${ID})`, 'punctuation.accessor', 'variable.other.member');
r['codel-parameters'] = any(
  include('comments', 'preprocessor'),
  match(
    re`(?:\b(ids|local|port|remote)\s+)?${DIRECTION}\s*\b(${ID})?`,
    'storage.modifier.source',
    'storage.modifier.direction',
    'variable.parameter',
  ),
  match(re`\b(ids|local|port|remote)\b`, 'storage.modifier.source'),
  RENAMED,
  MEMBER,
  include('array', 'list-separator'),
  token('variable.parameter', ID),
);

// ---- Services -----------------------------------------------------------------------------------------------------

r.initializer = any({
  begin: '=',
  beginCaptures: { 0: { name: 'keyword.operator.assignment' + SUFFIX } },
  end: '(?=[,);])',
  patterns: include('initializer-value'),
});
r['initializer-value'] = any(
  {
    begin: '(?<!:):(?!:)',
    beginCaptures: { 0: { name: 'punctuation.separator.documentation' + SUFFIX } },
    end: '(?=[,)};])',
    patterns: include('comments', 'doc-strings'),
  },
  delimited('meta.initializer', re`\{|<%`, re`\}|%>`, 'punctuation.section.block', [
    match(re`(\.)\s*(${ID})\s*(=)`, 'punctuation.accessor', 'variable.other.member', 'keyword.operator.assignment'),
    token('keyword.operator.assignment', '='),
    ...include('array', 'list-separator', 'initializer-value'),
  ]),
  include('expression'),
);
r['service-parameters'] = any(
  include('comments', 'preprocessor'),
  match(DIRECTION + re`(?=\s*[A-Za-z_:]|\s*$|\s*/)`, 'storage.modifier.direction'),
  include('initializer'),
  match(DECLARED, 'variable.parameter'),
  include('array', 'list-separator', 'type'),
);
r['attribute-parameters'] = any(
  include('comments', 'preprocessor'),
  match(re`${DIRECTION}\s*\b(${ID})?`, 'storage.modifier.direction', 'variable.parameter'),
  RENAMED,
  MEMBER,
  include('initializer', 'array', 'list-separator'),
);
// Inside a service `task` says where it runs; everywhere else it declares a task.
r['service-body'] = block('service', [
  ...include('comments', 'preprocessor', 'pragma-operator', 'codels'),
  statement('meta.property.task', re`\b(task)\b(?:\s+(${ID}))?`, [PROPERTY + 'task', 'entity.name.type.task'], include('comments')),
  statement('meta.local', re`\b(local)\b`, ['storage.modifier.local'], [...declarators('variable.other.local'), ...include('type')]),
  ...include('properties'),
]);
const service = (word, kind, parameters) =>
  statement('meta.service', re`\b(${word})\b(?:\s+(${ID}))?`, [`storage.type.service.${kind}`, 'entity.name.function.service'], [
    ...include('comments', 'preprocessor'),
    parens('parameters', include(parameters)),
    ...include('service-body'),
  ]);
r.services = any(
  service('function|activity', '$1', 'service-parameters'),
  service('attribute', 'attribute', 'attribute-parameters'),
);

// ---- Components and interfaces ------------------------------------------------------------------------------------

const propertyBlock = (kind) => block(kind, include('comments', 'preprocessor', 'pragma-operator', 'codels', 'properties'));
r.exports = any(
  include('services'),
  statement('meta.ids', re`\b(ids)\b`, ['storage.type.ids'], include('comments', 'preprocessor', 'members')),
  statement('meta.task', re`\b(task)\b(?:\s+(${ID}))?`, ['storage.type.task', 'entity.name.type.task'], [
    ...include('comments', 'preprocessor'),
    propertyBlock('task'),
  ]),
  statement(
    'meta.port',
    re`\b(port)\b(?:\s+(multiple)\b)?(?:\s+(inout|in|out)\b)?`,
    ['storage.type.port', 'storage.modifier.multiple', 'storage.modifier.direction'],
    [
      ...include('comments', 'preprocessor', 'constructed-type'),
      match(re`\b(${ID})\b(?=\s*(?:;|\{|<%))`, 'variable.other.port'),
      propertyBlock('port'),
      ...include('type'),
    ],
  ),
  include('codels', 'properties', 'idl-statements'),
);
r.components = any(
  statement(
    'meta.component',
    re`\b(component|interface)\b(?:\s+(${ID}))?`,
    ['storage.type.$1', 'entity.name.type.$1'],
    [...include('comments', 'preprocessor'), block('component', include('comments', 'preprocessor', 'pragma-operator', 'exports'))],
    re`(;)|(?=\}|%>)|(?=^\s*(?:component|interface)\s+[A-Za-z_])`,
  ),
);

// ---- Output -------------------------------------------------------------------------------------------------------

const grammar = {
  comment: 'Generated by syntaxes/build.mjs: change that file and run `npm run grammar`.',
  name: 'GenoM3',
  scopeName: 'source.genom3',
  fileTypes: ['gen'],
  // Statements of a component body are tried at top level too: a file may hold a part of a component, to be included.
  patterns: include('comments', 'preprocessor', 'pragma-operator', 'components', 'exports'),
  repository: r,
};
const path = fileURLToPath(new URL('genom3.tmLanguage.json', import.meta.url));
const text = JSON.stringify(grammar, null, 1) + '\n';
if (process.argv.includes('--check')) {
  if (readFileSync(path, 'utf8') !== text) {
    console.error('syntaxes/genom3.tmLanguage.json is out of date: run `npm run grammar` and commit it');
    process.exit(1);
  }
} else {
  writeFileSync(path, text);
}
