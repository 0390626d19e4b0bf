// What each lane does at a step of a run. No drawing.
import type { Span, Trace } from '../../trace/form';

/** A lane at a moment. */
export interface At {
  lane: number;
  /** What lasts there, with the time since it began. */
  spans: { span: Span; since: number }[];
  /** Time since the period of a task began. */
  period?: number;
}

/** The lanes in which something lasts just after a step, in their order; those of locks repeat what the others say. */
export function moment(trace: Trace, step: number): At[] {
  const at = trace.steps[step]?.at;
  if (at === undefined) return [];
  const all = trace.lanes.map((_, lane): At => ({ lane, spans: [] }));
  // A span that ends at this very time lasts until the step that ends it: another one of its lane, after its first.
  const ended = ({ lane, step: begin, codel, kind }: Span) =>
    trace.steps.some((other, i) => begin < i && i <= step && other.at === at && other.lane === lane && (kind !== 'run' || other.codel === (codel ?? undefined)));
  for (const span of trace.spans) {
    const lasts = span.step <= step && span.from <= at && (at < span.to || (at === span.to && span.from < at && trace.lanes[span.lane]?.kind !== 'core' && !ended(span)));
    if (lasts) all[span.lane]?.spans.push({ span, since: at - span.from });
  }
  for (const mark of trace.marks) {
    const of = all[mark.lane];
    if (mark.kind !== 'tick' || of === undefined || mark.at > at || (mark.step ?? -1) > step) continue;
    of.period = Math.min(of.period ?? Infinity, at - mark.at);
  }
  return all.filter(({ lane, spans, period }) => trace.lanes[lane]?.kind !== 'locks' && (spans.length > 0 || period !== undefined));
}
