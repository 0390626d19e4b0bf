// What a file must be to be shown as a trace.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parse, type Trace } from '../../src/trace/form';

const range = { start: { line: 1, character: 2 }, end: { line: 1, character: 5 } };
const GOOD: Trace = {
  format: 1,
  title: 'a run',
  unit: 'ms',
  start: 0,
  end: 5,
  focus: { at: 5, lane: 0, step: 0 },
  repeats: null,
  lanes: [{ name: 'c.t', kind: 'task', rows: 1 }],
  spans: [{ lane: 0, row: 0, from: 0, to: 5, kind: 'wait-lock', label: 't.main', codel: 'c.t.main', by: [{ name: 'u.main', lane: null, from: 0, to: 5 }], step: 0 }],
  marks: [{ lane: 0, at: 5, kind: 'miss', step: null }],
  arrows: [],
  steps: [{ at: 0, lane: 0, rule: 'wait', what: 'waits', locks: ['`x`'], place: 0 }],
  rules: { wait: 'The codel waits.' },
  places: [{ uri: 'file:///c.gen', range }],
  notes: [],
};
const changed = (change: (it: any) => void) => {
  const it = structuredClone(GOOD);
  change(it);
  return JSON.stringify(it);
};

test('a trace is read as it is', () => {
  assert.deepEqual(parse(JSON.stringify(GOOD)), GOOD);
});

test('what is no trace is refused, with what is wrong', () => {
  assert.throws(() => parse('[1, 2'), /JSON/);
  assert.throws(() => parse('null'), /it is no object/);
  assert.throws(() => parse(changed((it) => (it.format = 2))), /its format is 2/);
  assert.throws(() => parse(changed((it) => delete it.spans)), /`spans` is no list/);
  assert.throws(() => parse(changed((it) => (it.end = -1))), /no times in this order/);
  const entries: [string, (it: any) => void][] = [
    ['spans', (it) => (it.spans[0].lane = 1)],
    ['spans', (it) => (it.spans[0].row = 1)],
    ['spans', (it) => (it.spans[0].from = 'x')],
    ['spans', (it) => (it.spans[0].by[0].lane = 7)],
    ['marks', (it) => (it.marks[0].step = 9)],
    ['steps', (it) => (it.steps[0].place = 3)],
    ['steps', (it) => (it.steps[0].locks = 'x')],
    ['lanes', (it) => (it.lanes[0].rows = 1e9)],
    ['focus', (it) => (it.focus.step = -1)],
  ];
  for (const [list, change] of entries) assert.throws(() => parse(changed(change)), new RegExp(`\`${list}\``), list);
});

test('places of a file lead to files, and to nothing else', () => {
  for (const uri of ['command:workbench.action.quit', 'https://page.test/', 7]) {
    assert.deepEqual(parse(changed((it) => (it.places[0].uri = uri))).places, [null]);
  }
});
