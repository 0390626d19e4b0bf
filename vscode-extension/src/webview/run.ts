// The page of a run: draws what it is sent, and tells what is done to it.
import './run.css';
import type { Report, RunView, ToPage, Violation, ViolationEvent } from '../run/messages';
import { element, node, number, percent } from './element';
import { bar, plot } from './plot';
import { showPorts } from './ports';
import { Services, type Host } from './services';
import { checked, componentLines, Loads, matches } from './summary';
import { shownUnit } from './unit';
import { update } from './update';

declare function acquireVsCodeApi(): Host;

const host = acquireVsCodeApi();
const filter = element<HTMLInputElement>('filter');
const services = new Services(element('services'), host);
let loads = new Loads();
let shown: RunView | undefined;
const STATES: Record<RunView['state'], string> = { starting: 'starting …', running: 'running …', stopping: 'stopping …', ended: 'ended', failed: 'could not run' };
const ENDS: Record<string, string> = { done: '', 'nothing-left': 'nothing was left to happen', standstill: 'time stood still', stopped: 'stopped at a violation', measure: 'ended by a measure', interrupted: 'stopped' };

/** A column is of numbers where its name begins with `#`. */
function table(id: string, names: string[], rows: (Node | string)[][]): void {
  const section = element(id);
  section.hidden = rows.length === 0;
  const of = (name: string) => (name.startsWith('#') ? 'number' : '');
  const head = node('tr', names.map((it) => {
    const cell = node('th', it.replace('#', ''), of(it));
    cell.scope = 'col';
    return cell;
  }));
  const all = rows.map((row) => node('tr', row.map((it, i) => node('td', [it], of(names[i] ?? '')))));
  update(section.querySelector('table') as Element, [node('thead', [head]), node('tbody', all)]);
}

/** Makes wide tables reachable by keyboard: a table that is scrolled sideways takes the focus. */
function reachTables(): void {
  for (const it of document.querySelectorAll<HTMLElement>('.tables')) {
    const isCut = it.scrollWidth > it.clientWidth;
    if (isCut === it.hasAttribute('tabindex')) continue;
    const title = it.parentElement?.querySelector('h2, summary')?.textContent ?? 'Table';
    for (const [name, value] of [['tabindex', '0'], ['role', 'group'], ['aria-label', title]] as const) {
      if (isCut) it.setAttribute(name, value);
      else it.removeAttribute(name);
    }
  }
}

function list(id: string, lines: string[]): void {
  const section = element(id);
  section.hidden = lines.length === 0;
  update(section.querySelector('ul') as Element, lines.map((it) => node('li', it)));
}

/** Changes a scrolled text. The end stays in sight if it was in sight. */
function following(box: HTMLElement, change: () => void): void {
  const atEnd = box.scrollTop + box.clientHeight >= box.scrollHeight - 4;
  change();
  if (atEnd) box.scrollTop = box.scrollHeight;
}

function violation(it: Violation, written: string, what: string): string {
  const unit = shownUnit(written);
  const times = (it.times ?? 1) > 1 ? `, ${it.times} times` : '';
  const at = `${number(it.at.time)} ${unit}${times}: `;
  switch (it.kind) {
    case 'check':
      return `${at}${what} is violated`;
    case 'beyond-bound':
      return `${at}${it.task} took ${number(it.response)} ${unit}, and its proved bound is ${number(it.bound)} ${unit}`;
    case 'overrun':
      return `${at}${it.codel} took ${number(it.took)} ${unit}, and its wcet is ${number(it.limit)} ${unit}: what is proved assumes that`;
    case 'undeclared':
      return `${at}${it.codel} returned ${it.event ?? 'an event'}, which it does not declare`;
    case 'lost':
      return `${at}the process of ${it.component} has ended: ${it.why ?? ''}`;
    default:
      return at + it.kind;
  }
}

function showHead({ name, clock, debug, state, report, progress, simulated, hasTrace, times }: RunView): void {
  const title = clock === 'virtual' && !debug ? 'Simulation' : simulated.length > 0 ? 'Simulated run' : 'Run';
  element('title').textContent = `${title} of ${name}`;
  element('stubs').hidden = simulated.length === 0;
  const badge = element('state');
  const violated = ((report ?? progress)?.['violation-count'] ?? 0) > 0;
  const word = violated ? 'violated' : state === 'ended' && report !== null ? said(report.verdict) : STATES[state];
  // Screen readers tell every change of a live region, also to the same.
  if (badge.textContent !== word) badge.textContent = word;
  badge.className = `state ${violated || state === 'failed' ? 'violated' : word === 'kept' ? 'kept' : 'faint'}`;
  const without = simulated.length === 0 || report !== null ? [] : [`without sources: ${simulated.join(', ')}`];
  const facts = report === null ? (progress === null ? [] : [`${number(progress.time)} ${shownUnit(progress.unit)}`]) : [`${number(report.time)} ${shownUnit(report.unit)}`, ENDS[report.end] ?? report.end, `seed ${report.seed}`];
  element('facts').textContent = [...without, ...facts].filter((it) => it !== '').join(' · ');
  const over = state === 'ended' || state === 'failed';
  element('stop').hidden = over;
  element('again').hidden = !over;
  element('trace').hidden = !hasTrace;
  const take = element('import');
  take.hidden = times === 0;
  take.textContent = times === 1 ? 'Import 1 Time' : `Import ${times} Times`;
}

/** A verdict in the words of `dotgen run`. */
const said = (it: string) => ({ seen: 'kept', 'not-seen': 'not exercised', 'not-exercised': 'not exercised' })[it] ?? it;

/** The verdict of a check in the words of `dotgen run`, with the reason if the run shows nothing about it. */
function verdict(it: Report['checks'][number]): HTMLElement {
  const word = said(it.verdict);
  return node('span', it.why === undefined ? word : `${word}: ${it.why}`, it.verdict === 'violated' ? 'violated' : '');
}

