// The page of the verification panel: shows what it is sent, and tells what is done to it.
import './verification.css';
import type { FromPage, Limits, Subject, ToPage } from '../verification/messages';
import type { Place, VerificationAnswer, WhatIf } from '../protocol';
import { element, node, rich } from './element';
import { update } from './update';

declare function acquireVsCodeApi(): { postMessage(message: FromPage): void; setState(state: Subject): void };

const host = acquireVsCodeApi();
const STATES: Record<VerificationAnswer['status'], string> = {
  stale: 'verifying …',
  running: 'verifying …',
  proved: 'proved',
  conditional: 'conditional',
  answered: 'answered',
  refuted: 'refuted',
  'gave-up': 'gave up',
  nothing: 'nothing to verify',
  blocked: 'not verified',
};

const CLASSES: Record<VerificationAnswer['checks'][number]['verdict'], string> = {
  proved: 'proved',
  conditional: 'gave-up',
  vacuous: 'gave-up',
  bounded: 'gave-up',
  exceeds: 'refuted',
  refuted: 'refuted',
  'gave up': 'gave-up',
  nothing: 'gave-up',
  open: 'running',
};

let subject: Subject | undefined;
let answer: VerificationAnswer | undefined;

/** The focus stays on what has the same name when it is shown anew. */
function link(text: string, place: Place | null, action?: () => void, name = text): Node {
  if (place === null && action === undefined) return node('span', rich(text));
  const it = node('a', rich(text));
  it.dataset['name'] = name;
  // What leads elsewhere now is not the same.
  it.dataset['place'] = JSON.stringify(place);
  it.tabIndex = 0;
  it.setAttribute('role', action === undefined ? 'link' : 'button');
  const go = action ?? (() => place !== null && jump(place));
  it.addEventListener('click', go);
  it.addEventListener('keydown', (event) => {
    if (event.key === 'Enter' || event.key === ' ') {
      event.preventDefault();
      go();
    }
  });
  return it;
}

function jump({ uri, range: { start, end } }: Place): void {
  host.postMessage({ type: 'place', uri, line: start.line, character: start.character, endLine: end.line, endCharacter: end.character });
}

/** `names` are said before cells where there is no room for columns. Roles stay when rows become blocks. */
function row(cells: (Node | string)[], numbers: number[] = [], names: string[] = []): HTMLTableRowElement {
  const it = node('tr', cells.map((cell, i) => {
    const made = node('td', cell === '' ? [] : [cell], numbers.includes(i) ? 'number' : '');
    made.setAttribute('role', 'cell');
    const name = names[i] ?? '';
    if (name !== '') made.dataset['of'] = name;
    return made;
  }));
  it.setAttribute('role', 'row');
  return it;
}

function heads(names: string[]): HTMLTableRowElement {
  const it = node('tr', names.map((name) => {
    const made = node(name === '' ? 'td' : 'th', name);
    made.setAttribute('role', name === '' ? 'cell' : 'columnheader');
    return made;
  }), 'heads');
  it.setAttribute('role', 'row');
  return it;
}

function showHead(it: VerificationAnswer): void {
  element('title').textContent = it.written ? `Scenario ${it.scenario}` : `${it.scenario}, without a scenario`;
  const state = element('state');
  state.textContent = STATES[it.status];
  state.className = `state ${it.status}`;
  const facts = [it.platform];
  if (it.howFar !== null) facts.push(it.howFar);
  if (it.minimumCores !== null) facts.push(`at least ${it.minimumCores} ${it.minimumCores === 1 ? 'core' : 'cores'} needed`);
  if (it.states > 0) facts.push(`${it.states} states, ${it.seconds.toFixed(it.seconds < 1 ? 3 : 1)}\u00a0s`);
  element('facts').textContent = facts.join(' · ');
  element('writeOut').hidden = it.written || it.whatIf;
  const notices = [...it.errors];
  if (!it.written && it.errors.length === 0) {
    notices.push('No scenario is written: permanent activities, and a client that sends any request at any time.');
  }
  if (it.whatIf) notices.unshift('This is a variation; the files are as they were.');
  if (it.advice !== null) notices.push(`To get an answer where verification gave up: ${it.advice}.`);
  notice(notices.join('\n'));
}

function notice(text: string): void {
  const it = element('notice');
  it.hidden = text === '';
  update(it, text.split('\n').map((line) => node('div', rich(line))));
}

