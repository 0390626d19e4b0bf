// The cause of a failure: the longest wait of the job that is late, and the lanes that have to do with it. No drawing here.
import type { Holder, Span, Trace } from '../../trace/form';
import { time } from '../unit';

export interface Cause {
  /** The lane that is late. */
  lane: number;
  /** The wait; of a job that never waits, the job until the failure. */
  from: number;
  to: number;
  /** One sentence. */
  text: string;
  /** The lanes to show first: the late one, those it waits for, and what else has a part. */
  lanes: number[];
}

const isWait = ({ kind }: Span) => kind === 'wait-lock' || kind === 'wait-core';
const length = ({ from, to }: { from: number; to: number }) => to - from;
const longest = <T extends { from: number; to: number }>(all: readonly T[]) => all.reduce<T | undefined>((most, it) => (most === undefined || length(it) > length(most) ? it : most), undefined);

/** What is waited for: `a core, held by report`. */
function awaited(wait: Span): string {
  const by: Holder | undefined = longest(wait.by ?? []);
  const what = wait.kind === 'wait-core' ? 'a core' : by?.through?.join(' and ') || 'a lock';
  return (by === undefined ? what : `${what}, held by ${by.name}`).replaceAll('`', '');
}

/** The cause of the failure of a run; undefined if no lane is late, or the late one executes nothing. */
export function causeOf(trace: Trace): Cause | undefined {
  const { at, lane } = trace.focus;
  if (lane === null) return undefined;
  // The job begins with the first period or request after the end of the one before.
  const marks = trace.marks.filter((it) => it.lane === lane && it.at < at).sort((a, b) => a.at - b.at);
  const ended = marks.reduce((last, it) => (it.kind === 'complete' ? Math.max(last, it.at) : last), trace.start);
  const begin = marks.find((it) => it.kind !== 'complete' && it.at >= ended)?.at ?? ended;
  const job = trace.spans.filter((it) => it.lane === lane && it.from < at && it.from >= begin && it.to > it.from);
  if (job.length === 0) return undefined;
  const waits = job.filter(isWait);
  const wait = longest(waits);
  const lanes = new Set([lane]);
  const add = (span: Span) => {
    for (const { lane: other } of span.by ?? []) {
      if (other === null || lanes.has(other)) continue;
      lanes.add(other);
      // Who is waited for may wait as well.
      for (const it of trace.spans) if (it.lane === other && isWait(it) && it.from < span.to && it.to > span.from) add(it);
    }
  };
  for (const it of waits) add(it);
  for (const it of trace.arrows) if (it.to === lane && it.at >= ended && it.at <= at) lanes.add(it.from);
  const steps = new Set(waits.map(({ step }) => step));
  for (const [i, { kind }] of trace.lanes.entries()) {
    if (kind === 'core' && waits.some((it) => it.kind === 'wait-core')) lanes.add(i);
    if (kind === 'locks' && trace.spans.some((it) => it.lane === i && isWait(it) && steps.has(it.step))) lanes.add(i);
  }
  if (wait !== undefined) {
    return { lane, from: wait.from, to: wait.to, text: `waits ${time(length(wait), trace.unit)} for ${awaited(wait)}`, lanes: [...lanes] };
  }
  const from = job.reduce((least, it) => Math.min(least, it.from), at);
  return { lane, from, to: at, text: `executes and never waits, for ${time(at - from, trace.unit)}`, lanes: [...lanes] };
}
