// A trace made ready to be drawn and walked, and the window of time that is shown. No drawing here.
import type { Arrow, Lane, Mark, Span, Trace } from '../../trace/form';
import { causeOf, type Cause } from './cause';

/** The first of some in order of which `is` holds; their number if it holds of none. */
export function first<T>(all: readonly T[], is: (it: T) => boolean): number {
  let [low, high] = [0, all.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (is(all[middle] as T)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** One row of a lane. Its spans are in order and do not overlap. */
export interface Row {
  lane: number;
  /** Of the first of the lane. */
  top: number;
  spans: Span[];
}

export const ROW = 18;
const PADDING = 7;
/** Height of the line of folded lanes. */
const FOLD = 24;

/** Where a lane is drawn. A folded lane is where the line of the folded ones is. */
export interface Box {
  top: number;
  /** Lower edge of its spans. */
  end: number;
  bottom: number;
}

export class Model {
  readonly rows: Row[] = [];
  /** The cause of the failure has a row of its own below the spans of its lane. */
  readonly cause: Cause | undefined;
  /** All lanes from top to bottom. The first ones have to do with the failure. */
  readonly order: number[];
  /** Number of the first ones, which are never folded. */
  readonly kept: number;
  /** The line above the other ones, if there are any. */
  readonly fold: Box | undefined;
  readonly height: number;
  readonly marks: Mark[][];
  readonly arrows: Arrow[];
  /** Steps of each lane, ascending. */
  readonly ofLane: number[][];
  private readonly boxes: Box[] = [];
  /** Span that begins with a step, preferably where the step happened. */
  private readonly spanOfStep = new Map<number, Span>();

  constructor(
    readonly trace: Trace,
    readonly folded = false,
  ) {
    this.cause = causeOf(trace);
    const all = [...trace.lanes.keys()];
    const first = this.cause?.lanes ?? all;
    this.kept = first.length;
    this.order = [...first, ...all.filter((it) => !first.includes(it))];
    let top = 0;
    const firstRow: number[] = [];
    for (const [i, lane] of this.order.entries()) {
      if (i === this.kept) {
        this.fold = { top, end: top + FOLD, bottom: top + FOLD };
        top += FOLD;
      }
      if (folded && this.fold !== undefined) {
        this.boxes[lane] = this.fold;
        continue;
      }
      firstRow[lane] = this.rows.length;
      const { rows } = trace.lanes[lane] as Lane;
      for (let row = 0; row < rows; row++) this.rows.push({ lane, top: top + PADDING + row * ROW, spans: [] });
      const end = top + rows * ROW + 2 * PADDING;
      const bottom = end + (lane === this.cause?.lane ? ROW : 0);
      this.boxes[lane] = { top, end, bottom };
      top = bottom;
    }
    this.height = top;
    for (const span of trace.spans) {
      const row = firstRow[span.lane];
      if (row !== undefined) this.rows[row + span.row]?.spans.push(span);
      const known = this.spanOfStep.get(span.step);
      const own = trace.steps[span.step]?.lane;
      if (known === undefined || (known.lane !== own && span.lane === own)) this.spanOfStep.set(span.step, span);
    }
    const byTime = (a: { at: number }, b: { at: number }) => a.at - b.at;
    for (const row of this.rows) row.spans.sort((a, b) => a.from - b.from || a.to - b.to);
    this.marks = trace.lanes.map(() => []);
    for (const mark of trace.marks) this.marks[mark.lane]?.push(mark);
    for (const marks of this.marks) marks.sort(byTime);
    this.arrows = [...trace.arrows].sort(byTime);
    this.ofLane = trace.lanes.map(() => []);
    for (const [i, step] of trace.steps.entries()) this.ofLane[step.lane]?.push(i);
  }

  box(lane: number): Box {
    return this.boxes[lane] ?? { top: 0, end: 0, bottom: 0 };
  }

  /** Lanes that are drawn, from top to bottom. */
  get open(): number[] {
    return this.folded ? this.order.slice(0, this.kept) : this.order;
  }

  middle(lane: number): number {
    const { top, end } = this.box(lane);
    return (top + end) / 2;
  }

  /** What lasts from a step on, or is told by it. */
  span(step: number): Span | undefined {
    return this.spanOfStep.get(step);
  }

  /** The spans of a row between two times. */
  *within({ spans }: Row, from: number, to: number): Iterable<Span> {
    for (let i = first(spans, (it) => it.to >= from); i < spans.length; i++) {
      const span = spans[i] as Span;
      if (span.from > to) return;
      yield span;
    }
  }

  /** The span at a time and a height; a little beside counts, since some last no time. */
  at(time: number, y: number, slack: number): Span | undefined {
    const row = this.rows.find((it) => y >= it.top && y < it.top + ROW);
    if (row === undefined) return undefined;
    const near = [...this.within(row, time - slack, time + slack)];
    const distance = (it: Span) => Math.max(it.from - time, time - it.to, 0);
    return near.sort((a, b) => distance(a) - distance(b) || a.to - a.from - (b.to - b.from))[0];
  }

  /** The mark there, if there is one. */
  markAt(time: number, y: number, slack: number): Mark | undefined {
    const lane = this.open.find((it) => y >= this.box(it).top && y < this.box(it).bottom);
    const marks = lane === undefined ? [] : (this.marks[lane] ?? []);
    const near: Mark[] = [];
    for (let i = first(marks, (it) => it.at >= time - slack); i < marks.length; i++) {
      const mark = marks[i] as Mark;
      if (mark.at > time + slack) break;
      near.push(mark);
    }
    return near.sort((a, b) => Math.abs(a.at - time) - Math.abs(b.at - time))[0];
  }

  /** The step after or before one in the same lane. */
  along(step: number, by: 1 | -1): number {
    const all = this.ofLane[this.trace.steps[step]?.lane ?? 0] ?? [];
    return all[all.indexOf(step) + by] ?? step;
  }
}

/** Share of the picture that is beside the run at either end, at most. */
const BESIDE = 0.1;
/** The longest picture, of a whole run. */
const WIDEST = 1 / (1 - 2 * BESIDE);

/** The part of time that is shown. */
export class Window {
  constructor(
    private readonly trace: Trace,
    public from: number,
    public to: number,
  ) {}

  get length(): number {
    return this.to - this.from;
  }

  /** Zooms; `at`, a time, stays where it is. */
  zoom(factor: number, at: number): void {
    const whole = Math.max(this.trace.end - this.trace.start, 1e-6);
    const length = Math.min(Math.max(this.length / factor, whole / 1e6), whole * WIDEST);
    const share = (at - this.from) / this.length;
    this.from = at - share * length;
    this.to = this.from + length;
    this.keep();
  }

  pan(by: number): void {
    this.from += by;
    this.to += by;
    this.keep();
  }

  centre(at: number): void {
    this.pan(at - (this.from + this.to) / 2);
  }

  /** Moves no further than needed for a time to be seen, with some room. */
  reveal(at: number): void {
    const room = this.length * 0.08;
    if (at < this.from + room || at > this.to - room) this.centre(at);
  }

  fit(): void {
    const room = Math.max(this.trace.end - this.trace.start, 1e-6) * 0.03;
    this.from = this.trace.start - room;
    this.to = this.trace.end + room;
  }

  /** Little beside the run is in sight: a tenth of what is shown at either end. */
  keep(): void {
    const { start, end } = this.trace;
    const room = this.length * BESIDE;
    const [least, most] = [start - room, end + room - this.length];
    const from = most < least ? (start + end - this.length) / 2 : Math.min(Math.max(this.from, least), most);
    this.to += from - this.from;
    this.from = from;
  }
}

/** Steps before the one that is looked at first that are to be seen with it. */
const BEFORE = 30;

/** The window at the beginning: what is looked at first is in its middle, unless half of the picture were empty then. */
export function opening(trace: Trace): Window {
  const { at, step } = trace.focus;
  const before = trace.steps[Math.max(0, (step ?? trace.steps.length - 1) - BEFORE)]?.at ?? trace.start;
  const earliest = Math.min(before, causeOf(trace)?.from ?? before);
  const whole = Math.max(trace.end - trace.start, 1e-6);
  const half = Math.min(Math.max((at - earliest) * 0.6, whole / 4000, 1e-6), (whole * WIDEST) / 2);
  const it = new Window(trace, at - half, at + half);
  it.keep();
  return it;
}

/** A distance between the lines of a scale: 1, 2 or 5 with zeros, at least as long as asked for. */
export function stride(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((it) => it * power).find((it) => it >= least * 0.999) ?? 10 * power;
}
