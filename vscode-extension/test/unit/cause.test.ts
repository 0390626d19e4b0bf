// The cause of a failure in a run: the longest wait of the late job, and the lanes that have to do with it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Holder, Span, Trace } from '../../src/trace/form';
import { causeOf } from '../../src/webview/trace/cause';
import { Model, opening } from '../../src/webview/trace/model';

const holder = (name: string, lane: number | null, from: number, to: number, through: string[] = []): Holder => ({ name, lane, from, to, through });
const span = (lane: number, from: number, to: number, kind: Span['kind'], by: Holder[] = [], step = 0): Span => ({ lane, row: 0, from, to, kind, label: 't', codel: null, step, by });
/** Lane 4 is late at 30, in the job that begins after 10. */
const run = (spans: Span[], more: Partial<Trace> = {}): Trace => ({
  format: 1, title: 'a run', unit: 'ms', start: 0, end: 30, focus: { at: 30, lane: 4, step: 1 }, repeats: null,
  lanes: ['core 1', 'client user', 'c.report', 'c.other', 'c.late', 'c locks'].map((name, i) => ({ name, kind: (['core', 'client', 'task', 'task', 'task', 'locks'] as const)[i] ?? 'task', rows: 1 })),
  spans, marks: [{ lane: 4, at: 10, kind: 'complete', step: 0 }, { lane: 3, at: 25, kind: 'complete', step: 0 }], arrows: [], notes: [], rules: {}, places: [],
  steps: [{ at: 0, lane: 3, rule: 'tick', what: 'tick' }, { at: 30, lane: 4, rule: 'miss', what: 'miss' }],
  ...more,
});
const core = [span(4, 2, 9, 'wait-core', [holder('other', 3, 2, 9)]), span(4, 20, 26, 'wait-core', [holder('report', 2, 20, 25), holder('other', 3, 25, 26)], 1), span(4, 26, 30, 'run')];

test('the longest wait of the late job, not of an earlier one, and who is waited for longest', () => {
  const cause = causeOf(run(core));
  assert.equal(cause?.text, 'waits 6 ms for a core, held by report');
  assert.deepEqual([cause?.from, cause?.to], [20, 26]);
  assert.deepEqual(cause?.lanes, [4, 2, 3, 0], 'the late one, those it waits for, the core');
  const two = run(core);
  two.lanes.push({ name: 'core 2', kind: 'core', rows: 1 });
  assert.equal(causeOf({ ...two, unit: 'us' })?.text, 'waits 6 µs for a core, held by report');
});

test('a wait for a lock says what is shared; who is waited for may wait too', () => {
  const wait = span(4, 12, 16, 'wait-lock', [holder('report.main', 2, 12, 16, ['`x` of the ids'])], 1);
  const spans = [wait, { ...wait, lane: 5 }, span(2, 13, 15, 'wait-lock', [holder('other.main', 3, 13, 15)], 1), span(4, 16, 30, 'run')];
  const cause = causeOf(run(spans, { arrows: [{ from: 1, to: 4, at: 11, step: 0 }] }));
  assert.equal(cause?.text, 'waits 4 ms for x of the ids, held by report.main');
  assert.deepEqual(cause?.lanes, [4, 2, 3, 1, 5], 'with the client that sends the request, and the locks, without the core');
});

test('a job that never waits is its own cause; a run without a late lane has none', () => {
  assert.deepEqual(causeOf(run([span(4, 12, 30, 'run')])), { lane: 4, from: 12, to: 30, text: 'executes and never waits, for 18 ms', lanes: [4] });
  assert.equal(causeOf(run(core, { focus: { at: 30, lane: null, step: null } })), undefined);
  assert.equal(causeOf(run(core, { focus: { at: 30, lane: 5, step: null } })), undefined, 'a lane that executes nothing');
});

test('the guilty wait is in the first picture, however many steps come after it', () => {
  const steps = Array.from({ length: 100 }, () => ({ at: 29.9, lane: 3, rule: 'tick', what: 'tick' }));
  const it = run(core, { steps, focus: { at: 30, lane: 4, step: 99 } });
  assert.ok(opening(it).from <= 20);
});

test('folded lanes are on one line below the first ones', () => {
  const model = new Model(run(core), true);
  assert.deepEqual(model.open, [4, 2, 3, 0]);
  assert.deepEqual(model.box(1), model.fold);
  assert.deepEqual(model.box(5), model.fold);
  assert.equal(model.height, model.fold?.bottom);
  assert.ok(model.rows.every((row) => model.open.includes(row.lane)));
  assert.deepEqual(new Model(run(core)).order, [4, 2, 3, 0, 1, 5]);
});