function showReport({ report, progress, violations }: RunView): void {
  const known = report ?? progress;
  const unit = shownUnit(known?.unit ?? '');
  const told = (it: ViolationEvent) => violation(it.violation, it.unit, it.what);
  const lines = report === null ? violations.filter((it) => it !== undefined).map(told) : report.violations.map((it) => violation(it, report.unit, checked(it, report)));
  following(element('violated'), () => list('violations', lines));
  // The unit once, over all of its columns.
  for (const [id, title] of [['tasks', 'Tasks'], ['checks', 'Checks']] as const) (element(id).querySelector('h2') as Element).textContent = `${title}, times in ${unit}`;
  table('tasks', ['task', '#load', '#jobs', '#mean', '#greatest', '#bound', '#period', '#missed'], (known?.tasks ?? []).map((it) => {
    const beyond = it.greatest !== undefined && it.bound !== undefined && it.greatest > it.bound;
    const greatest = node('span', number(it.greatest), beyond ? 'violated' : '');
    return [it.task, bar(it.load), String(it.jobs), number(it.mean), greatest, number(it.bound), number(it.period), node('span', String(it.missed), it.missed > 0 ? 'violated' : '')];
  }));
  table('checks', ['check', 'of', 'verdict', '#greatest', '#limit'], (report?.checks ?? []).map((it) => [
    it.name === undefined ? it.check : `${it.name}: ${it.check}`,
    it.of,
    verdict(it),
    number(it.greatest),
    number(it.limit),
  ]));
  table('requests', ['service', '#requests', '#refused', '#ended'], (report?.services ?? []).map((it) => [it.service, String(it.requests), String(it.refused), String(it.ended)]));
  table('machines', ['machine', 'from', 'to', '#taken'], (known?.machines ?? []).flatMap(({ machine, transitions }) =>
    transitions.map((it) => [machine, it.from, it.to, it.taken === 0 ? node('span', 'never', 'faint') : String(it.taken)]),
  ));
  const outside = report?.['requests-outside-model'] ?? 0;
  const requests = outside === 0 ? [] : [`outside the verified model: requests that no client of the scenario sends (${outside})`];
  list('assumptions', [...(report?.assumptions ?? []), ...requests, ...(report?.notes ?? [])]);
}

/** A line for each component: its load since the start, its last loads, and what went wrong. */
function showComponents(view: RunView): void {
  const lines = componentLines(view);
  const { progress, report } = view;
  // A run begins without a report.
  if (report === null && progress === null) loads = new Loads();
  if (report === null && progress !== null) loads.add(progress.time, lines);
  const count = (it: number) => node('span', String(it), it > 0 ? 'violated' : '');
  const followed = lines.some((it) => loads.of(it.name).length > 1);
  const recent = (name: string) => (loads.of(name).length > 1 ? plot(loads.of(name), '', `load of ${name}`, percent) : '');
  const known = report !== null || progress !== null || view.violations.length > 0;
  const names = ['component', '#violations', '#missed', 'load', ...(followed ? ['last loads'] : [])];
  const rows = lines.map((it) => [it.name, count(it.violations), count(it.missed), bar(it.load), ...(followed ? [recent(it.name)] : [])]);
  table('components', names, known ? rows : []);
}

/** Shows the services and ports that match what is typed into the filter, and opens them. */
function showFiltered(): void {
  if (shown === undefined) return;
  const { name, state, ports } = shown;
  const text = filter.value.trim();
  services.show(name, shown.services, state === 'ended' || state === 'failed', text);
  showPorts(element('ports'), ports, text);
  filter.hidden = shown.services.length + ports.length === 0;
  const found = [...shown.services, ...ports].filter((it) => matches(text, it)).length;
  const said = text === '' ? '' : `${found} found`;
  if (element('found').textContent !== said) element('found').textContent = said;
}

function showLog(lines: string[]): void {
  element('told').hidden = lines.length === 0;
  const log = element('log');
  const text = lines.join('\n');
  if (log.textContent === text) return;
  following(log, () => (log.textContent = text));
}

for (const type of ['stop', 'again', 'trace', 'stubs', 'import'] as const) element(type).addEventListener('click', () => host.postMessage({ type }));
filter.addEventListener('input', () => {
  if (shown === undefined) return;
  host.setState({ ...services.typed(shown.name), filter: filter.value });
  showFiltered();
  const first = ['services', 'ports'].map(element).find((it) => !it.hidden);
  if (filter.value.trim() !== '') first?.scrollIntoView({ block: 'start' });
});
filter.addEventListener('keydown', (event) => {
  if (event.key === 'Enter' && filter.value.trim() !== '') {
    if (!services.focus()) element('ports').querySelector<HTMLElement>('details:not([hidden]) summary')?.focus();
  } else if (event.key === 'Escape' && filter.value !== '') {
    filter.value = '';
    filter.dispatchEvent(new Event('input'));
  }
});
document.addEventListener('keydown', (event) => {
  const isTyping = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement || event.target instanceof HTMLTextAreaElement;
  if (event.key !== '/' || isTyping || filter.hidden) return;
  event.preventDefault();
  filter.focus();
});
window.addEventListener('message', ({ data }: MessageEvent<ToPage>) => {
  const { view } = data;
  if (shown?.name !== view.name) filter.value = services.typed(view.name).filter ?? '';
  shown = view;
  showHead(view);
  showComponents(view);
  showReport(view);
  showFiltered();
  showLog(view.log);
  reachTables();
});
window.addEventListener('resize', reachTables);
element('machines').addEventListener('toggle', reachTables);
host.postMessage({ type: 'ready' });
