// Writes scenario.tmLanguage.json, the TextMate grammar of verification scenarios (.scn).
//
//   node syntaxes/build-scenario.mjs            write it
//   node syntaxes/build-scenario.mjs --check    fail if the committed file is not what this script writes
//
// Statements begin with a keyword and end with `;`; names may be keywords anywhere else (a task may be called `check`), so
// keywords are coloured at the start of statements, and the other words in the statements they belong to.
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const re = String.raw;
const SUFFIX = '.genom3-scenario';
const ID = re`[A-Za-z_]\w*`;
const PATH = re`${ID}(?:\s*\.\s*${ID})*`;

const captures = (list) => Object.fromEntries(list.flatMap((name, i) => (name ? [[i + 1, { name: name + SUFFIX }]] : [])));
const token = (name, match) => ({ name: name + SUFFIX, match });
const match = (regex, ...names) => ({ match: regex, captures: captures(names) });
const include = (...names) => names.map((name) => ({ include: '#' + name }));
const END = { end: re`(;)|(?=[{}])`, endCaptures: captures(['punctuation.terminator.statement']) };
const statement = (begin, names, patterns) => ({ begin, beginCaptures: captures(names), ...END, patterns: [...include('comments'), ...patterns] });
const choice = (keyword, words) => statement(re`\b(${keyword})\b`, ['keyword.other.setting'], [token('constant.language', re`\b(?:${words})\b`), ...include('numbers', 'path')]);

const r = {};
r.comments = {
  patterns: [
    { name: 'comment.line.double-slash' + SUFFIX, begin: '//', end: '$' },
    { name: 'comment.block' + SUFFIX, begin: re`/\*`, end: re`\*/` },
  ],
};
r.numbers = {
  patterns: [
    match(re`\b(\d+)\s*(s|ms|us)\b`, 'constant.numeric.integer', 'keyword.other.unit'),
    match(re`(\])\s*(s|ms|us)\b`, 'punctuation.section.interval.end', 'keyword.other.unit'),
    token('constant.numeric.float', re`-?\b\d+\.\d+(?:[eE][+-]?\d+)?\b`),
    token('constant.numeric.integer', re`\b\d+\b`),
    token('constant.language.unbounded', re`\*`),
    token('punctuation.section.interval.begin', re`\[`),
  ],
};
r.path = {
  patterns: [
    {
      match: PATH,
      captures: {
        0: {
          patterns: [
            match(re`\.\s*(waiting|running|idle|exec|lock|run|stop|void)\b(?!\s*\.)`, 'support.constant.status'),
            token('variable.other.member', re`(?<=\.)${ID}`),
            token('entity.name.type', re`\b${ID}(?=\s*\.)`),
            token('variable.other', ID),
            token('punctuation.separator.dot', re`\.`),
          ],
        },
      },
    },
  ],
};
r.string = { name: 'string.quoted.double' + SUFFIX, begin: '"', end: '"|$' };
r.items = {
  patterns: [
    ...include('comments'),
    statement(re`\b(use|times|weights)\b`, ['keyword.control.import'], include('string')),
    choice('unit', '(?!)'),
    choice('cores', 'free'),
    choice('policy', 'priority|fair|fifo|edf|any'),
    choice('durations', 'interval|fixed|open'),
    choice('duration', '(?!)'),
    choice('loop', 'free|once'),
    choice('idle', 'drop|keep'),
    choice('locks', 'free|fifo'),
    choice('async', 'held|free'),
    choice('aperiodic', 'core|free'),
    choice('slots', '(?!)'),
    statement(re`\b(connect)\b`, ['keyword.other.setting'], [token('keyword.operator.word', re`\bto\b`), token('constant.language', re`\bnone\b`), ...include('path')]),
    match(re`\b(client)\b(?:\s+(${ID}))?`, 'storage.type.client', 'entity.name.function.client'),
    ...include('steps-block'),
    statement(re`\b(on)\b(?:\s+(${ID})\s*(:))?\s*(late|lost|stale|violation\s+of)\b`, ['storage.type.measure', 'entity.name.label', 'punctuation.separator.label', 'keyword.operator.word'], [
      token('keyword.operator.word', re`\bafter\b(?!\s*\.)`),
      token('keyword.operator', '<='),
      ...include('numbers', 'path'),
    ]),
    statement(re`\b(check)\b(?:\s+(${ID})\s*(:))?`, ['keyword.control.check', 'entity.name.label', 'punctuation.separator.label'], [
      token('support.function.check', re`\b(?:schedulable|response|within|reaction|age|leadsto|eventually|always|never|reachable|deadlock|absent|lasts|precedes|before|after|between)\b(?!\s*\.)|\bno-overdue\b`),
      token('keyword.operator.word', re`\b(?:and|or|not|leave|then|via|in|for|until)\b(?!\s*\.)`),
      token('keyword.operator', '=>|->|[<>]=?|[=!]='),
      token('constant.language.boolean', re`\b(?:true|false)\b`),
      ...include('numbers', 'path'),
    ]),
  ],
};
const block = (patterns) => ({
  begin: re`\{`,
  beginCaptures: { 0: { name: 'punctuation.section.block.begin' + SUFFIX } },
  end: re`\}`,
  endCaptures: { 0: { name: 'punctuation.section.block.end' + SUFFIX } },
  patterns,
});
r['steps-block'] = block(include('steps'));
r.steps = {
  patterns: [
    ...include('comments'),
    match(re`\b(${ID})\s*(:)`, 'entity.name.label', 'punctuation.separator.label'),
    statement(re`\b(send)\b`, ['keyword.control.send'], include('path')),
    statement(re`\b(await)\b(?:\s+(accepted|ended)\b)?`, ['keyword.control.await', 'constant.language'], include('path')),
    statement(re`\b(delay)\b`, ['keyword.control.delay'], include('numbers')),
    statement(re`\b(abort)\b`, ['keyword.control.abort'], include('path')),
    statement(re`\b(kill)\b`, ['keyword.control.kill'], include('path')),
    statement(re`\b(connect)\b`, ['keyword.control.connect'], include('path')),
    token('keyword.control.stop', re`\bstop\b`),
    match(re`\b(repeat)\b(?:\s*(?:(\d+)|(\*)))?`, 'keyword.control.repeat', 'constant.numeric.integer', 'constant.language.unbounded'),
    token('keyword.control.choice', re`\b(?:choice|or)\b`),
    ...include('steps-block'),
  ],
};

const grammar = {
  comment: 'Generated by syntaxes/build-scenario.mjs: change that file and run `npm run grammar`.',
  name: 'GenoM3 scenario',
  scopeName: 'source' + SUFFIX,
  fileTypes: ['scn'],
  patterns: [...include('comments'), match(re`\b(scenario)\b(?:\s+(${ID}))?`, 'storage.type.scenario', 'entity.name.type.scenario'), block(include('items'))],
  repository: r,
};
const path = fileURLToPath(new URL('scenario.tmLanguage.json', import.meta.url));
const text = JSON.stringify(grammar, null, 1) + '\n';
if (process.argv.includes('--check')) {
  if (readFileSync(path, 'utf8') !== text) {
    console.error('syntaxes/scenario.tmLanguage.json is out of date: run `npm run grammar` and commit it');
    process.exit(1);
  }
} else {
  writeFileSync(path, text);
}
