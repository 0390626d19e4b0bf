// Checks of scenarios as tests: what is written, and what passes.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { reportOf, resultsOf, timeText, type Answer } from '../../src/testing/answers';
import { verify } from '../../src/testing/verify';
import { checksOf } from '../../src/testing/written';

const SCENARIO = `// check no: deadlock;
scenario tank { use "check x: deadlock;"; /* check no: deadlock; */
  client check { repeat * { check: send pump.fill; } }
  check deadlines: schedulable *;
  check response
    *;
  check response pump.report <= 9 ms;
  check no-overdue pump.report;
  check open: never`;

const answer = (check: string, of: string, more: Partial<Answer> = {}): Answer => ({ check, of, verdict: 'proved', soundness: 'exact', counterexample: [], ...more });
const written = checksOf(SCENARIO);
const named = (verdict: string, more: Partial<Answer> = {}) =>
  resultsOf({ unit: 'ms', checks: [answer('schedulable', 'a.t', { name: 'deadlines' }), answer('schedulable', 'a.u', { name: 'deadlines', verdict, ...more })] }, written.slice(0, 1))[0];

test('checks are found outside of comments, strings and clients', () => {
  assert.deepEqual(written.map((check) => [check.name, check.kind, check.text]), [
    ['deadlines', 'schedulable', 'check deadlines: schedulable *'],
    [undefined, 'response', 'check response *'],
    [undefined, 'response', 'check response pump.report <= 9 ms'],
    [undefined, 'no-overdue', 'check no-overdue pump.report'],
  ]);
  assert.equal(SCENARIO.slice(written[2]?.start, written[2]?.end), 'check response pump.report <= 9 ms;');
  assert.deepEqual(checksOf('check a: b; } }'), []);
});

test('a long text without an end is read in one pass', () => {
  const begun = Date.now();
  checksOf(`scenario a { check ${'/*'.repeat(200_000)}`);
  checksOf(`scenario a { check ${'"\n'.repeat(200_000)}`);
  checksOf(`scenario a {${'check '.repeat(200_000)}`);
  assert.ok(Date.now() - begun < 2000);
});

test('only proved passes; every other word does not, a later one included', () => {
  const { verdict } = JSON.parse(readFileSync(join(process.cwd(), '../docs/verify.schema.json'), 'utf8')).$defs;
  const outcomes = Object.fromEntries([...verdict.enum, 'simulated', 'open', ''].map((word: string) => [word, named(word)?.outcome]));
  const expected = { proved: 'passed', conditional: 'errored', vacuous: 'errored', bounded: 'errored', exceeds: 'failed', refuted: 'failed', unknown: 'errored', nothing: 'errored', simulated: 'errored', open: 'errored', '': 'errored' };
  assert.deepEqual(outcomes, expected);
  assert.match(named('unknown')?.messages[0] ?? '', /^gave up {2}deadlines: schedulable a\.u/);
  assert.match(named('vacuous')?.messages[0] ?? '', /^vacuous/);
});

test('a refuted check says its cause, its help and the end of its run', () => {
  const why = { words: { cause: '`pump.control` waits 6 ms for a core', remedy: 'it holds if `report_start` takes at most 5 ms' } };
  const counterexample = Array.from({ length: 20 }, (_, i) => ({ time: i, what: `step ${i}` }));
  const lines = named('refuted', { why, counterexample, value: 10, limit: 9 })?.messages[0]?.split('\n') ?? [];
  assert.deepEqual(lines.slice(0, 6), [
    'refuted  deadlines: schedulable a.u, 10 ms',
    'limit: 9 ms',
    'cause: `pump.control` waits 6 ms for a core',
    'help: it holds if `report_start` takes at most 5 ms',
    'run, after 12 other steps:',
    '  12 ms  step 12',
  ]);
});

test('a proof with a restriction names it', () => {
  assert.match(named('proved', { soundness: 'under' })?.lines[1] ?? '', /worst-case execution times only/);
});

test('answers without names pair up with their checks, or none of them passes', () => {
  const checks = [
    answer('schedulable', 'a.t', { name: 'deadlines' }),
    answer('response', 'a.t'),
    answer('response', 'pump.report', { verdict: 'bounded' }),
    answer('response', 'pump.report'),
    answer('no-overdue', 'pump.report', { verdict: 'refuted' }),
  ];
  const outcomes = (all: Answer[]) => resultsOf({ unit: 'ms', checks: all }, written).map((result) => result.outcome);
  assert.deepEqual(outcomes(checks), ['passed', 'errored', 'passed', 'failed']);
  assert.deepEqual(outcomes([...checks, answer('deadlock', '')]), ['passed', 'errored', 'errored', 'errored']);
  assert.deepEqual(outcomes(checks.slice(0, 1)), ['passed', 'errored', 'errored', 'errored']);
});

test('times have a unit of their size', () => {
  assert.equal(timeText(1103, '500 us'), '551.5 ms');
  assert.equal(timeText(0.5, 'ms'), '500 µs');
  assert.equal(timeText('unbounded', 'ms'), 'unbounded');
});

test('what is no report is none', () => {
  for (const text of ['', 'null', '[]', '{"unit":"ms"}', '{']) assert.equal(reportOf(text), undefined, text);
});

test('a cancelled verification kills its program', async () => {
  const abort = new AbortController();
  const words = ['-e', 'console.error(process.pid); setInterval(() => {}, 1000)'];
  const run = verify({ program: process.execPath, arguments: words, cwd: process.cwd(), env: process.env }, abort.signal);
  const begun = Date.now();
  setTimeout(() => abort.abort(), 300);
  assert.equal(await run, undefined);
  assert.ok(Date.now() - begun < 5000);
  await assert.rejects(verify({ program: '/nowhere/dotgen', arguments: [], cwd: process.cwd(), env: {} }, new AbortController().signal));
});