function showChecks(it: VerificationAnswer): void {
  const table = element('checks');
  table.classList.toggle('stale', it.earlier);
  if (it.checks.length === 0) {
    const bounds = it.bounds.map((bound) => row([bound.task, `R ≤ ${bound.bound}`], [1]));
    return update(table, bounds.length > 0 ? [heads(['task', 'quick bound']), ...bounds] : [row(['There is no answer yet.'])]);
  }
  // Columns that are empty are left out.
  const columns = (['value', 'limit', 'slack'] as const).filter((name) => it.checks.some((check) => check[name] !== null));
  const rows = it.checks.flatMap((check, i) => {
    const title = check.name === null ? `${check.check} ${check.of}` : `${check.name}: ${check.check} ${check.of}`;
    const run: Node | string = check.hasRun ? link(check.verdict === 'refuted' ? 'show why' : 'show run', null, () => host.postMessage({ type: 'check', check: i }), `run ${i}`) : '';
    // Where there is a cause, the reasons are the same at length: they are told with the run.
    const notes = [check.condition, check.cause, check.worth, check.note, ...(check.cause === null ? check.reason : [])].filter((note) => note !== null);
    const verdict = node('span', check.verdict === 'open' ? 'verifying …' : check.verdict, `verdict ${CLASSES[check.verdict]}`);
    const lines = [row([verdict, link(title, check.location, undefined, `check ${i}`), ...columns.map((name) => check[name] ?? ''), run], columns.map((_, at) => at + 2), ['', '', ...columns])];
    lines[0]?.children[1]?.classList.add('what');
    if (notes.length > 0) lines.push(sentence(rich(notes.join('; ')), columns.length + 2));
    if (check.remedy !== null) lines.push(sentence([...rich(check.remedy), ...repair(check.location, `repair ${i}`)], columns.length + 2, 'remedies'));
    for (const line of lines) line.classList.toggle('shown', it.run?.check === i);
    return lines;
  });
  update(table, [heads(['verdict', 'check', ...columns, '']), ...rows]);
}

/** A whole sentence has a line of its own. */
function sentence(content: (Node | string)[], columns: number, className = ''): HTMLTableRowElement {
  const cells = [node('td'), node('td', content, `faint ${className}`)] as const;
  for (const it of cells) it.setAttribute('role', 'cell');
  cells[1].colSpan = columns;
  const it = node('tr', [...cells], 'note');
  it.setAttribute('role', 'row');
  return it;
}

/** Leads to the changes that are offered at a place. */
function repair(at: Place | null, name: string): Node[] {
  if (at === null) return [];
  const { line, character } = at.range.start;
  return [link('Repair…', null, () => host.postMessage({ type: 'repair', uri: at.uri, line, character }), name)];
}

/** What repairs all that is missed, unless that is said at the checks already. */
function showRepairs(it: VerificationAnswer): void {
  const said = it.checks.map((check) => check.remedy);
  const all = it.repairs.filter((text) => !said.includes(text));
  const at = it.checks.find((check) => check.cause !== null)?.location ?? null;
  const section = element('repairs');
  section.hidden = all.length === 0;
  update(section.querySelector('ul') as Element, all.map((text, i) => node('li', [...rich(text), ...repair(at, `repair all ${i}`)])));
}

function showRun(it: VerificationAnswer, pinned: boolean): void {
  const { run } = it;
  element('run').hidden = run === null;
  if (run === null) return;
  element('dismiss').hidden = !pinned;
  // The row of its check is marked: what the run is of is said there.
  element('runTitle').textContent = pinned ? `${run.title} (of an earlier text)` : run.shows.charAt(0).toUpperCase() + run.shows.slice(1);
  const check = it.checks[run.check];
  update(element('reasons'), (check?.cause == null ? [] : check.reason).map((reason) => node('li', rich(reason))));
  update(element('events'), run.events.map(({ text, location }, i) => node('div', [link(text, location, undefined, `event ${i}`)])));
}

function showWhatIf(it: VerificationAnswer): void {
  const form = element<HTMLFormElement>('whatIf');
  element('reset').hidden = !it.whatIf;
  // A variation that is on show can be seen.
  if (it.whatIf) element<HTMLDetailsElement>('variation').open = true;
  // What is being typed is not overwritten.
  const typing = document.activeElement;
  if (typing instanceof HTMLInputElement && (form.contains(typing) || typing.classList.contains('wcet'))) return;
  element<HTMLInputElement>('cores').value = it.cores === null ? 'free' : String(it.cores);
  element<HTMLSelectElement>('policy').value = it.policy;
  element<HTMLSelectElement>('durations').value = it.durations;
  const rows = it.codels.map((codel) => {
    const field = node('input', '', 'wcet');
    field.type = 'text';
    field.inputMode = 'decimal';
    field.setAttribute('form', 'whatIf');
    field.dataset['codel'] = codel.path;
    field.dataset['was'] = codel.wcet === null ? '' : String(codel.wcet);
    field.setAttribute('aria-label', `WCET of ${codel.path} in microseconds`);
    return row([link(codel.path, codel.location), node('span', [field, ' µs'])], [1]);
  });
  update(element('codels'), [heads(['codel', 'WCET']), ...rows]);
  for (const field of document.querySelectorAll<HTMLInputElement>('input.wcet')) field.value = field.dataset['was'] ?? '';
}

