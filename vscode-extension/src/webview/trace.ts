// The page of the trace viewer: draws the trace it is sent, steps through it, and tells which step is looked at.
import './trace.css';
import type { Span, Trace } from '../trace/form';
import type { FromPage, Machine, Remedy, ToPage } from '../trace/messages';
import { colours, Painter, RULER, words, type Scene, type Work } from './trace/draw';
import { Model, opening, type Box, type Window } from './trace/model';
import { time } from './unit';
import { Overview } from './trace/overview';
import { element, node, rich } from './element';
import { holder, interval, lanesAt, told } from './trace/elements';
import { moment } from './trace/moment';
import { hits, nextHit } from './trace/sums';

declare function acquireVsCodeApi(): { postMessage(message: FromPage): void };

const host = acquireVsCodeApi();
const view = element('trace');
const canvas = element<HTMLCanvasElement>('canvas');
const names = element('names');
const tip = element('tip');
const context = canvas.getContext('2d') as CanvasRenderingContext2D;
const painter = new Painter(context, colours());

let model: Model | undefined;
let shown: Window | undefined;
let step = 0;
let hovered: Span | undefined;
let scheduled = false;
/** The part of time that is summed. */
let range: [number, number] | undefined;
const search = element<HTMLInputElement>('search');
let found: number[] = [];
const overview = new Overview(element<HTMLCanvasElement>('overview'), (at) => {
  shown?.centre(at);
  redraw();
});
/** Other steps can be chosen. */
let simulates = false;
/** The steps that may follow a step. */
let next: { step: number; choices: string[] } | undefined;
let size = { width: 0, height: 0 };
/** What was drawn, for tests. */
const drawn: { frames: number; last: Work; window: { from: number; to: number } | undefined } = { frames: 0, last: { spans: 0, marks: 0, arrows: 0 }, window: undefined };
Object.assign(window, { dotgenTrace: drawn });

function redraw(): void {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    if (model === undefined || shown === undefined || size.width === 0) return;
    const scene: Scene = { model, window: shown, scroll: view.scrollTop, ...size, step, hovered, range, font: font() };
    drawn.last = painter.draw(scene);
    overview.draw(shown, painter.colours, model.trace.steps[step]?.at, range);
    drawn.frames++;
    drawn.window = shown;
  });
}

let fontKnown = '';
function font(): string {
  if (fontKnown === '') fontKnown = `12px ${getComputedStyle(document.body).fontFamily}`;
  return fontKnown;
}

function resize(): void {
  overview.resize();
  const plane = element('plane');
  const [width, height] = [plane.clientWidth, view.clientHeight];
  const ratio = devicePixelRatio;
  if (width !== size.width || height !== size.height || canvas.width !== Math.round(width * ratio)) {
    size = { width, height };
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    // What was looked at stays in sight.
    revealLane(model?.trace.steps[step]?.lane ?? null);
  }
  redraw();
}

/** The run behind the preview of a remedy, with the part and the step that were looked at. */
let behind: { model: Model; shown: Window; step: number } | undefined;
/** The remedy under the pointer or with the focus. */
let wanted: number | undefined;

/** One button for each remedy; to point at it shows the run with it. */
function showRemedies(remedies: Remedy[]): void {
  const section = element('remedies');
  section.hidden = remedies.length === 0;
  const buttons = remedies.map(({ title, previews }, i) => {
    const button = node('button', rich(title));
    button.title = previews ? 'Writes this change. Pointing at it shows the run with it' : 'Writes this change';
    button.addEventListener('click', () => {
      unpreview();
      showRemedies([]);
      host.postMessage({ type: 'remedy', remedy: i });
    });
    if (previews) {
      const begin = () => {
        wanted = i;
        host.postMessage({ type: 'preview', remedy: i });
      };
      button.addEventListener('pointerenter', begin);
      button.addEventListener('focus', begin);
      button.addEventListener('pointerleave', unpreview);
      button.addEventListener('blur', unpreview);
    }
    return button;
  });
  section.replaceChildren(...buttons);
}

