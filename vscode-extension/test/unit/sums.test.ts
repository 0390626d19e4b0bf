// The arithmetic of the trace viewer: sums of a range, how busy a run is, the search.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Span, Trace } from '../../src/trace/form';
import { moment } from '../../src/webview/trace/moment';
import { opening, Window } from '../../src/webview/trace/model';
import { busy, hits, nextHit, sums } from '../../src/webview/trace/sums';

const span = (lane: number, from: number, to: number, kind: Span['kind'], by: string[] = []): Span => ({
  lane, row: 0, from, to, kind, label: 't', codel: null, step: 0, by: by.map((name) => ({ name, lane: null, from, to })),
});
const run = (more: Partial<Trace> = {}): Trace => ({
  format: 1, title: 'a run', unit: 'ms', start: 0, end: 20, focus: { at: 20, lane: 2, step: 2 }, repeats: null,
  lanes: [{ name: 'core 1', kind: 'core', rows: 1 }, { name: 'core 2', kind: 'core', rows: 1 }, { name: 'c.t', kind: 'task', rows: 1 }, { name: 'c locks', kind: 'locks', rows: 1 }],
  spans: [span(0, 0, 10, 'run'), span(0, 12, 16, 'run'), span(1, 5, 20, 'run'), span(2, 2, 6, 'wait-lock', ['b', 'a', 'b']), span(2, 10, 18, 'wait-core', ['a']), span(2, 18, 19, 'wait-lock', ['a', 'b']), span(3, 2, 6, 'wait-lock', ['a']), span(2, 0, 2, 'run')],
  marks: [], arrows: [], notes: [], rules: {}, places: [],
  steps: [{ at: 0, lane: 2, rule: 'tick', what: 'the timer' }, { at: 2, lane: 2, rule: 'wait', what: 'waits for B' }, { at: 20, lane: 0, rule: 'end', what: 'ends', codel: 'c.b' }],
  ...more,
});

test('a range sums what is inside it: cores, and waits by cause, the longest first', () => {
  assert.deepEqual(sums(run(), 4, 14), {
    from: 4, to: 14,
    loads: [{ name: 'core 1', busy: 8, share: 0.8 }, { name: 'core 2', busy: 9, share: 0.9 }],
    waits: [{ cause: 'core held by a', time: 4, count: 1 }, { cause: 'lock held by a, b', time: 2, count: 1 }],
  });
});

test('the whole run, in either order and beyond its ends, counts each wait once', () => {
  const all = sums(run(), 99, -5);
  assert.deepEqual([all.from, all.to], [0, 20]);
  assert.deepEqual(all.waits, [{ cause: 'core held by a', time: 8, count: 1 }, { cause: 'lock held by a, b', time: 5, count: 2 }]);
  assert.deepEqual(all.loads.map((it) => it.share), [0.7, 0.75]);
});

test('without cores tasks are summed, and a range of no length has no load', () => {
  const lanes = run().lanes.map((it) => (it.kind === 'core' ? { ...it, kind: 'client' as const } : it));
  assert.deepEqual(sums(run({ lanes }), 0, 4).loads, [{ name: 'c.t', busy: 2, share: 0.5 }]);
  assert.deepEqual(sums(run(), 7, 7), { from: 7, to: 7, loads: [{ name: 'core 1', busy: 0, share: 0 }, { name: 'core 2', busy: 0, share: 0 }], waits: [] });
});

test('the overview has the share of busy cores in each part', () => {
  assert.deepEqual(busy(run(), 4), [0.5, 1, 0.5 + 0.3, 0.5 + 0.1]);
  assert.deepEqual(busy(run({ end: 0 }), 2), [0, 0]);
});

test('the search finds steps by what happens, codel, rule and lane, and goes round', () => {
  assert.deepEqual(hits(run(), ' b '), [1, 2]);
  assert.deepEqual(hits(run(), 'C.T'), [0, 1]);
  assert.deepEqual(hits(run(), ''), []);
  assert.deepEqual([nextHit([1, 5], 1, 1), nextHit([1, 5], 5, 1), nextHit([1, 5], 1, -1), nextHit([], 0, 1)], [5, 1, 5, undefined]);
});

test('what is shown at first, and after any move, is not half empty', () => {
  const empty = (it: Window) => (Math.max(0, -it.from) + Math.max(0, it.to - 20)) / it.length;
  const first = opening(run());
  assert.ok(first.from <= 20 && first.to >= 20 && empty(first) <= 0.2, `${first.from} ${first.to}`);
  first.zoom(4, 20);
  first.pan(1000);
  assert.ok(empty(first) <= 0.2 && first.to >= 20);
  first.zoom(1e-3, 20);
  assert.ok(empty(first) <= 0.2);
});

test('at a step, what lasts in each lane and since when; what begins with a later step does not yet', () => {
  const marks = [{ lane: 2, at: 0, kind: 'tick' as const, step: 0 }, { lane: 2, at: 2, kind: 'tick' as const, step: 2 }];
  const spans = [span(0, 0, 10, 'run'), span(2, 2, 6, 'wait-lock'), { ...span(1, 2, 3, 'run'), step: 2 }, span(3, 2, 6, 'wait-lock'), span(2, 0, 2, 'run')];
  const found = moment(run({ spans, marks }), 1);
  assert.deepEqual(found.map((it) => [it.lane, it.spans.map(({ span, since }) => [span.kind, since]), it.period]), [
    [0, [['run', 2]], undefined],
    [2, [['wait-lock', 0]], 2],
  ]);
  assert.deepEqual(moment(run(), 99), []);
  // Until the step that ends it, a span of this very time lasts; what the end of the run cuts off, too.
  const ends = [{ at: 0, lane: 2, rule: 'begin', what: 'a begins', codel: 'a' }, { at: 4, lane: 0, rule: 'tick', what: 'another' }, { at: 4, lane: 2, rule: 'end', what: 'a ends', codel: 'a' }];
  const one = { ...span(2, 0, 4, 'run'), codel: 'a' };
  const lasting = (step: number, steps = ends) => moment(run({ spans: [one], steps }), step).length;
  assert.deepEqual([lasting(0), lasting(1), lasting(2), lasting(1, ends.slice(0, 2))], [1, 1, 0, 1]);
});
