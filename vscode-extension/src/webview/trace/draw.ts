// Draws what is in sight, and no more than the screen can show: of what would lie on one pixel, one thing.
import type { MarkKind, Span, SpanKind } from '../../trace/form';
import type { Cause } from './cause';
import { first, ROW, stride, type Box, type Model, type Window } from './model';
import { time } from '../unit';

export const RULER = 24;

/** From the theme of the editor. */
export interface Colours {
  text: string;
  faint: string;
  ground: string;
  line: string;
  select: string;
  miss: string;
  run: string;
  lock: string;
  core: string;
  hold: string;
  request: string;
  contrast: boolean;
}

export function colours(): Colours {
  const style = getComputedStyle(document.body);
  const colour = (...names: string[]) => names.map((it) => style.getPropertyValue(`--vscode-${it}`).trim()).find((it) => it !== '') ?? style.color;
  return {
    text: colour('editor-foreground', 'foreground'),
    faint: colour('descriptionForeground', 'foreground'),
    ground: colour('panel-background', 'editor-background'),
    line: colour('contrastBorder', 'editorIndentGuide-background1', 'panel-border'),
    select: colour('focusBorder'),
    miss: colour('editorError-foreground', 'errorForeground', 'charts-red'),
    run: colour('charts-blue', 'textLink-foreground'),
    lock: colour('charts-orange', 'editorWarning-foreground'),
    core: colour('charts-yellow', 'descriptionForeground'),
    hold: colour('charts-purple', 'textLink-foreground'),
    request: colour('charts-green', 'textLink-foreground'),
    contrast: document.body.classList.contains('vscode-high-contrast') || document.body.classList.contains('vscode-high-contrast-light'),
  };
}

export interface Scene {
  model: Model;
  window: Window;
  /** What of the lanes is above the view. */
  scroll: number;
  width: number;
  height: number;
  step: number;
  hovered: Span | undefined;
  /** The part of time that is summed. */
  range: readonly [number, number] | undefined;
  font: string;
}

/** What one picture took: tests hold this to what the screen can show. */
export interface Work {
  spans: number;
  marks: number;
  arrows: number;
  /** The text of the cause and its left and right edge, if its wait is in sight. */
  cause?: { text: string; left: number; right: number } | undefined;
}

/** Spans of less than so many pixels have no border and no name. */
const THIN = 4;
/** Pixels between marks of a kind. */
const APART = 6;

const PATTERNS: Partial<Record<SpanKind, number>> = { 'wait-lock': 6, 'wait-core': 3 };

export class Painter {
  private readonly patterns = new Map<string, CanvasPattern | null>();
  private readonly widths = new Map<string, number>();
  private font = '';

  constructor(
    private readonly context: CanvasRenderingContext2D,
    private theme: Colours,
  ) {}

  get colours(): Colours {
    return this.theme;
  }

  set colours(theme: Colours) {
    this.theme = theme;
    this.patterns.clear();
  }