/** Shows the run with a remedy, as long as the remedy is pointed at. */
function preview(remedy: number, trace: Trace | null): void {
  if (remedy !== wanted || model === undefined || shown === undefined) return;
  behind ??= { model, shown, step };
  element('remedies').children[remedy]?.classList.add('previewed');
  const title = trace?.title ?? 'there is no run to show';
  element('position').textContent = '';
  element('title').textContent = element('told').textContent = `With this change: ${title}`;
  if (trace === null) return;
  model = new Model(trace);
  if (model.height + RULER > view.clientHeight) model = new Model(trace, true);
  shown = opening(trace);
  step = trace.focus.step ?? last();
  swapped();
}

/** Back to the run before the preview. */
function unpreview(): void {
  if (wanted !== undefined) host.postMessage({ type: 'unpreview' });
  wanted = undefined;
  if (behind === undefined) return;
  ({ model, shown, step } = behind);
  behind = undefined;
  for (const button of element('remedies').children) button.classList.remove('previewed');
  element('title').textContent = model.trace.title;
  swapped();
  choose(step, false);
}

/** Draws another run than before. */
function swapped(): void {
  hovered = undefined;
  overview.show(model?.trace);
  showNames();
  redraw();
}

function show(trace: Trace): void {
  behind = wanted = undefined;
  model = new Model(trace);
  shown = opening(trace);
  hovered = undefined;
  machineOf = -1;
  overview.show(trace);
  select(undefined);
  element('run').hidden = element('overview').hidden = false;
  element('empty').hidden = true;
  element('title').textContent = trace.title;
  element('title').title = [trace.title, ...trace.notes].join('\n');
  element('focus').textContent = trace.focus.lane === null ? 'End' : 'Failure';
  // What has little to do with the failure gives way if there is no room for all.
  if (model.height + RULER > view.clientHeight) model = new Model(trace, true);
  showNames();
  for (const button of document.querySelectorAll<HTMLButtonElement>('header button')) button.disabled = false;
  resize();
  find();
  choose(trace.focus.step ?? Math.max(0, trace.steps.length - 1), false);
  const { cause } = trace.focus;
  if (typeof cause === 'string') element('told').prepend(...rich(cause), '. ');
  else if (model.cause !== undefined) element('told').prepend(`${trace.lanes[model.cause.lane]?.name ?? ''} ${model.cause.text}. `);
  revealLane(trace.focus.lane);
}

/** The names of the lanes; the line between the first ones and the others folds these. */
function showNames(): void {
  if (model === undefined) return;
  const { trace, fold, folded, kept, order } = model;
  const item = (content: (Node | string)[], { top, bottom }: Box, title: string) => {
    const it = node('li', content);
    it.style.height = `${bottom - top}px`;
    it.title = title;
    return it;
  };
  const items = model.open.map((lane) => {
    const { name = '' } = trace.lanes[lane] ?? {};
    const it = item([name], model?.box(lane) as Box, name);
    it.dataset['lane'] = String(lane);
    return it;
  });
  if (fold !== undefined) {
    const others = order.length - kept;
    const button = node('button', [`${folded ? '▸' : '▾'} ${others} more ${others === 1 ? 'lane' : 'lanes'}`]);
    button.id = 'fold';
    button.setAttribute('aria-expanded', String(!folded));
    button.addEventListener('click', () => {
      setFolded(!folded);
      element('fold').focus({ preventScroll: true });
    });
    items.splice(kept, 0, item([button], fold, order.slice(kept).map((lane) => trace.lanes[lane]?.name).join(', ')));
  }
  names.replaceChildren(...items);
  markLane();
}

function setFolded(folded: boolean): void {
  if (model === undefined || model.fold === undefined || model.folded === folded) return;
  model = new Model(model.trace, folded);
  leave();
  showNames();
  redraw();
}

