// The page of a run: draws what it is sent, and tells what is done to it.
import type { FromPage, Port, Report, RunView, Service, ToPage, Violation, ViolationEvent } from '../run/messages';
import { field } from './form';
import { shownUnit } from './unit';
import { update } from './update';

/** What is typed into the forms of a run: the page is made anew when it is shown again, and this is what is kept. */
interface Typed {
  /** Of the run. */
  name: string;
  inputs: Record<string, Record<string, unknown>>;
}

declare function acquireVsCodeApi(): { postMessage(message: FromPage): void; getState(): Typed | undefined; setState(state: Typed): void };

const host = acquireVsCodeApi();
const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const STATES: Record<RunView['state'], string> = { starting: 'starting …', running: 'running …', stopping: 'stopping …', ended: 'ended', failed: 'could not run' };
const ENDS: Record<string, string> = { done: '', 'nothing-left': 'nothing was left to happen', standstill: 'time stood still', stopped: 'stopped at a violation', measure: 'ended by a measure', interrupted: 'stopped' };

function node<K extends keyof HTMLElementTagNameMap>(tag: K, content: (Node | string)[] | string = '', className = ''): HTMLElementTagNameMap[K] {
  const it = document.createElement(tag);
  it.append(...(typeof content === 'string' ? [content] : content));
  if (className !== '') it.className = className;
  return it;
}

/** A number of a report, to what can be read. */
const number = (it: number | undefined) => (it === undefined ? '–' : String(Number(it.toPrecision(4))));

