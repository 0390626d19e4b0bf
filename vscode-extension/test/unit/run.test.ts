// A run as a child, and what is said at its socket.
import assert from 'node:assert/strict';
import { chmodSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { adapter, attaching, type Debugger } from '../../src/run/debugger';
import { Run, argumentsOf, reportOf, type Host, type RunOptions } from '../../src/run/process';
import { numbers, value } from '../../src/run/values';

// Listens as `dotgen run --clock real` does, tells of a port, answers a request, and ends with a report when it is stopped.
const PROGRAM = `#!${process.execPath}
const at = process.argv[process.argv.indexOf('--socket') + 1];
console.error('note: it begins');
const report = () => { console.log(JSON.stringify({ scenario: 'tank', tasks: [], 'violation-count': 0, end: 'interrupted' })); process.exit(0); };
process.on('SIGINT', report);
require('node:net').createServer((it) => {
  const say = (told) => it.write(JSON.stringify(told) + '\\n');
  it.write('{"id": "half\\n');
  require('node:readline').createInterface({ input: it }).on('line', (line) => {
    const { id, describe, progress, violations, watch, call, input } = JSON.parse(line);
    if (progress === null) say({ id, event: 'progress', time: 5, unit: 'ms', tasks: [], machines: [], activities: [], 'violation-count': 0 });
    if (violations === null) for (const times of [1, 3]) say({ id, event: 'violation', number: 0, unit: 'ms', what: 'response pump.main', violation: { at: { time: 4 }, times, kind: 'check', check: 0 } });
    if (describe === null) say({ id, event: 'description', components: [{ name: 'pump', services: [{ name: 'fill', kind: 'activity', doc: 'Pumps.', inputs: [{ name: 'height', default: 1, schema: { type: ['number', 'null'] } }], outputs: [] }], ports: [{ name: 'level', direction: 'out', doc: null }, { name: 'flow', direction: 'in', doc: null }] }] });
    if (watch) for (const z of [1, 2]) say({ id, event: 'data', value: { z, name: 'a' } });
    if (call) say({ id, event: 'accepted' }), say({ id, event: 'done', output: input });
  });
}).listen(at);
`;

test('specifications are read as in the editor', () => {
  const reading = { includePaths: ['idl', '/opt/idl'], defines: { SIM: true, OLD: false, N: 3 }, release: '2.99.39' };
  const options: RunOptions = { command: 'dotgen', env: {}, file: '/r/a.gen', cwd: '/r', clock: 'virtual', reading };
  const given = argumentsOf(options, '/t/run.json', '', 'p').join(' ');
  assert.match(given, / -I \/r\/idl -I \/opt\/idl -D SIM -D N=3 --release 2\.99\.39 /);
});

test('components that wait for a debugger are told before the report', { skip: process.platform === 'win32' }, async () => {
  const program = `#!${process.execPath}
require('node:fs').writeFileSync(process.argv[process.argv.indexOf('--profile') + 1], '');
console.log('{"component":"pump","process":17}');
process.stdout.write('{"component":"tank","pro');
setImmediate(() => process.stdout.write('cess":18}\\n' + JSON.stringify({ scenario: 'pump', tasks: [] }, null, 2) + '\\n'));
`;
  const hosts: Host[] = [];
  const it = started(program, 'virtual', (host) => hosts.push(host));
  await shown(it, () => it.run.isOver);
  assert.deepEqual(hosts, [{ component: 'pump', process: 17 }, { component: 'tank', process: 18 }]);
  assert.equal(it.run.view.report?.scenario, 'pump');
  // A codel at which a debugger stood took no time of its own.
  assert.equal(it.run.question, undefined);
  it.end();
});

test('each debugger attaches in its own way', () => {
  const host = { component: 'pump', process: 17 };
  const of = (it: Debugger) => Object.values(attaching(it, host, '/p/dotgen'));
  assert.deepEqual(of({ kind: 'lldb' }), ['pump', 'attach', '/p/dotgen', 'lldb', 17]);
  assert.deepEqual(of({ kind: 'cppdbg' }), ['pump', 'attach', '/p/dotgen', 'cppdbg', '17', 'gdb']);
  assert.deepEqual(of(adapter('/usr/bin/gdb')), ['pump', 'attach', '/p/dotgen', 'dotgen', 17, ['/usr/bin/gdb', '-q', '-i=dap']]);
  assert.deepEqual(of(adapter('lldb-dap')), ['pump', 'attach', '/p/dotgen', 'dotgen', 17, ['lldb-dap']]);
});

/** Waits until something is shown. */
async function shown(changes: { next: () => Promise<void> }, holds: () => boolean): Promise<void> {
  while (!holds()) await changes.next();
}

function started(program: string, clock: RunOptions['clock'], waiting?: (host: Host) => void): { run: Run; next: () => Promise<void>; end: () => void } {
  const cwd = mkdtempSync(join(tmpdir(), 'dotgen-test-'));
  const command = join(cwd, 'program');
  writeFileSync(command, program);
  chmodSync(command, 0o755);
  let wake = (): void => {};
  const run = new Run({ command, env: process.env, file: 'pump.scn', cwd, clock, waiting }, 'pump.scn', () => wake());
  const next = () => new Promise<void>((resolve) => (wake = resolve));
  return { run, next, end: () => (run.dispose(), rmSync(cwd, { recursive: true })) };
}

test('a run on the real clock is seen, asked and stopped', { skip: process.platform === 'win32' }, async () => {
  const it = started(PROGRAM, 'real');
  const { run } = it;
  await shown(it, () => run.view.ports[0]?.series[0]?.values.length === 2);
  assert.deepEqual(run.view.ports, [{ name: 'pump/level', doc: null, value: '{"z":2,"name":"a"}', series: [{ name: 'z', values: [1, 2] }] }]);
  assert.deepEqual(run.view.log, ['note: it begins']);
  assert.equal(run.view.state, 'running');
  await shown(it, () => run.view.progress?.time === 5);
  // A repeated violation comes again.
  await shown(it, () => run.view.violations[0]?.violation.times === 3);
  assert.deepEqual(run.view.violations.map((it) => it.what), ['response pump.main']);
  run.call('pump.fill', { height: 2.5 });
  await shown(it, () => run.view.services[0]?.answer.startsWith('done') === true);
  assert.equal(run.view.services[0]?.answer, 'done: {"height":2.5}');
  run.stop();
  assert.equal(run.view.state, 'stopping');
  await shown(it, () => run.isOver);
  assert.equal(run.view.state, 'ended');
  assert.equal(run.view.report?.end, 'interrupted');
  it.end();
});

test('a program that writes no report, or is not there, says why', { skip: process.platform === 'win32' }, async () => {
  const it = started(`#!${process.execPath}\nconsole.error('error: no such scenario'); process.exit(2);\n`, 'virtual');
  await shown(it, () => it.run.isOver);
  assert.equal(it.run.view.state, 'failed');
  assert.deepEqual(it.run.view.log, ['error: no such scenario']);
  it.end();
  const none = started('#!/nowhere/at-all\n', 'virtual');
  await shown(none, () => none.run.isOver);
  assert.equal(none.run.view.state, 'failed');
  assert.match(none.run.view.log.join(), /ENOENT/);
  none.end();
});

test('what is simulated needs no sources and no socket', () => {
  const options = { command: 'dotgen', env: {}, file: 'a.scn', cwd: '/', clock: 'virtual' } as const;
  assert.deepEqual(argumentsOf(options, 't.json', 's', 'p'), ['run', 'a.scn', '--simulate', 'all', '--trace', 't.json', '--profile', 'p', '--format', 'json']);
});

test('inputs are JSON, or else texts; numbers are found in what ports have', () => {
  assert.deepEqual(['2', '{"a": 1}', 'RED', '"x"'].map(value), [2, { a: 1 }, 'RED', 'x']);
  assert.deepEqual(numbers({ a: 1, b: [2, { c: 3 }], d: 'x', e: null }), [['a', 1], ['b.0', 2], ['b.1.c', 3]]);
  assert.equal(reportOf('[]'), null);
  assert.equal(reportOf(''), null);
});