/** Marks the name of the lane of the step, or the line of the folded ones. */
function markLane(): void {
  const lane = model?.trace.steps[step]?.lane;
  if (model === undefined || lane === undefined) return;
  const current = model.open.includes(lane) ? names.querySelector(`[data-lane="${lane}"]`) : document.getElementById('fold')?.parentElement;
  for (const name of names.children) name.classList.toggle('current', name === current);
}

function nothing(text: string): void {
  model = shown = undefined;
  showRemedies([]);
  overview.show(undefined);
  element('run').hidden = element('overview').hidden = true;
  element('empty').hidden = false;
  element('why').textContent = text;
  element('title').textContent = 'Trace';
  element('position').textContent = '';
  for (const button of document.querySelectorAll<HTMLButtonElement>('header button')) button.disabled = true;
}

/** Looks at a step: shows it, tells of it, and asks for what is beside it. */
function choose(to: number, reveal = true): void {
  const trace = model?.trace;
  const it = trace?.steps[to];
  if (model === undefined || trace === undefined || it === undefined) return;
  step = to;
  const lane = trace.lanes[it.lane]?.name ?? '';
  element('position').textContent = `step ${to + 1} of ${trace.steps.length}`;
  element('told').textContent = `${time(it.at, trace.unit)}, ${lane}: ${it.what}. Rule ${it.rule}.`;
  markLane();
  const details = node('dl', []);
  const row = (name: string, values: string[]) => {
    if (values.length > 0) details.append(node('dt', [name]), node('dd', rich(values.join(', '))));
  };
  row('codel', it.codel === undefined ? [] : [`\`${it.codel}\``]);
  row('shares', it.locks ?? []);
  const span = model.span(to);
  if (span !== undefined) row(span.kind === 'run' || span.kind === 'hold' ? 'lasts' : 'waits', [interval(span, trace)]);
  row('for', (span?.by ?? []).map((by) => holder(by, trace)));
  element('step').replaceChildren(
    node('h2', [`${time(it.at, trace.unit)} · ${lane}`]),
    node('p', rich(it.what)),
    node('p', [node('strong', [it.rule]), ` ${trace.rules[it.rule] ?? ''}`], 'what-rule'),
    details,
    ...lanesAt(trace, moment(trace, to)),
  );
  showNext();
  element<HTMLButtonElement>('go').disabled = place(to) === null;
  if (reveal) {
    shown?.reveal(it.at);
    revealLane(it.lane);
  }
  host.postMessage({ type: 'step', step: to });
  redraw();
}

/** The steps that may follow, or the button that asks for them. */
function showNext(): void {
  const section = element('following');
  section.hidden = !simulates;
  if (next?.step !== step) {
    const ask = node('button', ['Choose the next step']);
    ask.title = 'Lists the steps that the rules allow here, to go on with another one (C)';
    ask.addEventListener('click', () => ACTIONS['choose']?.());
    section.replaceChildren(ask);
    return;
  }
  const choices = next.choices.map((text, i) => {
    const button = node('button', rich(text));
    button.addEventListener('click', () => host.postMessage({ type: 'take', choice: i }));
    return node('li', [button]);
  });
  section.replaceChildren(node('h3', [choices.length === 0 ? 'Nothing can follow' : 'What follows?']), node('ol', choices));
}

/** Scrolls no further than needed for a lane to be seen. */
function revealLane(lane: number | null): void {
  if (lane === null || model === undefined) return;
  const { top, bottom } = model.box(lane);
  if (top < view.scrollTop) view.scrollTop = top;
  else if (bottom + RULER > view.scrollTop + view.clientHeight) view.scrollTop = bottom + RULER - view.clientHeight;
}

/** Sums a part of time, or nothing any more. */
function select(next: [number, number] | undefined): void {
  range = next === undefined ? undefined : [Math.min(...next), Math.max(...next)];
  const section = element('range');
  section.hidden = range === undefined;
  if (range !== undefined && model !== undefined) section.replaceChildren(...told(model.trace, ...range));
  redraw();
}

