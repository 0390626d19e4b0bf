// Parts of the page that tell of a trace in words: pure functions from a trace to elements.
import type { Span, Trace } from '../../trace/form';
import { node, rich } from '../element';
import { time } from '../unit';
import { words } from './draw';
import type { At } from './moment';
import { sums } from './sums';

/** A list of names with their values. */
function list(rows: [string, string][]): HTMLElement {
  return node('dl', rows.flatMap(([name, value]) => [node('dt', [name]), node('dd', rich(value))]));
}

/** The sums of a part of time. */
export function told(trace: Trace, one: number, other: number): Node[] {
  const { from, to, loads, waits } = sums(trace, one, other);
  const apart = Math.max((to - from) / 1000, 1e-6);
  const length = (it: number) => time(it, trace.unit, apart);
  return [
    node('h2', [`${length(to - from)} selected`]),
    node('p', [`${length(from)} to ${length(to)}. Escape ends the selection.`], 'what-rule'),
    node('h3', ['Load']),
    list(loads.map((it) => [it.name, `${(100 * it.share).toFixed(1)} %, ${length(it.busy)}`])),
    node('h3', ['Waits']),
    waits.length === 0 ? node('p', ['none']) : list(waits.map((it) => [it.cause, `${length(it.time)}${it.count > 1 ? ` in ${it.count}` : ''}`])),
  ];
}

/** What each lane does at a moment, and since when. */
export function lanesAt(trace: Trace, all: readonly At[]): Node[] {
  const since = (it: number) => time(it, trace.unit);
  const rows = all.map(({ lane, spans, period }): [string, string] => {
    const does = spans.map(({ span, since: length }) => length > 0 ? `${words(span)} (for ${since(length)})` : words(span));
    if (period !== undefined) does.push(period > 0 ? `period began ${since(period)} ago` : 'period begins');
    return [trace.lanes[lane]?.name ?? '', does.join('; ')];
  });
  return rows.length === 0 ? [] : [node('h3', ['After this step']), list(rows)];
}

export function interval({ from, to }: { from: number; to: number }, { unit }: Trace): string {
  return `${time(to - from, unit)}, ${time(from, unit)} to ${time(to, unit)}`;
}

export function holder(by: NonNullable<Span['by']>[number], trace: Trace): string {
  if (by.ahead === true) return `\`${by.name}\` ahead in the queue`;
  const through = by.through === undefined || by.through.length === 0 ? '' : `, through ${by.through.join(' and ')}`;
  const who = by.lane === null ? '' : ` of ${trace.lanes[by.lane]?.name ?? ''}`;
  return `\`${by.name}\`${who} (${time(by.from, trace.unit)} to ${time(by.to, trace.unit)}${through})`;
}