  draw(scene: Scene): Work {
    const { context: c, theme } = this;
    const { model, window, width, height, scroll } = scene;
    const { trace } = model;
    const work: Work = { spans: 0, marks: 0, arrows: 0 };
    if (this.font !== scene.font) {
      this.font = scene.font;
      this.widths.clear();
    }
    const scale = width / window.length;
    const x = (at: number) => (at - window.from) * scale;
    c.clearRect(0, 0, width, height);
    c.font = scene.font;
    c.textBaseline = 'middle';
    c.save();
    c.beginPath();
    c.rect(0, RULER, width, height - RULER);
    c.clip();
    c.translate(0, RULER - scroll);
    this.lanes(scene, x);
    const visible = { from: scroll, to: scroll + height - RULER };
    const current = model.span(scene.step);
    const shown = scene.hovered ?? current;
    for (const row of model.rows) {
      if (row.top + ROW < visible.from || row.top > visible.to) continue;
      let filled = -1;
      // Thin ones of a kind beside each other are one.
      let thin: { kind: SpanKind; left: number; right: number } | undefined;
      const flush = () => {
        if (thin === undefined) return;
        c.fillStyle = this.colour(thin.kind);
        c.fillRect(thin.left, row.top + 1, thin.right - thin.left, ROW - 2);
        thin = undefined;
        work.spans++;
      };
      const { spans } = row;
      let i = first(spans, (it) => it.to >= window.from);
      while (i < spans.length) {
        const span = spans[i] as Span;
        if (span.from > window.to) break;
        const [left, right] = [Math.max(x(span.from), -4), Math.min(x(span.to), width + 4)];
        const chosen = span === current || span === scene.hovered;
        if (right - left < THIN && !chosen) {
          const to = Math.max(right, left + 1.5);
          if (thin?.kind === span.kind && left <= thin.right + 1) thin.right = to;
          else {
            flush();
            thin = { kind: span.kind, left, right: to };
          }
        } else {
          flush();
          this.span(span, row.top, left, Math.max(right, left + 2), chosen);
          work.spans++;
        }
        filled = Math.max(filled, right, left + 1);
        i++;
        const next = spans[i];
        // What ends on the pixels that are drawn already shows nothing new; much of that is jumped over at once.
        if (next !== undefined && x(next.to) < filled) {
          const until = window.from + filled / scale;
          i = first(spans, (it) => it.to >= until);
        }
      }
      flush();
    }
    if (shown?.by !== undefined) this.holders(scene, shown, x);
    for (const lane of model.open) {
      const marks = model.marks[lane] ?? [];
      const { top, end: bottom } = model.box(lane);
      if (bottom < visible.from || top > visible.to) continue;
      // One of a kind where there is room for one.
      const last: Partial<Record<MarkKind, number>> = {};
      let i = first(marks, (it) => it.at >= window.from);
      for (let mark = marks[i]; mark !== undefined && mark.at <= window.to; mark = marks[++i]) {
        const at = Math.round(x(mark.at));
        const before = last[mark.kind];
        if (before !== undefined && at - before < APART) {
          // Much of what has no room is jumped over at once, as long as all kinds have had theirs.
          const free = Math.min(...Object.values(last)) + APART;
          if (at < free) i = Math.max(i, first(marks, (it) => x(it.at) >= free - 1) - 1);
          continue;
        }
        last[mark.kind] = at;
        this.mark(mark.kind, at, top, bottom);
        work.marks++;
      }
    }
    let before = -Infinity;
    let i = first(model.arrows, (it) => it.at >= window.from);
    for (let arrow = model.arrows[i]; arrow !== undefined && arrow.at <= window.to; arrow = model.arrows[++i]) {
      const at = x(arrow.at);
      if (at - before < APART && arrow.step !== scene.step) continue;
      before = at;
      this.arrow(at, model.middle(arrow.from), model.middle(arrow.to), arrow.step === scene.step);
      work.arrows++;
    }
    if (trace.repeats !== null) {
      const from = x(trace.repeats);
      c.globalAlpha = 0.08;
      c.fillStyle = theme.text;
      c.fillRect(from, 0, x(trace.end) - from, model.height);
      c.globalAlpha = 1;
    }
    if (model.cause !== undefined) work.cause = this.cause(model.cause, model.box(model.cause.lane), x, width);
    c.restore();
    if (scene.range !== undefined) this.range(x(scene.range[0]), x(scene.range[1]), height);
    this.ruler(scene, x);
    return work;
  }