function find(): void {
  found = model === undefined ? [] : hits(model.trace, search.value);
  const at = found.indexOf(step);
  element('found').textContent = search.value.trim() === '' ? '' : found.length === 0 ? 'none' : at < 0 ? String(found.length) : `${at + 1} of ${found.length}`;
}

/** What is found is seen, in a folded lane too. */
function chooseFound(to: number): void {
  const lane = model?.trace.steps[to]?.lane;
  if (lane !== undefined && model?.open.includes(lane) === false) setFolded(false);
  choose(to);
}

/** To the next step that is found. */
function go(by: 1 | -1): void {
  const next = nextHit(found, step, by);
  if (next !== undefined) chooseFound(next);
  find();
}

function place(of: number): unknown {
  const index = model?.trace.steps[of]?.place;
  return index === undefined ? null : (model?.trace.places[index] ?? null);
}

let machineOf = -1;
let machineShown = '';
const sheet = new CSSStyleSheet();
document.adoptedStyleSheets = [sheet];

function showMachine(of: number, machine: Machine | null): void {
  if (of !== step) return;
  const section = element('machine');
  section.hidden = machine === null;
  if (machine === null) return;
  if (machineShown !== machine.svg || machineOf < 0) {
    machineShown = machine.svg;
    const parsed = new DOMParser().parseFromString(machine.svg, 'image/svg+xml').documentElement;
    // The page's policy allows no style elements but its own; a constructed sheet is not one.
    const style = parsed.querySelector('style');
    sheet.replaceSync(style?.textContent ?? '');
    style?.remove();
    section.replaceChildren(node('h2', [machine.title]), document.importNode(parsed, true));
  }
  machineOf = of;
  for (const state of section.querySelectorAll<SVGGElement>('g.node')) {
    const current = state.dataset['id'] === machine.node;
    state.classList.toggle('current', current);
    if (current) state.setAttribute('aria-current', 'step');
    else state.removeAttribute('aria-current');
  }
}

/** From the pointer to a time and a height among the lanes. */
function under(event: MouseEvent): { at: number; y: number; apart: number } | undefined {
  if (shown === undefined) return undefined;
  const box = canvas.getBoundingClientRect();
  const apart = shown.length / Math.max(size.width, 1);
  return { at: shown.from + (event.clientX - box.left) * apart, y: event.clientY - box.top - RULER + view.scrollTop, apart };
}

function hover(event: MouseEvent): void {
  const here = under(event);
  const trace = model?.trace;
  if (here === undefined || model === undefined || trace === undefined) return;
  const mark = model.markAt(here.at, here.y, here.apart * 5);
  const span = model.at(here.at, here.y, here.apart * 3);
  const text = [];
  if (span !== undefined) {
    text.push(`${words(span)}\n${interval(span, trace)}`, ...(span.by ?? []).map((it) => holder(it, trace).replaceAll('`', '')));
  }
  const told = mark?.step === null || mark?.step === undefined ? undefined : trace.steps[mark.step];
  if (told !== undefined) text.push(`${time(told.at, trace.unit)}: ${told.what}`);
  else if (mark !== undefined) text.push('too late');
  tip.hidden = text.length === 0;
  tip.textContent = text.join('\n');
  tip.style.left = `${Math.min(event.clientX + 12, innerWidth - tip.offsetWidth - 4)}px`;
  tip.style.top = `${Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 4)}px`;
  if (span !== hovered) {
    hovered = span;
    redraw();
  }
}

function leave(): void {
  tip.hidden = true;
  if (hovered !== undefined) {
    hovered = undefined;
    redraw();
  }
}

