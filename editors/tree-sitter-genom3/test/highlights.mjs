// Checks highlights, as `tree-sitter query --captures` or test/neovim.lua prints them:
//
//   node test/highlights.mjs CAPTURES GRAMMAR
//
// - No token has two highlights: editors differ in which pattern wins.
// - In the examples the highlights agree with the TextMate grammar of the VS Code extension, where that grammar has a
//   scope. Without the packages of that extension this check is skipped.
import { existsSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const [, , capturesPath, grammarName] = process.argv;
const files = new Map();
let current;
for (const line of readFileSync(capturesPath, 'utf8').split('\n')) {
  const found = line.match(/^ +pattern: +\d+, capture: \d+ - (\S+), start: \((\d+), (\d+)\), end: \((\d+), (\d+)\)/);
  if (found) current?.push({ name: found[1], row: +found[2], column: +found[3], end: `${found[4]}:${found[5]}` });
  else if (line.startsWith('/')) files.set(line, (current = []));
}
if (files.size === 0) throw new Error('no captures');

const problems = [];
for (const [file, captures] of files) {
  const seen = new Map();
  for (const { name, row, column, end } of captures) {
    const key = `${row}:${column}-${end}`;
    if (seen.has(key)) problems.push(`${file}:${row + 1}:${column + 1}: ${seen.get(key)} and ${name}`);
    seen.set(key, name);
  }
}

const extension = new URL('../../../vscode-extension/', import.meta.url);
if (existsSync(new URL('node_modules/vscode-textmate', extension))) await compare();
else console.log('highlights are not compared with the TextMate grammar: its packages are not installed');

for (const problem of problems.slice(0, 40)) console.error(problem);
process.exit(problems.length ? 1 : 0);

async function compare() {
  const require = createRequire(new URL('package.json', extension));
  const textmate = require('vscode-textmate');
  const oniguruma = require('vscode-oniguruma');
  await oniguruma.loadWASM(readFileSync(require.resolve('vscode-oniguruma/release/onig.wasm')).buffer);
  const file = grammarName === 'scenario' ? 'scenario' : 'genom3';
  const text = readFileSync(new URL(`syntaxes/${file}.tmLanguage.json`, extension), 'utf8');
  const raw = textmate.parseRawGrammar(text, 'grammar.json');
  const registry = new textmate.Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
      createOnigString: (string) => new oniguruma.OnigString(string),
    }),
    loadGrammar: async () => raw,
  });
  const grammar = await registry.loadGrammar(raw.scopeName);

  let compared = 0;
  let plain = 0;
  for (const [file, captures] of files) {
    if (!file.includes('/examples/')) continue;
    const lines = readFileSync(file).toString('latin1').split(/\r?\n/);
    const tokens = [];
    let state = textmate.INITIAL;
    for (const line of lines) {
      const result = grammar.tokenizeLine(line, state);
      state = result.ruleStack;
      tokens.push(result.tokens);
    }
    for (const { name, row, column } of captures) {
      const ours = kindOfCapture(name);
      if (!ours) continue;
      const token = tokens[row].find(({ endIndex }) => endIndex > column);
      const theirs = kindOfScopes(token?.scopes ?? []);
      const scope = token?.scopes.at(-1);
      if (scope === raw.scopeName) {
        plain++;
        continue;
      }
      compared++;
      if (ours !== theirs) {
        problems.push(`${file}:${row + 1}:${column + 1}: ${name}, but the TextMate grammar says ${scope}`);
      }
    }
  }
  console.log(`${compared} highlights compared with the TextMate grammar, ${plain} more have no scope there`);
}

function kindOfCapture(name) {
  const kinds = {
    'constant.builtin': 'word',
    'constant.macro': undefined,
    'function.macro': undefined,
    'string.special': undefined,
    'string.special.path': 'string',
    'keyword.operator': undefined,
    'type.builtin': 'type',
    'variable.member': 'variable',
    'variable.parameter': 'variable',
    module: undefined,
  };
  if (name in kinds) return kinds[name];
  const [head] = name.split('.');
  return { comment: 'comment', string: 'string', number: 'number', keyword: 'word', type: 'type', function: 'function', constant: 'constant', label: 'label', variable: 'variable' }[head];
}

function kindOfScopes(scopes) {
  if (scopes.some((scope) => scope.startsWith('comment'))) return 'comment';
  if (scopes.some((scope) => scope.startsWith('string'))) return 'string';
  const scope = scopes.at(-1) ?? '';
  const kinds = [
    ['constant.numeric', 'number'],
    ['variable.other.enummember.state', 'label'],
    ['entity.name.label', 'label'],
    ['variable.language.state', 'word'],
    ['variable.language.all', 'function'],
    ['constant.language', 'word'],
    ['support.function.check', 'function'],
    ['variable.other.constant', 'constant'],
    ['variable.other.enummember', 'constant'],
    ['constant', 'constant'],
    ['keyword', 'word'],
    ['storage', 'word'],
    ['support.type', 'type'],
    ['entity.name.type', 'type'],
    ['entity.other.inherited-class', 'type'],
    ['entity.name.function', 'function'],
    ['support.constant.status', 'variable'],
    ['variable', 'variable'],
  ];
  return kinds.find(([prefix]) => scope.startsWith(prefix))?.[1] ?? scope;
}
