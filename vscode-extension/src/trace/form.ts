// The form of a trace (docs/trace.md): one run, a counterexample or a recorded one. Lanes, steps and places are named by
// their index; times are in `unit`.
import type { Place } from '../place';

export const FORMAT = 1;

export type LaneKind = 'core' | 'client' | 'control' | 'task' | 'locks';
export type SpanKind = 'run' | 'wait-lock' | 'wait-core' | 'hold';
export type MarkKind = 'tick' | 'complete' | 'request' | 'miss';

export interface Lane {
  name: string;
  kind: LaneKind;
  /** How many spans lie above each other. */
  rows: number;
}

export interface Holder {
  name: string;
  lane: number | null;
  from: number;
  to: number;
  /** What both use, in words. */
  through?: string[];
  /** It waited as well, ahead in the queue. */
  ahead?: boolean;
}

export interface Span {
  lane: number;
  row: number;
  from: number;
  to: number;
  kind: SpanKind;
  label: string;
  codel: string | null;
  by?: Holder[];
  step: number;
}

export interface Mark {
  lane: number;
  at: number;
  kind: MarkKind;
  step: number | null;
}

export interface Arrow {
  from: number;
  to: number;
  at: number;
  step: number;
}

export interface Step {
  at: number;
  lane: number;
  /** A key of `rules`. */
  rule: string;
  what: string;
  codel?: string;
  locks?: string[];
  place?: number;
}

export interface Trace {
  format: number;
  title: string;
  unit: string;
  start: number;
  end: number;
  focus: { at: number; lane: number | null; step: number | null; cause?: string };
  /** From here on it goes on for ever. */
  repeats: number | null;
  lanes: Lane[];
  spans: Span[];
  marks: Mark[];
  arrows: Arrow[];
  steps: Step[];
  /** What each rule does, in a sentence. */
  rules: Record<string, string>;
  places: (Place | null)[];
  notes: string[];
}

const LISTS = ['lanes', 'spans', 'marks', 'arrows', 'steps', 'places', 'notes'] as const;

/** A trace from a file; throws with what is wrong. What refers to nothing is refused: nothing is drawn of a broken file. */
export function parse(text: string): Trace {
  const it = JSON.parse(text) as Partial<Trace> | null;
  const wrong = (what: string) => new Error(`It is no trace: ${what}. A trace is written by \`dotgen run --trace\` and \`dotgen verify --trace\`.`);
  if (typeof it !== 'object' || it === null) throw wrong('it is no object');
  if (it.format !== FORMAT) throw wrong(`its format is ${JSON.stringify(it.format)}, and this version reads ${FORMAT}`);
  const list = LISTS.find((name) => !Array.isArray(it[name]));
  if (list !== undefined) throw wrong(`\`${list}\` is no list`);
  const trace = it as Trace;
  const number = (value: unknown): value is number => typeof value === 'number' && Number.isFinite(value);
  if (!number(trace.start) || !number(trace.end) || trace.end < trace.start) throw wrong('`start` and `end` are no times in this order');
  if (typeof trace.focus !== 'object' || !number(trace.focus?.at)) throw wrong('`focus` has no time');
  const { length: lanes } = trace.lanes;
  const { length: steps } = trace.steps;
  const index = (value: unknown, of: number) => number(value) && Number.isInteger(value) && value >= 0 && value < of;
  const maybe = (value: unknown, of: number) => value === null || value === undefined || index(value, of);
  const check = (name: string, all: boolean) => {
    if (!all) throw wrong(`an entry of \`${name}\` names what is not there, or has no time`);
  };
  check('lanes', trace.lanes.every((lane) => number(lane.rows) && lane.rows >= 1 && lane.rows < 1000 && typeof lane.name === 'string'));
  check('spans', trace.spans.every((span) => index(span.lane, lanes) && index(span.row, trace.lanes[span.lane]?.rows ?? 0) && index(span.step, steps) && number(span.from) && number(span.to)));
  check('marks', trace.marks.every((mark) => index(mark.lane, lanes) && maybe(mark.step, steps) && number(mark.at)));
  check('arrows', trace.arrows.every((arrow) => index(arrow.from, lanes) && index(arrow.to, lanes) && index(arrow.step, steps) && number(arrow.at)));
  check('steps', trace.steps.every((step) => index(step.lane, lanes) && maybe(step.place, trace.places.length) && number(step.at) && typeof step.what === 'string'));
  const texts = (value: unknown) => value === undefined || (Array.isArray(value) && value.every((it) => typeof it === 'string'));
  check('steps', trace.steps.every((step) => texts(step.locks) && typeof step.rule === 'string'));
  const holder = (it: Holder) => typeof it?.name === 'string' && maybe(it.lane, lanes) && number(it.from) && number(it.to) && texts(it.through);
  check('spans', trace.spans.every((span) => typeof span.label === 'string' && (span.by === undefined || (Array.isArray(span.by) && span.by.every(holder)))));
  check('notes', texts(trace.notes) === true);
  check('focus', maybe(trace.focus.lane, lanes) && maybe(trace.focus.step, steps));
  // A file may lead to files, and to nothing else.
  const places = trace.places.map((it) => (typeof it?.uri === 'string' && it.uri.startsWith('file:') && [it.range?.start, it.range?.end].every((at) => number(at?.line) && number(at?.character)) ? it : null));
  return { ...trace, places, title: String(trace.title), unit: String(trace.unit), rules: trace.rules ?? {}, repeats: trace.repeats ?? null };
}
