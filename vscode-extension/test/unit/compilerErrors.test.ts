// Messages of compilers, with their places.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { compilerErrors } from '../../src/codels/compilerErrors';

const known = ['/ws/arm/codels/arm.c', '/ws/arm/.dotgen/run/arm/types.h'];
const errors = (...lines: string[]) => compilerErrors(lines, { cwd: '/ws', component: '/ws/arm', exists: (path) => known.includes(path) });

test('messages of dotgen have their place in the next line', () => {
  const lines = [
    'note: compiling 2 files of `arm.gen`',
    "error[codel/compiler]: expected ';' before 'x'",
    '   --> arm/codels/arm.c:34:1',
    '    |',
    ' 34 | x = 1;',
    '    |',
    '   ::: arm/arm.gen:62:14',
    'warning[codel/compiler]: unused variable',
    '  --> arm/codels/arm.c:3:7',
    'error[syntax/expected]: of the specification',
    '  --> arm/arm.gen:1:1',
  ];
  assert.deepEqual(errors(...lines, ...lines), [
    { file: '/ws/arm/codels/arm.c', line: 34, column: 1, severity: 'error', message: "expected ';' before 'x'" },
    { file: '/ws/arm/codels/arm.c', line: 3, column: 7, severity: 'warning', message: 'unused variable' },
  ]);
});

test('messages of gcc and clang have their place in front, relative to the component', () => {
  const places = errors('codels/arm.c:3:7: error: a: b', '/usr/include/a.h:1:2: fatal error: no file', '.dotgen/run/arm/types.h:9:1: warning: w', 'nowhere.c:1:1: error: e');
  assert.deepEqual(places.map(({ file, line, column, severity, message }) => [file, line, column, severity, message]), [
    ['/ws/arm/codels/arm.c', 3, 7, 'error', 'a: b'],
    ['/usr/include/a.h', 1, 2, 'error', 'no file'],
    ['/ws/arm/.dotgen/run/arm/types.h', 9, 1, 'warning', 'w'],
    ['/ws/arm/nowhere.c', 1, 1, 'error', 'e'],
  ]);
});

test('other lines have no errors', () => {
  assert.deepEqual(errors('codels/arm.c:3:7: note: declared here', 'codels/arm.c: In function f', '  --> arm/codels/arm.c:1:1', 'error: no compiler', ''), []);
});

test('length and number of messages are limited', () => {
  const long = errors(`codels/arm.c:1:1: error: ${'x'.repeat(100_000)}`)[0]?.message;
  assert.equal(long?.length, 1000);
  const many = Array.from({ length: 2000 }, (_, i) => `codels/arm.c:${i + 1}:1: error: e`);
  assert.equal(errors(...many).length, 500);
  const begun = Date.now();
  errors(...Array.from({ length: 500 }, () => 'a:1'.repeat(100_000)));
  assert.ok(Date.now() - begun < 2000);
});

test('the problem matcher of builds has the owner and the code of the errors of runs', () => {
  const source = readFileSync(join(process.cwd(), 'src/codels/problems.ts'), 'utf8');
  const { problemMatchers } = JSON.parse(readFileSync(join(process.cwd(), 'package.json'), 'utf8')).contributes;
  const [, owner] = /OWNER = '([^']+)'/.exec(source) ?? [];
  assert.equal(problemMatchers.find(({ name }: { name: string }) => name === 'dotgen-codels')?.owner, owner);
});
