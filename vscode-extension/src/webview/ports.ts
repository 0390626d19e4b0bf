// The ports of a run: a line each, with small plots of its numbers. An open line has the whole value.
import type { Port } from '../run/messages';
import { node } from './element';
import { plot } from './plot';
import { matches, ordered } from './summary';
import { update } from './update';

/** Plots in the line of a port. The others are in the open line. */
const FIRST = 3;

interface Row {
  all: HTMLDetailsElement;
  first: HTMLElement;
  value: HTMLElement;
  rest: HTMLElement;
  whole: HTMLElement;
}

const rows = new Map<string, Row>();

/** Shows the ports that match a filter. A line is made once, so it stays open, and keeps the focus. */
export function showPorts(section: HTMLElement, ports: readonly Port[], filter: string): void {
  for (const name of rows.keys()) if (!ports.some((it) => it.name === name)) rows.delete(name);
  const made = ports.map((it) => rows.get(it.name) ?? row(it));
  const all = section.querySelector('.all') as Element;
  if (made.length !== all.childElementCount || made.some((it, i) => it.all !== all.children[i])) all.replaceChildren(...made.map((it) => it.all));
  ports.forEach((port, i) => {
    const it = made[i] as Row;
    it.all.hidden = !matches(filter, port);
    if (!it.all.hidden) fill(it, port);
  });
  section.hidden = made.every((it) => it.all.hidden);
}

function row({ name, doc }: Port): Row {
  const [first, value, rest, whole] = [node('span', '', 'plots'), node('span', '', 'value'), node('div', '', 'plots'), node('pre')];
  const title = node('code', name);
  if (doc) title.title = doc;
  const all = node('details', [node('summary', [title, first, value]), ...(doc ? [node('div', doc, 'faint')] : []), rest, whole], 'port');
  const it = { all, first, value, rest, whole };
  rows.set(name, it);
  return it;
}

function fill({ first, value, rest, whole }: Row, port: Port): void {
  const plots = ordered(port).map((it) => plot(it.values, it.name));
  update(first, plots.slice(0, FIRST));
  update(rest, plots.slice(FIRST));
  const said = port.value === '' ? 'nothing yet' : port.value;
  if (value.textContent === said) return;
  value.textContent = said;
  value.classList.toggle('faint', port.value === '');
  whole.textContent = pretty(port.value);
}

function pretty(value: string): string {
  try {
    return JSON.stringify(JSON.parse(value), null, 2);
  } catch {
    return value;
  }
}