  private lanes({ model, width, step }: Scene, x: (at: number) => number): void {
    const { context: c, theme } = this;
    const current = model.trace.steps[step]?.lane;
    for (const lane of model.open) {
      const { top, bottom } = model.box(lane);
      if (lane === current) {
        c.globalAlpha = 0.1;
        c.fillStyle = theme.select;
        c.fillRect(0, top, width, bottom - top);
      }
      c.globalAlpha = theme.contrast ? 0.6 : 1;
      c.fillStyle = theme.line;
      c.fillRect(0, bottom - 1, width, 1);
      c.globalAlpha = 1;
    }
    if (model.fold !== undefined) c.fillRect(0, model.fold.bottom - 1, width, 1);
    const { start, end } = model.trace;
    // Before the beginning and after the end nothing is known.
    c.globalAlpha = 0.06;
    c.fillStyle = theme.text;
    c.fillRect(0, 0, Math.max(0, x(start)), model.height);
    c.fillRect(x(end), 0, Math.max(0, width - x(end)), model.height);
    c.globalAlpha = 1;
  }

  private colour(kind: SpanKind): string {
    return { run: this.theme.run, hold: this.theme.hold, 'wait-lock': this.theme.lock, 'wait-core': this.theme.core }[kind];
  }

  private span(span: Span, top: number, left: number, right: number, chosen: boolean): void {
    const { context: c, theme } = this;
    const colour = this.colour(span.kind);
    const [y, h, w] = [top + 1, ROW - 2, right - left];
    const hatch = PATTERNS[span.kind];
    c.globalAlpha = hatch === undefined ? (theme.contrast ? 0.25 : 0.38) : 0.14;
    c.fillStyle = colour;
    c.fillRect(left, y, w, h);
    c.globalAlpha = 1;
    if (w < 4) {
      c.fillRect(left, y, Math.min(w, 2), h);
    } else {
      if (hatch !== undefined && w > 8) {
        c.globalAlpha = 0.45;
        c.fillStyle = this.pattern(colour, hatch) ?? colour;
        c.fillRect(left, y, w, h);
        c.globalAlpha = 1;
      }
      c.strokeStyle = chosen ? theme.select : colour;
      c.lineWidth = chosen ? 2 : 1;
      c.strokeRect(left + 0.5, y + 0.5, w - 1, h - 1);
      c.lineWidth = 1;
      this.label(span, Math.max(left, 0), right, y + h / 2 + 0.5);
    }
    if (chosen && w < 4) {
      c.strokeStyle = theme.select;
      c.strokeRect(left - 1.5, y - 0.5, Math.max(w, 2) + 3, h + 1);
    }
  }

  /** The name, as much of it as there is room for; of a wait whom it waits for. */
  private label(span: Span, left: number, right: number, y: number): void {
    const { context: c, theme } = this;
    const room = right - left - 8;
    if (room < 14) return;
    const all = [words(span), ...shorter(span)];
    const text = all.find((it) => this.width(it) <= room) ?? this.fitted(all[all.length - 1] ?? '', room);
    if (text === '') return;
    if (PATTERNS[span.kind] !== undefined) {
      // Stripes are no ground for text.
      c.globalAlpha = 0.8;
      c.fillStyle = theme.ground;
      c.fillRect(left + 3, y - 7, this.width(text) + 3, 14);
      c.globalAlpha = 1;
    }
    c.fillStyle = theme.text;
    c.fillText(text, left + 4, y);
  }

  /** The cause in one sentence, below the wait that it is about. */
  private cause({ from, to, text }: Cause, { end }: Box, x: (at: number) => number, width: number): Work['cause'] {
    const { context: c, theme } = this;
    const [first, last] = [Math.max(x(from), 0), Math.min(x(to), width)];
    if (last <= 0 || first >= width) return undefined;
    const shown = this.fitted(text, width - 12);
    const left = Math.max(0, Math.min(first, width - this.width(shown) - 12));
    const right = left + this.width(shown) + 10;
    const y = end - 4;
    c.fillStyle = theme.ground;
    c.fillRect(left, y, right - left, ROW);
    c.strokeStyle = theme.miss;
    c.strokeRect(left + 0.5, y + 0.5, right - left - 1, ROW - 1);
    // From the box to the wait.
    c.fillStyle = theme.miss;
    c.fillRect(first, y - 2, Math.max(last - first, 2), 3);
    c.fillStyle = theme.text;
    c.fillText(shown, left + 6, y + ROW / 2 + 0.5);
    return { text: shown, left, right };
  }

