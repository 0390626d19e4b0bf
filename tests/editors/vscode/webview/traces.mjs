// Traces for tests, in the form of docs/trace.md: some tasks that share a lock, for as many steps as wanted.
export function trace(steps, { tasks = 6, names = (i) => `c.t${i}` } = {}) {
  const out = {
    format: 1, title: `a run of ${steps} steps`, unit: 'ms', start: 0, end: 0, repeats: null,
    focus: { at: 0, lane: null, step: null },
    lanes: [{ name: 'core 1', kind: 'core', rows: 1 }, { name: 'client user', kind: 'client', rows: 1 }, ...Array.from({ length: tasks }, (_, i) => ({ name: names(i), kind: 'task', rows: 1 })), { name: 'c locks', kind: 'locks', rows: 2 }],
    spans: [], marks: [], arrows: [], steps: [], notes: [],
    rules: { tick: 'The timer of the task has come round.', wait: 'The codel waits.', begin: 'The codel begins.', end: 'The codel ends.' },
    places: [{ uri: 'file:///c.gen', range: { start: { line: 3, character: 2 }, end: { line: 3, character: 9 } } }],
  };
  const locks = out.lanes.length - 1;
  const say = (at, lane, rule, what) => out.steps.push({ at, lane, rule, what, codel: `${what.split(' ')[0]}`, locks: ['`x` of the ids'], place: 0 }) - 1;
  let before;
  for (let job = 0; out.steps.length < steps; job++) {
    const [at, lane] = [job * 5, 2 + (job % tasks)];
    const label = `t${job % tasks}.main`;
    const codel = `c.${label}`;
    out.marks.push({ lane, at, kind: 'tick', step: say(at, lane, 'tick', `${codel} tick`) });
    if (job % 10 === 3) out.arrows.push({ from: 1, to: lane, at, step: out.steps.length - 1 });
    const waits = say(at, lane, 'wait', `${codel} waits for the one before`);
    const by = before === undefined ? [] : [{ name: before.label, lane: before.lane, from: at - 4, to: at + 1, through: ['`x` of the ids'] }];
    out.spans.push({ lane, row: 0, from: at, to: at + 1, kind: 'wait-lock', label, codel, by, step: waits });
    out.spans.push({ lane: locks, row: 1, from: at, to: at + 1, kind: 'wait-lock', label, codel, by, step: waits });
    const begins = say(at + 1, lane, 'begin', `${codel} begins`);
    for (const [of, kind] of [[0, 'run'], [lane, 'run'], [locks, 'hold']]) out.spans.push({ lane: of, row: 0, from: at + 1, to: at + 6, kind, label, codel, step: begins });
    const ends = say(at + 6, lane, 'end', `${codel} ends`);
    out.marks.push({ lane, at: at + 6, kind: 'complete', step: ends });
    before = { label, lane };
    out.end = at + 6;
  }
  const last = out.steps.length - 1;
  out.focus = { at: out.end, lane: out.steps[last].lane, step: last };
  out.marks.push({ lane: out.steps[last].lane, at: out.end, kind: 'miss', step: null });
  return out;
}

export const MACHINE = {
  title: 'c.t0',
  node: 'main',
  svg: '<svg xmlns="http://www.w3.org/2000/svg" width="200" height="60" viewBox="0 0 200 60" role="img" aria-label="c.t0"><style>.shape { fill: none; stroke: currentColor; }</style><g class="node" data-id="main" role="img" aria-label="main"><rect class="shape" x="10" y="10" width="80" height="30"/><text x="20" y="30">main</text></g></svg>',
};
