// The page of the preview: shows what it is sent, and tells what is done to it. It lays out nothing.
import type { FromPage, Shown, Subject, ToPage } from '../preview/messages';
import { Canvas } from './canvas';

declare function acquireVsCodeApi(): { postMessage(message: FromPage): void; setState(state: Subject): void };

const host = acquireVsCodeApi();
const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const view = element('view');
const details = element('details');
const search = element<HTMLInputElement>('search');
const kind = element<HTMLSelectElement>('kind');
const OPTIONS = ['wcet', 'paths', 'locks', 'interrupts'] as const;

const canvas = new Canvas(view, 'g.node');

let shown: Shown | undefined;
let selected: string | undefined;
let current: string | undefined;

function nodes(): SVGGElement[] {
  return [...view.querySelectorAll<SVGGElement>('g.node')];
}

function draw(next: Shown): void {
  const focused = document.activeElement?.getAttribute('data-id');
  const { kind: ofKind, component, owner } = next.subject;
  const before = shown?.subject;
  // A state of the same name in another machine is another state.
  if (before?.kind !== ofKind || before.component !== component || before.owner !== owner) selected = undefined;
  shown = next;
  host.setState(next.subject);
  canvas.show(next.svg, next.width, next.height);
  for (const node of nodes()) {
    const id = node.dataset['id'] ?? '';
    // Focus waits for the click: what it shows may move the picture away under the pointer before the button is up.
    node.addEventListener('mousedown', (event) => event.preventDefault());
    node.addEventListener('click', () => {
      node.focus({ preventScroll: true });
      choose(id, true);
    });
    node.addEventListener('focus', () => choose(id, false));
    if (id === focused) {
      node.focus({ preventScroll: true });
    }
  }
  if (selected === undefined) describe([]);
  kind.value = next.subject.kind;
  for (const name of OPTIONS) element<HTMLInputElement>(name).checked = next.subject.options[name] ?? name === 'wcet';
  for (const label of document.querySelectorAll<HTMLElement>('label.fsm')) label.hidden = next.subject.kind !== 'fsm';
  for (const label of document.querySelectorAll<HTMLElement>('label.system')) label.hidden = next.subject.kind !== 'system';
  element('legend').hidden = next.subject.kind !== 'fsm';
  mark();
  find();
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
  const node = shown?.nodes.find((it) => it.id === selected);
  details.hidden = node === undefined;
  if (node === undefined) return;
  const title = document.createElement('h2');
  title.textContent = node.codel?.name ?? node.lines[0] ?? node.description;
  const list = document.createElement('dl');
  const row = (name: string, values: string[]) => {
    if (values.length === 0) return;
    const term = document.createElement('dt');
    term.textContent = name;
    const value = document.createElement('dd');
    value.textContent = values.join('\n');
    list.append(term, value);
  };
  if (node.codel === null) {
    row('what', [node.description]);
  } else {
    row('states', [node.codel.states.join(', ') + (node.codel.async ? ' (async)' : '')]);
    row('parameters', node.codel.params);
    row('wcet', node.codel.wcet === null ? [] : [`≤ ${node.codel.wcet}`]);
    row('excludes', node.codel.excludes);
  }
  row('problems', diagnostics);
  details.replaceChildren(title, list);
}

function find(): void {
  const text = search.value.trim().toLowerCase();
  for (const node of nodes()) {
    const data = shown?.nodes.find((it) => it.id === node.dataset['id']);
    const words = [...(data?.names ?? []), ...(data?.lines ?? [])].join(' ').toLowerCase();
    node.classList.toggle('missed', text !== '' && !words.includes(text));
  }
  const hits = nodes().filter((it) => !it.classList.contains('missed'));
  element('found').textContent = text === '' ? '' : `${hits.length} found`;
  if (text !== '') reveal(hits[0]);
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
    case 'highlight':
      current = data.id;
      mark();
      return reveal(nodes().find((it) => it.dataset['id'] === current));
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
  if (event.key === 'Enter') nodes().find((it) => !it.classList.contains('missed'))?.focus();
});
document.addEventListener('keydown', (event) => {
  if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
  const id = event.target instanceof SVGElement ? event.target.dataset['id'] : undefined;
  if ((event.key === 'Enter' || event.key === ' ') && id !== undefined) {
    event.preventDefault();
    choose(id, true);
  } else if (event.key in ARROWS && id !== undefined && event.target instanceof SVGElement) {
    event.preventDefault();
    neighbour(event.target, ARROWS[event.key] ?? [0, 0])?.focus();
  } else if (event.key === 'Escape') choose(undefined, false);
  else if (event.key === '/') {
    event.preventDefault();
    search.focus();
  } else canvas.key(event);
});
host.postMessage({ type: 'ready' });
