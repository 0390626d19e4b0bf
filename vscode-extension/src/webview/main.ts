// The page of the preview: shows what it is sent, and tells what is done to it. It lays out nothing.
import './main.css';
import type { FromPage, Live, Shown, Subject, ToPage } from '../preview/messages';
import { Canvas } from './canvas';
import { draggable } from './drag';
import { element, node } from './element';
import { overlay } from './live';

declare function acquireVsCodeApi(): { postMessage(message: FromPage): void; setState(state: Subject): void };

const host = acquireVsCodeApi();
const view = element('view');
const details = element('details');
const search = element<HTMLInputElement>('search');
const kind = element<HTMLSelectElement>('kind');
const OPTIONS = ['wcet', 'load', 'paths', 'locks', 'interrupts', 'chains'] as const;
const SHOWN_AT_FIRST: readonly string[] = ['wcet', 'load'];
/** How far a key moves a node, in pixels. */
const STEP = 20;

const canvas = new Canvas(view, 'g.node', begin);

let shown: Shown | undefined;
let live: Live | undefined;
let selected: string | undefined;
let current: string | undefined;
/** Clicks choose the states of a way. */
let choosing = false;
/** The hit of the search that is in the middle. */
let hit = 0;
/** What was last opened or moved: it stays where it is in the window. */
let held: string | undefined;
/** The picture opened larger than the view: the state at the cursor, which comes next, goes to the middle. */
let opened = false;

function nodes(): SVGGElement[] {
  return [...view.querySelectorAll<SVGGElement>('g.node')];
}

function draw(next: Shown): void {
  const focused = document.activeElement?.getAttribute('data-id');
  const { kind: ofKind, component, owner } = next.subject;
  const before = shown?.subject;
  // A state of the same name in another machine is another state.
  const isOther = before?.kind !== ofKind || before.component !== component || before.owner !== owner;
  if (isOther) selected = current = undefined;
  shown = next;
  host.setState(next.subject);
  // Before the picture: the tools decide how much room the picture has.
  showTools(next);
  const placed = byId(held)?.getBoundingClientRect();
  canvas.show(next.svg, { width: next.width, height: next.height }, { isOther, flows: ofKind === 'system' });
  const after = byId(held)?.getBoundingClientRect();
  if (placed !== undefined && after !== undefined) view.scrollBy(after.left - placed.left, after.top - placed.top);
  held = undefined;
  for (const node of nodes()) {
    const id = node.dataset['id'] ?? '';
    // Focus waits for the click: what it shows may move the picture away under the pointer before the button is up.
    node.addEventListener('mousedown', (event) => event.preventDefault());
    node.addEventListener('click', (event) => {
      node.focus({ preventScroll: true });
      act(id, event.target, event.shiftKey);
    });
    node.addEventListener('focus', () => choose(id, false));
    if (ofKind === 'system') draggable(node, () => canvas.factor, together(id), (by) => move(id, by));
    sign(node, id);
    if (id === focused) {
      node.focus({ preventScroll: true });
    }
  }
  mark();
  find();
  showLive();
}

/** Shows the tools of the kind of picture, and what they are set to. */
function showTools({ subject, withoutChains, arranged }: Shown): void {
  if (selected === undefined) describe([]);
  kind.value = subject.kind;
  for (const name of OPTIONS) element<HTMLInputElement>(name).checked = subject.options[name] ?? SHOWN_AT_FIRST.includes(name);
  for (const tool of document.querySelectorAll<HTMLElement>('.fsm, .system')) tool.hidden = !tool.classList.contains(subject.kind);
  element('chainless').hidden = !withoutChains;
  element('arrange').hidden ||= !arranged;
  if (subject.kind !== 'fsm') choosing = false;
  tell();
  element('legend').hidden = subject.kind !== 'fsm';
}

/** Brings the part of a large picture that is read first to the middle: the first state, until the cursor is known. */
function begin(): void {
  const first = nodes().find((it) => it.dataset['names']?.split(' ').includes('start'));
  const node = byId(current) ?? first ?? nodes()[0];
  opened = true;
  if (node !== undefined) canvas.centre(node);
}

/** Marks the state at the cursor, and shows it. */
function highlight(id: string | undefined): void {
  current = id;
  mark();
  const node = byId(id);
  if (opened && node !== undefined) canvas.centre(node);
  else reveal(node);
  opened = false;
}

function showLive(): void {
  overlay(view, live);
  element('ran').hidden = live === undefined;
}

function byId(id: string | undefined): SVGGElement | undefined {
  return id === undefined ? undefined : nodes().find((it) => it.dataset['id'] === id);
}

/** What goes where a node goes: itself, and the ports of a component. */
function together(id: string): () => SVGGElement[] {
  return () => nodes().filter((it) => it.dataset['id'] === id || it.dataset['id']?.startsWith(`${id}.`) === true);
}