const percent = (share: number) => `${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;

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

function list(id: string, lines: string[]): void {
  const section = element(id);
  section.hidden = lines.length === 0;
  update(section.querySelector('ul') as Element, lines.map((it) => node('li', it)));
}

/** What violates a check, in words: in the report, or told at the socket. */
function checked(it: Violation, { checks }: Report): string {
  const check = checks[it.check ?? -1];
  return check === undefined ? 'a check' : `${check.check} ${check.of}`;
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

/** The verdict of a check in the words of `dotgen run`, with the reason why the run shows nothing about it. */
function verdict(it: Report['checks'][number]): HTMLElement {
  const word = said(it.verdict);
  return node('span', it.why === undefined ? word : `${word}: ${it.why}`, it.verdict === 'violated' ? 'violated' : '');
}

function showReport({ report, progress, violations }: RunView): void {
  const known = report ?? progress;
  const unit = shownUnit(known?.unit ?? '');
  const told = (it: ViolationEvent) => violation(it.violation, it.unit, it.what);
  list('violations', report === null ? violations.filter((it) => it !== undefined).map(told) : report.violations.map((it) => violation(it, report.unit, checked(it, report))));
  // The unit once, over all of its columns.
  for (const [id, title] of [['tasks', 'Tasks'], ['checks', 'Checks']] as const) (element(id).querySelector('h2') as Element).textContent = `${title}, times in ${unit}`;
  table('tasks', ['task', '#load', '#jobs', '#mean', '#greatest', '#bound', '#period', '#missed'], (known?.tasks ?? []).map((it) => {
    const beyond = it.greatest !== undefined && it.bound !== undefined && it.greatest > it.bound;
    const greatest = node('span', number(it.greatest), beyond ? 'violated' : '');
    return [it.task, it.load === undefined ? '' : percent(it.load), String(it.jobs), number(it.mean), greatest, number(it.bound), number(it.period), node('span', String(it.missed), it.missed > 0 ? 'violated' : '')];
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

/** What was typed into the forms of a run. */
function typed(name: string): Typed {
  const state = host.getState();
  return state?.name === name ? state : { name, inputs: {} };
}

/** What is typed into a form stays, so a form is made once; only its answer changes. */
function showServices(run: string, services: Service[], over: boolean): void {
  const section = element('services');
  section.hidden = services.length === 0;
  const all = section.querySelector('.all') as Element;
  const names = services.map((it) => it.name).join(' ');
  if (section.dataset['names'] !== names) {
    section.dataset['names'] = names;
    all.replaceChildren(...services.map((it) => form(run, it)));
  }
  services.forEach((it, i) => {
    const made = all.children[i];
    const answer = made?.querySelector('.answer');
    if (answer && answer.textContent !== it.answer) answer.textContent = it.answer;
    const [send, abort] = made?.querySelectorAll<HTMLButtonElement>('.foot button') ?? [];
    if (send !== undefined) send.disabled = over;
    if (abort !== undefined) abort.hidden = over || !it.active;
  });
}

function form(run: string, { name, doc, inputs }: Service): HTMLElement {
  const send = node('button', 'Send');
  send.setAttribute('aria-label', `Send ${name}`);
  const abort = node('button', 'Interrupt');
  abort.type = 'button';
  abort.hidden = true;
  abort.setAttribute('aria-label', `Interrupt ${name}`);
  abort.addEventListener('click', () => host.postMessage({ type: 'abort', service: name }));
  const before = typed(run).inputs[name] ?? {};
  const fields = inputs.map((it) => [it.name, field(it.name, it.schema, before[it.name])] as const);
  const given = () => Object.fromEntries(fields.map(([name, it]) => [name, it.read()] as const).filter(([, it]) => it !== undefined));
  const answer = node('span', '', 'answer');
  answer.setAttribute('role', 'status');
  const head = node('div', [node('span', name, 'name'), ...(doc ? [node('span', doc, 'doc')] : [])], 'head');
  const inside = node('div', fields.map(([, it]) => it.node), 'fields');
  const made = node('form', [head, inside, node('div', [send, abort, answer], 'foot')]);
  made.setAttribute('aria-label', name);
  made.addEventListener('submit', (event) => {
    event.preventDefault();
    host.postMessage({ type: 'call', service: name, inputs: given() });
  });
  const keep = (): void => {
    const { inputs } = typed(run);
    host.setState({ name: run, inputs: { ...inputs, [name]: given() } });
  };
  // A click makes a list longer or shorter.
  for (const it of ['input', 'change', 'click']) made.addEventListener(it, keep);
  return made;
}

function plot(values: number[], name: string): Node {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const [least, greatest] = [Math.min(...values), Math.max(...values)];
  const height = greatest - least || 1;
  const line = document.createElementNS('http://www.w3.org/2000/svg', 'polyline');
  line.setAttribute('points', values.map((it, i) => `${(i * 120) / Math.max(1, values.length - 1)},${25 - ((it - least) / height) * 24}`).join(' '));
  svg.setAttribute('viewBox', '0 0 120 26');
  svg.setAttribute('role', 'img');
  svg.setAttribute('aria-label', `${name} from ${number(least)} to ${number(greatest)}, now ${number(values.at(-1))}`);
  svg.append(line);
  return node('span', [node('span', name, 'faint'), svg as unknown as Node], 'plot');
}

function showPorts(ports: Port[]): void {
  const section = element('ports');
  section.hidden = ports.length === 0;
  const all = ports.map(({ name, doc, value, series }) => {
    const title = node('code', name);
    if (doc) title.title = doc;
    return node('div', [title, node('span', value === '' ? 'nothing yet' : value, value === '' ? 'faint' : 'value'), ...series.map((it) => plot(it.values, it.name))], 'port');
  });
  update(section.querySelector('.all') as Element, all);
}

function showLog(lines: string[]): void {
  element('told').hidden = lines.length === 0;
  const log = element('log');
  const text = lines.join('\n');
  if (log.textContent === text) return;
  const atEnd = log.scrollTop + log.clientHeight >= log.scrollHeight - 4;
  log.textContent = text;
  if (atEnd) log.scrollTop = log.scrollHeight;
}

for (const type of ['stop', 'again', 'trace', 'stubs', 'import'] as const) element(type).addEventListener('click', () => host.postMessage({ type }));
window.addEventListener('message', ({ data }: MessageEvent<ToPage>) => {
  const { view } = data;
  showHead(view);
  showReport(view);
  showServices(view.name, view.services, view.state === 'ended' || view.state === 'failed');
  showPorts(view.ports);
  showLog(view.log);
});
host.postMessage({ type: 'ready' });
