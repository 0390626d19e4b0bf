// What a run does in the picture of a state machine: the states that activities are in, how often transitions were taken,
// and the greatest time of their codels then.
import type { Live } from '../preview/messages';
import { shownUnit } from './unit';

const MARKS = ['here', 'executes'] as const;

/** Draws it over a picture; undefined: nothing of this machine has run. */
export function overlay(view: Element, live: Live | undefined): void {
  for (const it of view.querySelectorAll('.taken')) it.remove();
  for (const it of view.querySelectorAll('.never')) it.classList.remove('never');
  for (const it of view.querySelectorAll('g.node')) it.classList.remove(...MARKS);
  if (live === undefined) return;
  const nodes = [...view.querySelectorAll<SVGGElement>('g.node')];
  const of = (state: string): string | undefined => nodes.find((it) => it.dataset['names']?.split(' ').includes(state))?.dataset['id'];
  for (const { state, executes } of live.activities) {
    const node = nodes.find((it) => it.dataset['id'] === of(state));
    node?.classList.add('here');
    if (executes) node?.classList.add('executes');
  }
  for (const edge of view.querySelectorAll<SVGGElement>('g.edge.transition')) {
    const { from, to } = edge.dataset;
    const isPause = edge.classList.contains('paused');
    const its = live.transitions.filter((it) => of(it.from) === from && it.to.startsWith('pause::') === isPause && of(it.to.replace('pause::', '')) === to);
    if (its.length === 0) continue;
    const taken = its.reduce((sum, it) => sum + it.taken, 0);
    edge.classList.toggle('never', taken === 0);
    const greatest = Math.max(...its.map((it) => it.greatest ?? -1));
    const time = greatest < 0 ? '' : ` · ≤ ${Number(greatest.toPrecision(3))} ${shownUnit(live.unit)}`;
    if (taken > 0) write(edge, `${taken.toLocaleString('en').replaceAll(',', '\u202f')}${time}`);
  }
}

function write(edge: SVGGElement, said: string): void {
  const line = edge.querySelector<SVGPathElement>('path.line');
  if (line === null) return;
  const label = edge.querySelector<SVGTextElement>('text.label');
  const text = document.createElementNS('http://www.w3.org/2000/svg', 'text');
  text.classList.add('taken');
  text.textContent = said;
  if (label !== null) {
    // Below what stands there. At a loop it begins with it: the state is to its left.
    const { from, to } = edge.dataset;
    const isLoop = from === to;
    text.setAttribute('x', isLoop ? String(label.getBBox().x) : (label.getAttribute('x') ?? '0'));
    text.setAttribute('y', String(Number(label.getAttribute('y')) + 13));
    text.setAttribute('text-anchor', isLoop ? 'start' : 'middle');
  } else {
    const { x, y } = line.getPointAtLength(line.getTotalLength() / 2);
    text.setAttribute('x', String(x + 5));
    text.setAttribute('y', String(y + 4));
  }
  edge.append(text);
}