/** The sign by which a node is opened and closed. */
function sign(node: SVGGElement, id: string): void {
  const open = shown?.nodes.find((it) => it.id === id)?.open ?? null;
  const shape = node.querySelector<SVGRectElement>('rect.shape');
  if (open === null || shape === null) return;
  const text = document.createElementNS('http://www.w3.org/2000/svg', 'text');
  text.classList.add('toggle');
  text.setAttribute('x', String(shape.x.baseVal.value + shape.width.baseVal.value - 8));
  text.setAttribute('y', String(shape.y.baseVal.value + 13));
  text.setAttribute('text-anchor', 'middle');
  text.setAttribute('aria-hidden', 'true');
  text.textContent = open ? '▾' : '▸';
  node.append(text);
  node.setAttribute('aria-label', `${node.getAttribute('aria-label') ?? id}; ${open ? 'open, Space closes it' : 'Space opens it'}`);
}

/** What a click or a key on a node does. */
function act(id: string, target: EventTarget | null, way: boolean): void {
  const line = target instanceof SVGElement ? target.dataset['line'] : undefined;
  if (target instanceof SVGElement && target.classList.contains('toggle')) toggle(id);
  else if ((way || choosing) && shown?.subject.kind === 'fsm') goThrough(id);
  else if (line !== undefined) {
    choose(id, false);
    host.postMessage({ type: 'jump', id, line: Number(line) });
  } else choose(id, true);
}

/** Opens a component, or closes it. */
function toggle(id: string): void {
  const open = shown?.nodes.find((it) => it.id === id)?.open ?? null;
  if (open === null) return;
  held = id;
  canvas.keep();
  host.postMessage({ type: 'open', id, open: !open });
}

function move(id: string, by: [number, number]): void {
  canvas.keep();
  host.postMessage({ type: 'move', id, by });
}

/** Adds a state to the way. */
function goThrough(id: string): void {
  const state = shown?.nodes.find((it) => it.id === id)?.names[0];
  if (state === undefined) return;
  choose(id, false);
  host.postMessage({ type: 'way', states: [...(shown?.subject.way ?? []), state] });
}

function endWay(): void {
  choosing = false;
  if ((shown?.subject.way ?? []).length > 0) host.postMessage({ type: 'way', states: [] });
  tell();
}

/** Says what is known of the way. */
function tell(): void {
  const told = element('told');
  const way = shown?.subject.kind === 'fsm' ? (shown.subject.way ?? []) : [];
  element('way').setAttribute('aria-pressed', String(choosing));
  told.hidden = !choosing && way.length === 0;
  if (way.length === 0) told.textContent = 'Choose the states of a way, one after the other.';
  else told.textContent = shown?.told ?? `${way.join(' → ')}: choose the next state. Escape begins anew.`;
}

const ARROWS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** The nearest node in a direction; going aside counts double. */
function neighbour(from: Element, [dx, dy]: [number, number]): SVGGElement | undefined {
  const middle = (it: Element) => {
    const box = it.getBoundingClientRect();
    return { x: box.left + box.width / 2, y: box.top + box.height / 2 };
  };
  const start = middle(from);
  const distance = (it: Element) => {
    const { x, y } = middle(it);
    const ahead = (x - start.x) * dx + (y - start.y) * dy;
    const aside = Math.abs((x - start.x) * dy) + Math.abs((y - start.y) * dx);
    return ahead > 4 ? ahead + 2 * aside : Infinity;
  };
  const [nearest] = nodes().filter((it) => distance(it) < Infinity).sort((a, b) => distance(a) - distance(b));
  return nearest;
}

/** Scrolls a node into the view, no further than needed. */
function reveal(node: Element | undefined): void {
  node?.scrollIntoView({ block: 'nearest', inline: 'nearest' });
}

function mark(): void {
  for (const node of nodes()) {
    const isCurrent = node.dataset['id'] === current;
    node.classList.toggle('current', isCurrent);
    if (isCurrent) node.setAttribute('aria-current', 'location');
    else node.removeAttribute('aria-current');
    node.classList.toggle('selected', node.dataset['id'] === selected);
  }
}

function choose(id: string | undefined, jump: boolean): void {
  selected = id;
  mark();
  describe([]);
  if (id === undefined) return;
  host.postMessage({ type: 'select', id });
  if (jump) host.postMessage({ type: 'jump', id });
}

function describe(diagnostics: string[]): void {
  const it = shown?.nodes.find(({ id }) => id === selected);
  details.hidden = it === undefined;
  if (it === undefined) return;
  const { codel } = it;
  const rows: [string, string[]][] =
    codel === null
      ? [['what', [it.description]]]
      : [
          ['states', [codel.states.join(', ') + (codel.async ? ' (async)' : '')]],
          ['parameters', codel.params],
          ['wcet', codel.wcet === null || codel.wcet === '∞' ? [] : [`≤ ${codel.wcet}`]],
          ['excludes', codel.excludes],
        ];
  const told = [...rows, ['problems', diagnostics] as const].filter(([, values]) => values.length > 0);
  const list = told.flatMap(([name, values]) => [node('dt', name), node('dd', values.join('\n'))]);
  details.replaceChildren(node('h2', codel?.name ?? it.lines[0] ?? it.description), node('dl', list));
}