  private width(text: string): number {
    let width = this.widths.get(text);
    if (width === undefined) {
      width = this.context.measureText(text).width;
      this.widths.set(text, width);
    }
    return width;
  }

  private fitted(text: string, room: number): string {
    if (this.width(text) <= room) return text;
    const letters = Math.floor((room / this.width(text)) * text.length) - 1;
    return letters < 2 ? '' : `${text.slice(0, letters)}…`;
  }

  private pattern(colour: string, size: number): CanvasPattern | null {
    const key = `${colour} ${size}`;
    let known = this.patterns.get(key);
    if (known === undefined) {
      const tile = document.createElement('canvas');
      tile.width = tile.height = size;
      const c = tile.getContext('2d');
      if (c !== null) {
        c.strokeStyle = colour;
        c.beginPath();
        for (const at of [-size, 0, size]) {
          c.moveTo(at, size);
          c.lineTo(at + size, 0);
        }
        c.stroke();
      }
      known = this.context.createPattern(tile, 'repeat');
      this.patterns.set(key, known);
    }
    return known;
  }

  /** From a wait to those who have what it waits for. */
  private holders({ model }: Scene, wait: Span, x: (at: number) => number): void {
    const { context: c, theme } = this;
    const y = model.middle(wait.lane);
    c.setLineDash([4, 3]);
    c.strokeStyle = this.colour(wait.kind);
    c.lineWidth = 1.5;
    for (const { lane, from, to } of wait.by ?? []) {
      if (lane === null || lane === wait.lane) continue;
      const other = model.middle(lane);
      const at = x((Math.max(from, wait.from) + Math.min(to, wait.to)) / 2);
      c.beginPath();
      c.moveTo(at, y + Math.sign(other - y) * (ROW / 2));
      c.lineTo(at, other - Math.sign(other - y) * (ROW / 2));
      c.stroke();
    }
    c.setLineDash([]);
    c.lineWidth = 1;
    c.strokeStyle = theme.select;
    for (const { lane, from, to } of wait.by ?? []) {
      if (lane !== null) c.strokeRect(x(from) + 0.5, model.middle(lane) - ROW / 2 - 1.5, Math.max(x(to) - x(from), 3), ROW + 2);
    }
  }

  private mark(kind: MarkKind, x: number, top: number, bottom: number): void {
    const { context: c, theme } = this;
    c.beginPath();
    switch (kind) {
      case 'tick':
        c.strokeStyle = theme.faint;
        c.moveTo(x + 0.5, bottom - 2);
        c.lineTo(x + 0.5, top + 2);
        c.moveTo(x - 3, top + 6);
        c.lineTo(x + 0.5, top + 1.5);
        c.lineTo(x + 4, top + 6);
        return c.stroke();
      case 'complete':
        c.strokeStyle = theme.faint;
        c.moveTo(x - 3, bottom - 7);
        c.lineTo(x + 0.5, bottom - 2);
        c.lineTo(x + 4, bottom - 7);
        return c.stroke();
      case 'request':
        c.fillStyle = theme.request;
        c.moveTo(x - 4, top + 2);
        c.lineTo(x + 5, top + 2);
        c.lineTo(x + 0.5, top + 9);
        return c.fill();
      case 'miss': {
        c.strokeStyle = theme.miss;
        c.lineWidth = 2.5;
        const [middle, r] = [(top + bottom) / 2, 6];
        c.moveTo(x - r, middle - r);
        c.lineTo(x + r, middle + r);
        c.moveTo(x - r, middle + r);
        c.lineTo(x + r, middle - r);
        c.stroke();
        c.lineWidth = 1;
        return;
      }
    }
  }

