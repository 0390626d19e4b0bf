// The line of each component on the page of a run, the filter of services and ports, and plots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Report, RunView } from '../../src/run/messages';
import { byComponent, componentLines, componentOf, Loads, matches, ordered, points } from '../../src/webview/summary';

const view = (more: Partial<RunView>): RunView => ({
  debug: false, name: 'a.scn', clock: 'real', state: 'running', report: null, progress: null, violations: [],
  simulated: [], times: 0, hasTrace: false, services: [], ports: [], log: [], ...more,
});
const task = (name: string, load?: number, missed = 0) => ({ task: name, jobs: 1, missed, ...(load === undefined ? {} : { load }) });
const service = (name: string, doc: string | null = null, inputs: string[] = []) => ({
  name, kind: 'activity', doc, inputs: inputs.map((it) => ({ name: it, schema: {} })), answer: '', active: false,
});

test('components have the load and the missed deadlines of their tasks', () => {
  const tasks = [task('pump.main', 0.25), task('tank.main', 0.5, 2), task('pump.log', 0.125, 1)];
  const progress = { unit: 'ms', time: 1, tasks, machines: [], activities: [], 'violation-count': 0 };
  const lines = componentLines(view({ progress, simulated: ['valve'], ports: [{ name: 'tank/level', doc: null, value: '', series: [] }] }));
  assert.deepEqual(lines, [
    { name: 'pump', load: 0.375, missed: 1, violations: 0 },
    { name: 'tank', load: 0.5, missed: 2, violations: 0 },
    { name: 'valve', load: undefined, missed: 0, violations: 0 },
  ]);
});

test('violations count at each component that they name', () => {
  const at = { time: 1 };
  const events = [
    { unit: 'ms', what: 'reaction pump.flow -> tank.level', violation: { at, kind: 'check', times: 3 } },
    { unit: 'ms', what: '', violation: { at, kind: 'overrun', codel: 'pumps.main.a' } },
    { unit: 'ms', what: '', violation: { at, kind: 'lost', component: 'tank' } },
  ];
  const services = ['pump.fill', 'tank.empty', 'pumps.all'].map((it) => service(it));
  const counts = (it: RunView) => componentLines(it).map((line) => line.violations);
  assert.deepEqual(counts(view({ violations: events, services })), [3, 4, 1]);
  const checks = [{ check: 'response', of: 'pump.main', verdict: 'violated', violations: 1 }];
  const report = { tasks: [], checks, violations: [{ at, kind: 'check', check: 0 }] } as unknown as Report;
  assert.deepEqual(counts(view({ report, violations: events, services })), [1, 0, 0]);
});

test('the last loads are those between two reports of progress', () => {
  const loads = new Loads();
  const add = (time: number, load: number) => loads.add(time, [{ name: 'pump', load, missed: 0, violations: 0 }]);
  add(100, 0.5);
  add(200, 0.5);
  add(200, 0.5);
  add(400, 0.25);
  assert.deepEqual(loads.of('pump'), [0.5, 0.5, 0]);
  assert.deepEqual(loads.of('tank'), []);
  // Another run begins.
  add(50, 1);
  assert.deepEqual(loads.of('pump'), [1]);
  for (let i = 2; i < 100; i++) add(50 * i, 1);
  assert.equal(loads.of('pump').length, 60);
});

test('a filter finds services by name, text and input, and every word counts', () => {
  const goto = service('nav.goto', 'Moves the robot.', ['target']);
  for (const filter of ['', ' ', 'nav', 'GOTO', 'robot', 'target', 'nav target']) assert.equal(matches(filter, goto), true, filter);
  for (const filter of ['stop', 'nav stop']) assert.equal(matches(filter, goto), false, filter);
});

test('names are grouped by component, in their order', () => {
  assert.deepEqual(['pump.fill', 'pump/level', 'pump'].map(componentOf), ['pump', 'pump', 'pump']);
  const groups = byComponent(['b.x', 'a.y', 'b.z'].map((name) => ({ name })));
  assert.deepEqual([...groups].map(([name, all]) => [name, all.length]), [['b', 2], ['a', 1]]);
});

test('time stamps are the last series; equal values are a line in the middle', () => {
  const series = ['ts.sec', 'ts.nsec', 'pos.x', 'insect'].map((name) => ({ name, values: [1] }));
  assert.deepEqual(ordered({ name: 'p', doc: null, value: '', series }).map((it) => it.name), ['pos.x', 'insect', 'ts.sec', 'ts.nsec']);
  assert.equal(points([1, 3, 2], 100, 20), '0,20 50,0 100,10');
  assert.equal(points([4, 4], 100, 20), '0,10 100,10');
  assert.equal(points([4], 100, 20), '0,10');
});
