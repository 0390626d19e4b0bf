// Small pictures of numbers: a bar for a load, a line for the last values.
import { node, number, percent } from './element';
import { points } from './summary';

const [WIDTH, HEIGHT] = [96, 18];
const BAR = 48;

function svg(width: number, height: number, tag: string, all: Record<string, string>[]): SVGSVGElement {
  const it = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  it.setAttribute('viewBox', `0 0 ${width} ${height}`);
  it.setAttribute('width', String(width));
  it.setAttribute('height', String(height));
  for (const attributes of all) {
    const shape = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, value);
    it.append(shape);
  }
  return it;
}

/** A load as a bar with its number. A full bar is one core. */
export function bar(load: number | undefined): Node | string {
  if (load === undefined) return '';
  const share = Math.min(1, Math.max(0, load));
  const box = { x: '.5', y: '.5', height: '7', rx: '1' };
  const it = svg(BAR, 8, 'rect', [{ ...box, width: String(BAR - 1), class: 'all' }, { ...box, width: String(Math.round(share * (BAR - 1))), class: load > 1 ? 'over' : 'used' }]);
  it.setAttribute('aria-hidden', 'true');
  it.setAttribute('preserveAspectRatio', 'none');
  return node('span', [it, node('span', percent(load), 'share')], 'load');
}

/** The last values of a number as a line, with the newest. */
export function plot(values: readonly number[], name: string, said = name, shown: (it: number) => string = number): HTMLElement {
  const it = svg(WIDTH, HEIGHT, 'polyline', [{ points: points(values, WIDTH, HEIGHT) }]);
  it.setAttribute('role', 'img');
  it.setAttribute('aria-label', `${said} from ${shown(Math.min(...values))} to ${shown(Math.max(...values))}, now ${shown(values.at(-1) ?? 0)}`);
  return node('span', [node('span', name, 'faint'), it, node('span', shown(values.at(-1) ?? 0), 'now')], 'plot');
}