function find(): void {
  const text = search.value.trim().toLowerCase();
  for (const node of nodes()) {
    const data = shown?.nodes.find((it) => it.id === node.dataset['id']);
    const words = [...(data?.names ?? []), ...(data?.lines ?? []), ...(data?.holds ?? [])].join(' ').toLowerCase();
    node.classList.toggle('missed', text !== '' && !words.includes(text));
  }
  const found = text === '' ? [] : hits();
  element('found').textContent = text === '' ? '' : `${found.length} found`;
  hit = 0;
  show(found[0]);
}

/** What has the text that is looked for. */
function hits(): SVGGElement[] {
  return nodes().filter((it) => !it.classList.contains('missed'));
}

/** Brings a hit to the middle. */
function show(node: SVGGElement | undefined): void {
  for (const it of nodes()) it.classList.toggle('hit', it === node);
  if (node !== undefined) canvas.centre(node);
}

function raster(svg: string, width: number, height: number): void {
  const SCALE = 2;
  const image = new Image();
  image.addEventListener('load', () => {
    const canvas = document.createElement('canvas');
    canvas.width = width * SCALE;
    canvas.height = height * SCALE;
    canvas.getContext('2d')?.drawImage(image, 0, 0, canvas.width, canvas.height);
    const data = canvas.toDataURL('image/png').replace(/^data:image\/png;base64,/, '');
    host.postMessage({ type: 'png', data });
  });
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
}

window.addEventListener('message', ({ data }: MessageEvent<ToPage>) => {
  switch (data.type) {
    case 'picture':
      return draw(data.shown);
    case 'notice': {
      const notice = element('notice');
      notice.hidden = data.text === undefined;
      notice.textContent = data.text ?? '';
      return;
    }
    case 'live':
      live = data.live;
      return showLive();
    case 'highlight':
      return highlight(data.id);
    case 'diagnostics':
      return data.id === selected ? describe(data.messages) : undefined;
    case 'raster':
      return raster(data.svg, data.width, data.height);
  }
});

kind.addEventListener('change', () => host.postMessage({ type: 'kind', kind: kind.value as Subject['kind'] }));
for (const name of OPTIONS) {
  element(name).addEventListener('change', () => {
    const options = Object.fromEntries(OPTIONS.map((it) => [it, element<HTMLInputElement>(it).checked]));
    host.postMessage({ type: 'options', options });
  });
}
element('svg').addEventListener('click', () => host.postMessage({ type: 'export', format: 'svg' }));
element('png').addEventListener('click', () => host.postMessage({ type: 'export', format: 'png' }));
search.addEventListener('input', find);
search.addEventListener('keydown', (event) => {
  const found = search.value.trim() === '' ? [] : hits();
  if (found.length === 0) return;
  if (event.key === 'Enter') found[hit]?.focus();
  else if (event.key === 'ArrowDown' || event.key === 'ArrowUp') {
    event.preventDefault();
    hit = (hit + (event.key === 'ArrowDown' ? 1 : found.length - 1)) % found.length;
    show(found[hit]);
  }
});
element('way').addEventListener('click', () => {
  if (choosing) return endWay();
  choosing = true;
  tell();
});
for (const type of ['arrange', 'scenario', 'aboutChains'] as const) element(type).addEventListener('click', () => host.postMessage({ type }));
document.addEventListener('keydown', (event) => {
  if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
  const target = event.target instanceof SVGElement ? event.target : undefined;
  const id = target?.closest<SVGElement>('g.node')?.dataset['id'];
  const arrow = ARROWS[event.key];
  const opens = target?.dataset['line'] === undefined && typeof shown?.nodes.find((it) => it.id === id)?.open === 'boolean';
  if (event.key === ' ' && id !== undefined && opens) {
    event.preventDefault();
    toggle(id);
  } else if ((event.key === 'Enter' || event.key === ' ') && id !== undefined) {
    event.preventDefault();
    act(id, event.target, event.shiftKey);
  } else if (arrow !== undefined && id !== undefined && event.shiftKey && shown?.subject.kind === 'system') {
    event.preventDefault();
    held = id;
    move(id, [arrow[0] * STEP, arrow[1] * STEP]);
  } else if (arrow !== undefined && id !== undefined && target !== undefined) {
    event.preventDefault();
    neighbour(target.closest('g.node') ?? target, arrow)?.focus();
  } else if (event.key === 'Escape') {
    choose(undefined, false);
    endWay();
  } else if (event.key === 'p' && shown?.subject.kind === 'fsm') element('way').click();
  else if (event.key === '/') {
    event.preventDefault();
    search.focus();
  } else canvas.key(event);
});

/** The width that the panel knows. */
let known = 0;
let resized: number | undefined;
function tellWidth(): void {
  const width = view.clientWidth;
  // A scrollbar more or less changes no layout.
  if (width < 100 || Math.abs(width - known) < known / 10) return;
  known = width;
  host.postMessage({ type: 'width', width });
}
new ResizeObserver(() => {
  window.clearTimeout(resized);
  resized = window.setTimeout(tellWidth, known === 0 ? 0 : 200);
}).observe(view);
host.postMessage({ type: 'ready' });
