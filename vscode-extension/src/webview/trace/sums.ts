// Sums of a part of a run: the load of each core, waits by their cause, and how busy the run is at each moment. No drawing.
import type { Lane, Span, Trace } from '../../trace/form';

/** A lane that executes, and the time of it in which something does. */
export interface Load {
  name: string;
  busy: number;
  /** Of the range, from 0 to 1. */
  share: number;
}

/** What is waited for, and how long in all. */
export interface Waits {
  cause: string;
  time: number;
  count: number;
}

export interface Sums {
  from: number;
  to: number;
  loads: Load[];
  /** The longest first. */
  waits: Waits[];
}

/** The time of a span between two times. */
function inside(span: Span, from: number, to: number): number {
  return Math.max(0, Math.min(span.to, to) - Math.max(span.from, from));
}

/** The kind of lane whose spans are what executes: cores, or tasks where cores are not numbered. */
function executing(lanes: readonly Lane[]): Lane['kind'] {
  return lanes.some((it) => it.kind === 'core') ? 'core' : 'task';
}

function cause(span: Span): string {
  const names = [...new Set((span.by ?? []).map((it) => it.name))].sort().join(', ');
  const what = span.kind === 'wait-core' ? 'core' : 'lock';
  return names === '' ? what : `${what} held by ${names}`;
}

/** Sums between two times, in either order. */
export function sums(trace: Trace, one: number, other: number): Sums {
  const [from, to] = [Math.max(Math.min(one, other), trace.start), Math.min(Math.max(one, other), trace.end)];
  const kind = executing(trace.lanes);
  const loads = new Map<number, number>();
  for (const [lane, it] of trace.lanes.entries()) if (it.kind === kind) loads.set(lane, 0);
  const waits = new Map<string, Waits>();
  for (const span of trace.spans) {
    const time = inside(span, from, to);
    if (time <= 0) continue;
    const busy = loads.get(span.lane);
    if (span.kind === 'run' && busy !== undefined) loads.set(span.lane, busy + time);
    // The lanes of locks show the waits of tasks once more.
    if ((span.kind === 'wait-lock' || span.kind === 'wait-core') && trace.lanes[span.lane]?.kind !== 'locks') {
      const of = cause(span);
      const known = waits.get(of) ?? { cause: of, time: 0, count: 0 };
      waits.set(of, { cause: of, time: known.time + time, count: known.count + 1 });
    }
  }
  const length = to - from;
  return {
    from,
    to: Math.max(from, to),
    loads: [...loads].map(([lane, busy]) => ({ name: trace.lanes[lane]?.name ?? '', busy, share: length > 0 ? busy / length : 0 })),
    waits: [...waits.values()].sort((a, b) => b.time - a.time || a.cause.localeCompare(b.cause)),
  };
}

/** How busy the run is in each of so many equal parts: the share of lanes that execute, from 0 to 1. */
export function busy(trace: Trace, parts: number): number[] {
  const out = new Array<number>(parts).fill(0);
  const kind = executing(trace.lanes);
  const lanes = trace.lanes.filter((it) => it.kind === kind).length;
  const part = (trace.end - trace.start) / parts;
  if (part <= 0 || lanes === 0) return out;
  for (const span of trace.spans) {
    if (span.kind !== 'run' || trace.lanes[span.lane]?.kind !== kind) continue;
    const first = Math.max(0, Math.floor((span.from - trace.start) / part));
    const last = Math.min(parts - 1, Math.floor((span.to - trace.start) / part));
    for (let i = first; i <= last; i++) out[i] = (out[i] ?? 0) + inside(span, trace.start + i * part, trace.start + (i + 1) * part);
  }
  return out.map((it) => Math.min(1, it / (part * lanes)));
}

/** Steps in which a text is: in what happens, the codel, or the lane. In order. */
export function hits(trace: Trace, text: string): number[] {
  const wanted = text.trim().toLowerCase();
  if (wanted === '') return [];
  const has = (it: string | undefined) => it?.toLowerCase().includes(wanted) === true;
  return trace.steps.flatMap((step, i) => (has(step.what) || has(step.codel) || has(step.rule) || has(trace.lanes[step.lane]?.name) ? [i] : []));
}

/** The hit after a step, or before it; the search goes on at the other end. */
export function nextHit(all: readonly number[], step: number, by: 1 | -1): number | undefined {
  const next = by === 1 ? all.find((it) => it > step) : all.filter((it) => it < step).at(-1);
  return next ?? all.at(by === 1 ? 0 : -1);
}