  private arrow(x: number, from: number, to: number, chosen: boolean): void {
    const { context: c, theme } = this;
    const down = Math.sign(to - from) || 1;
    c.strokeStyle = chosen ? theme.select : theme.request;
    c.fillStyle = c.strokeStyle;
    c.lineWidth = chosen ? 2.5 : 1.25;
    c.beginPath();
    c.moveTo(x, from);
    c.lineTo(x, to - down * 5);
    c.stroke();
    c.beginPath();
    c.arc(x, from, 2.5, 0, 2 * Math.PI);
    c.moveTo(x - 4, to - down * 6);
    c.lineTo(x + 4, to - down * 6);
    c.lineTo(x, to);
    c.fill();
    c.lineWidth = 1;
  }

  private ruler({ model, window, width, height, step }: Scene, x: (at: number) => number): void {
    const { context: c, theme } = this;
    const { trace } = model;
    c.fillStyle = theme.line;
    c.fillRect(0, RULER - 1, width, 1);
    const here = trace.steps[step]?.at;
    const apart = stride((window.length / width) * 90);
    c.fillStyle = theme.faint;
    for (let i = Math.ceil(window.from / apart); i * apart <= window.to; i++) {
      const at = i * apart;
      if (at < trace.start - 1e-9) continue;
      c.fillRect(Math.round(x(at)), RULER - 6, 1, 6);
      const text = time(at, trace.unit, apart);
      // Beside the time of the step, not below it.
      const free = here === undefined || x(at) + 8 + this.width(text) < x(here) - 36 || x(at) > x(here) + 36;
      if (free) c.fillText(text, x(at) + 4, RULER / 2);
    }
    if (trace.focus.lane !== null) this.upright(x(trace.focus.at), height, theme.miss, []);
    if (here !== undefined) {
      const at = here;
      this.upright(x(at), height, theme.select, [5, 3]);
      const text = time(at, trace.unit);
      const left = Math.min(Math.max(x(at) - this.width(text) / 2 - 5, 0), width - this.width(text) - 10);
      c.fillStyle = theme.ground;
      c.strokeStyle = theme.select;
      c.fillRect(left, 2, this.width(text) + 10, RULER - 5);
      c.strokeRect(left + 0.5, 2.5, this.width(text) + 9, RULER - 6);
      c.fillStyle = theme.text;
      c.fillText(text, left + 5, RULER / 2);
    }
  }

  private range(from: number, to: number, height: number): void {
    const { context: c, theme } = this;
    c.globalAlpha = 0.18;
    c.fillStyle = theme.select;
    c.fillRect(from, 0, to - from, height);
    c.globalAlpha = 1;
    for (const at of [from, to]) this.upright(at, height, theme.select, []);
  }

  private upright(x: number, height: number, colour: string, dash: number[]): void {
    const { context: c } = this;
    c.strokeStyle = colour;
    c.setLineDash(dash);
    c.beginPath();
    c.moveTo(Math.round(x) + 0.5, RULER);
    c.lineTo(Math.round(x) + 0.5, height);
    c.stroke();
    c.setLineDash([]);
  }
}

/** What is written where there is less room. */
function shorter(span: Span): string[] {
  if (span.kind !== 'wait-lock' && span.kind !== 'wait-core') return [span.label.slice(span.label.indexOf('.') + 1)];
  const names = [...new Set((span.by ?? []).map((it) => it.name))].join(', ');
  return names === '' ? ['waits'] : [`waits: ${names}`, names];
}

/** What is written on a span. */
export function words(span: Span): string {
  if (span.kind !== 'wait-lock' && span.kind !== 'wait-core') return span.label;
  const names = [...new Set((span.by ?? []).map((it) => it.name))];
  const what = span.kind === 'wait-core' ? 'waits for a core' : 'waits';
  if (names.length === 0) return what;
  return span.kind === 'wait-core' ? `waits for a core: ${names.join(', ')}` : `${span.label} waits for ${names.join(', ')}`;
}