/** A click chooses the step; a drag moves time, and the lanes where they do not fit. */
function press(down: PointerEvent): void {
  if (down.button !== 0 || shown === undefined) return;
  view.focus({ preventScroll: true });
  canvas.setPointerCapture(down.pointerId);
  if (down.shiftKey) return mark(down);
  let [x, y, moved] = [down.clientX, down.clientY, false];
  const move = (event: PointerEvent) => {
    moved ||= Math.abs(event.clientX - down.clientX) + Math.abs(event.clientY - down.clientY) > 3;
    if (!moved || shown === undefined) return;
    canvas.classList.add('pan');
    leave();
    shown.pan(((x - event.clientX) * shown.length) / size.width);
    view.scrollTop += y - event.clientY;
    [x, y] = [event.clientX, event.clientY];
    redraw();
  };
  const up = (event: PointerEvent) => {
    canvas.classList.remove('pan');
    canvas.removeEventListener('pointermove', move);
    const here = under(event);
    if (moved || here === undefined || model === undefined) return;
    const mark = model.markAt(here.at, here.y, here.apart * 5);
    const chosen = model.at(here.at, here.y, here.apart * 3)?.step ?? mark?.step ?? undefined;
    if (chosen !== undefined) choose(chosen, false);
  };
  canvas.addEventListener('pointermove', move);
  canvas.addEventListener('pointerup', up, { once: true });
}

/** A drag with Shift selects a part of time. */
function mark(down: PointerEvent): void {
  const from = under(down)?.at;
  if (from === undefined) return;
  leave();
  const move = (event: PointerEvent) => {
    const to = under(event)?.at;
    if (to !== undefined) select([from, to]);
  };
  canvas.addEventListener('pointermove', move);
  canvas.addEventListener('pointerup', () => canvas.removeEventListener('pointermove', move), { once: true });
}

function wheel(event: WheelEvent): void {
  if (shown === undefined) return;
  event.preventDefault();
  const by = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 20 : 1;
  const aside = event.shiftKey && event.deltaX === 0 ? event.deltaY : event.deltaX;
  if (Math.abs(aside) > Math.abs(event.shiftKey ? 0 : event.deltaY)) {
    shown.pan((aside * by * shown.length) / size.width);
  } else {
    const here = under(event);
    if (here !== undefined) shown.zoom(Math.exp((-event.deltaY * by) / 500), here.at);
  }
  leave();
  redraw();
}

function zoom(factor: number): void {
  const at = model?.trace.steps[step]?.at;
  if (shown === undefined) return;
  // Around the step, if it is in sight.
  const middle = (shown.from + shown.to) / 2;
  shown.zoom(factor, at !== undefined && at >= shown.from && at <= shown.to ? at : middle);
  redraw();
}

const last = () => (model?.trace.steps.length ?? 1) - 1;
const ACTIONS: Record<string, () => void> = {
  first: () => choose(0),
  previous: () => choose(Math.max(0, step - 1)),
  next: () => choose(Math.min(last(), step + 1)),
  last: () => choose(last()),
  out: () => zoom(0.6),
  in: () => zoom(1 / 0.6),
  fit: () => {
    shown?.fit();
    redraw();
  },
  focus: () => {
    const trace = model?.trace;
    if (trace === undefined) return;
    shown = opening(trace);
    choose(trace.focus.step ?? last(), false);
    revealLane(trace.focus.lane);
  },
  left: () => {
    shown?.pan(shown.length * -0.1);
    redraw();
  },
  right: () => {
    shown?.pan(shown.length * 0.1);
    redraw();
  },
  /** What the step is about, or what is shown. */
  select: () => {
    const span = model?.span(step);
    if (shown !== undefined) select(span !== undefined && span.to > span.from ? [span.from, span.to] : [shown.from, shown.to]);
  },
  deselect: () => select(undefined),
  choose: () => {
    if (simulates) host.postMessage({ type: 'choices', step });
  },
  find: () => search.focus(),
  go: () => {
    if (place(step) !== null) host.postMessage({ type: 'go', step });
  },
};
const KEYS: Record<string, string> = { ArrowLeft: 'previous', ArrowRight: 'next', Home: 'first', End: 'last', '-': 'out', '+': 'in', '=': 'in', '0': 'fit', f: 'focus', F: 'focus', Enter: 'go', w: 'in', s: 'out', a: 'left', d: 'right', m: 'select', c: 'choose', Escape: 'deselect', '/': 'find' };