/** What is different from what is shown, on top of the variation that is shown. */
function changes(): WhatIf | undefined {
  const out: WhatIf = { ...subject?.whatIf };
  if (answer === undefined) return undefined;
  const cores = element<HTMLInputElement>('cores').value.trim();
  if (cores !== (answer.cores === null ? 'free' : String(answer.cores))) {
    out.cores = /^\d+$/.test(cores) ? Number(cores) : (cores as 'free');
  }
  const policy = element<HTMLSelectElement>('policy').value;
  if (policy !== answer.policy) out.policy = policy;
  const durations = element<HTMLSelectElement>('durations').value;
  if (durations !== answer.durations) out.durations = durations;
  const wcet: Record<string, number> = { ...out.wcet };
  for (const field of document.querySelectorAll<HTMLInputElement>('input.wcet')) {
    const value = Number(field.value.replace(',', '.'));
    if (field.value.trim() !== field.dataset['was'] && Number.isFinite(value) && value >= 0) wcet[field.dataset['codel'] ?? ''] = value;
  }
  if (Object.keys(wcet).length > 0) out.wcet = wcet;
  return Object.keys(out).length > 0 ? out : undefined;
}

function showBlocking(it: VerificationAnswer): void {
  const rows = it.blocking.flatMap(({ codel, location, by }) =>
    by.map((other, i) => row([i === 0 ? link(codel, location) : '', link(other.codel, other.location), other.time, node('span', rich(other.through))], [2], ['', 'may wait for', 'at most', 'through'])),
  );
  update(
    element('blocking'),
    rows.length > 0 ? [heads(['codel', 'may wait for', 'which takes at most', 'because both use']), ...rows] : [row(['No codel can keep another one waiting.'])],
  );
}

function showLimits(limits: Limits): void {
  const running = limits.state === 'running';
  element('findLimits').hidden = running;
  element('stopLimits').hidden = !running;
  const done = element<HTMLProgressElement>('limitsDone');
  done.hidden = !running;
  done.value = running ? limits.percentage : 0;
  const table = element('limits');
  if (limits.state !== 'found') {
    element('limitsText').textContent = limits.text;
    table.replaceChildren();
    return;
  }
  const { answer: found } = limits;
  element('limitsText').textContent = found.errors.length > 0 ? found.errors.join(' ') : `with ${found.deadlines} met`;
  if (found.errors.length > 0) return table.replaceChildren();
  const faint = (remark: string) => (remark === '' ? '' : node('span', remark, 'faint'));
  const rows = [row(['smallest number of cores', '', '', found.cores, faint(found.coresRemark)], [2, 3])];
  for (const [what, all] of [['largest WCET', found.wcet], ['smallest period', found.period]] as const) {
    rows.push(...all.map((it) => row([what, link(it.of, it.location), it.now, it.extreme, faint(it.remark)], [2, 3], ['', '', 'now', 'limit'])));
  }
  table.replaceChildren(heads(['', 'of', 'now', 'limit', '']), ...rows);
}

function show(next: VerificationAnswer, of: Subject, pinned: boolean): void {
  answer = next;
  subject = of;
  host.setState(of);
  showHead(next);
  showChecks(next);
  showRepairs(next);
  showRun(next, pinned);
  showWhatIf(next);
  showBlocking(next);
  const warnings = next.warnings.map(({ message, location }) => node('li', [link(message, location)]));
  update(element('assumptions'), [...warnings, ...[...next.assumptions, ...next.notes].map((it) => node('li', rich(it)))]);
}

window.addEventListener('message', ({ data }: MessageEvent<ToPage>) => {
  switch (data.type) {
    case 'answer':
      return show(data.answer, data.subject, data.pinned);
    case 'limits':
      return showLimits(data.limits);
    case 'busy': {
      const state = element('state');
      state.textContent = 'verifying …';
      state.className = 'state running';
      return notice(data.text);
    }
  }
});

element('whatIf').addEventListener('submit', (event) => {
  event.preventDefault();
  (document.activeElement as HTMLElement | null)?.blur();
  host.postMessage({ type: 'whatIf', whatIf: changes() });
});
element('reset').addEventListener('click', () => host.postMessage({ type: 'whatIf', whatIf: undefined }));
element('trace').addEventListener('click', () => host.postMessage({ type: 'trace' }));
element('dismiss').addEventListener('click', () => host.postMessage({ type: 'dismiss' }));
element('findLimits').addEventListener('click', () => host.postMessage({ type: 'findLimits' }));
element('stopLimits').addEventListener('click', () => host.postMessage({ type: 'stopLimits' }));
element('writeOut').addEventListener('click', () => host.postMessage({ type: 'writeOut' }));
host.postMessage({ type: 'ready' });