function key(event: KeyboardEvent): void {
  if (event.ctrlKey || event.metaKey || event.altKey || model === undefined || shown === undefined) return;
  if (event.target === search) return;
  // A preview is only looked at.
  if (behind !== undefined) return;
  // Buttons keep their own keys, and the side its scrolling.
  const inside = event.target === view;
  if (event.target instanceof HTMLButtonElement && (event.key === 'Enter' || event.key === ' ')) return;
  if (event.target instanceof HTMLElement && event.target.tagName === 'ASIDE' && !event.key.startsWith('Arrow')) return;
  if (event.shiftKey && (event.key === 'ArrowLeft' || event.key === 'ArrowRight')) {
    shown.pan(shown.length * (event.key === 'ArrowLeft' ? -0.1 : 0.1));
    redraw();
  } else if (inside && (event.key === 'ArrowUp' || event.key === 'ArrowDown')) {
    choose(model.along(step, event.key === 'ArrowUp' ? -1 : 1));
  } else if (event.key === 'PageUp' || event.key === 'PageDown') {
    choose(Math.min(last(), Math.max(0, step + (event.key === 'PageUp' ? -10 : 10))));
  } else {
    const action = ACTIONS[KEYS[event.key] ?? ''];
    if (action === undefined) return;
    action();
  }
  event.preventDefault();
}

window.addEventListener('message', ({ data }: MessageEvent<ToPage>) => {
  switch (data.type) {
    case 'trace':
      simulates = data.simulates;
      next = undefined;
      showRemedies(data.remedies ?? []);
      return show(data.trace);
    case 'preview':
      return preview(data.remedy, data.trace);
    case 'next':
      next = data;
      if (data.step !== step) choose(data.step);
      else showNext();
      return element('following').querySelector<HTMLElement>('ol button')?.focus({ preventScroll: true });
    case 'nothing':
      return nothing(data.text);
    case 'notice': {
      const notice = element('notice');
      notice.hidden = data.text === '';
      const [text] = notice.getElementsByTagName('span');
      if (text !== undefined) text.textContent = data.text;
      return resize();
    }
    case 'machine':
      return showMachine(data.step, data.machine);
  }
});

for (const [id, action] of Object.entries(ACTIONS)) document.getElementById(id)?.addEventListener('click', action);
search.addEventListener('input', () => {
  find();
  const next = found.includes(step) ? undefined : nextHit(found, step - 1, 1);
  if (next !== undefined) chooseFound(next);
  find();
});
search.addEventListener('keydown', (event) => {
  if (event.key === 'Enter') go(event.shiftKey ? -1 : 1);
  else if (event.key === 'Escape') view.focus();
});
for (const button of document.querySelectorAll<HTMLButtonElement>('header button')) button.disabled = true;
element('open').addEventListener('click', () => host.postMessage({ type: 'open' }));
element('refresh').addEventListener('click', () => host.postMessage({ type: 'refresh' }));
document.addEventListener('keydown', key);
canvas.addEventListener('wheel', wheel, { passive: false });
canvas.addEventListener('pointerdown', press);
canvas.addEventListener('pointermove', hover);
canvas.addEventListener('pointerleave', leave);
canvas.addEventListener('dblclick', () => ACTIONS['go']?.());
view.addEventListener('scroll', redraw);
new ResizeObserver(resize).observe(view);
new ResizeObserver(resize).observe(element('plane'));
new ResizeObserver(resize).observe(element('overview'));
// The theme of the editor stands in the classes and the style of the page.
const themes = new MutationObserver(() => {
  painter.colours = colours();
  fontKnown = '';
  redraw();
});
for (const it of [document.documentElement, document.body]) themes.observe(it, { attributes: true, attributeFilter: ['class', 'style'] });
host.postMessage({ type: 'ready' });
