// The services of a run: a form each, folded by component.
import type { FromPage, Service } from '../run/messages';
import { node } from './element';
import { field } from './form';
import { byComponent, matches } from './summary';

/** A system with at most as many services has its components open at first. */
const FEW = 3;

/** Inputs that were typed, and components that were opened: the page is made anew when it is shown again. */
export interface Typed {
  /** Of the run. */
  name: string;
  inputs: Record<string, Record<string, unknown>>;
  /** Components that are open; undefined before the first was opened or closed. */
  open?: string[];
  filter?: string;
}

export interface Host {
  postMessage(message: FromPage): void;
  getState(): Typed | undefined;
  setState(state: Typed): void;
}

interface Group {
  all: HTMLDetailsElement;
  about: HTMLElement;
  forms: Map<string, HTMLFormElement>;
}

export class Services {
  private groups = new Map<string, Group>();
  /** Of the run and its services: other names make other forms. */
  private key = '';
  private run = '';
  private filter = '';

  constructor(
    private readonly section: HTMLElement,
    private readonly host: Host,
  ) {}

  /** Returns the values that were typed for a run. */
  typed(run: string): Typed {
    const state = this.host.getState();
    return state?.name === run ? state : { name: run, inputs: {} };
  }

  /** Shows the services that match a filter. A form is made once, so typed inputs stay. */
  show(run: string, services: readonly Service[], over: boolean, filter: string): void {
    const key = [run, ...services.map((it) => it.name)].join(' ');
    if (key !== this.key) this.make(key, run, services);
    const isOther = filter !== this.filter;
    this.filter = filter;
    for (const [component, own] of byComponent(services)) {
      const group = this.groups.get(component) as Group;
      const found = own.filter((it) => matches(filter, it));
      const active = own.filter((it) => it.active).length;
      const count = filter === '' || found.length === own.length ? String(own.length) : `${found.length} of ${own.length}`;
      const about = `${count} ${own.length === 1 ? 'service' : 'services'}${active > 0 ? ` · ${active} active` : ''}`;
      if (group.about.textContent !== about) group.about.textContent = about;
      group.all.hidden = found.length === 0;
      for (const it of own) {
        const form = group.forms.get(it.name) as HTMLFormElement;
        form.hidden = !found.includes(it);
        answer(form, it, over);
      }
      if (isOther) group.all.open = filter === '' ? this.opened(services).includes(component) : found.length > 0;
    }
    this.section.hidden = [...this.groups.values()].every((it) => it.all.hidden);
  }

  /** Moves the focus to the first control of the first form that is shown; false if there is none. */
  focus(): boolean {
    const control = this.section.querySelector<HTMLElement>('details:not([hidden])[open] form:not([hidden]) :is(input, select, button)');
    control?.focus();
    return control !== null;
  }

  private opened(services: readonly Service[]): string[] {
    return this.typed(this.run).open ?? (services.length > FEW ? [] : [...byComponent(services).keys()]);
  }

  private make(key: string, run: string, services: readonly Service[]): void {
    this.key = key;
    this.run = run;
    this.groups = new Map();
    const opened = this.opened(services);
    for (const [component, own] of byComponent(services)) {
      const forms = new Map(own.map((it) => [it.name, this.form(it)]));
      const about = node('span', '', 'faint');
      const all = node('details', [node('summary', [node('span', component, 'name'), about]), ...forms.values()], 'component');
      all.open = opened.includes(component);
      all.addEventListener('toggle', () => this.toggled());
      this.groups.set(component, { all, about, forms });
    }
    const shown = [...this.groups.values()].map((it) => it.all);
    (this.section.querySelector('.all') as Element).replaceChildren(...shown);
    // The filter opens what matches in new forms too.
    this.filter = '';
  }

  private toggled(): void {
    // A component that a filter opens is not kept.
    if (this.filter !== '') return;
    const open = [...this.groups].filter(([, it]) => it.all.open).map(([name]) => name);
    this.host.setState({ ...this.typed(this.run), open });
  }

  private form({ name, doc, inputs }: Service): HTMLFormElement {
    const { host, run } = this;
    const send = node('button', 'Send');
    send.setAttribute('aria-label', `Send ${name}`);
    const abort = node('button', 'Interrupt');
    abort.type = 'button';
    abort.hidden = true;
    abort.setAttribute('aria-label', `Interrupt ${name}`);
    abort.addEventListener('click', () => host.postMessage({ type: 'abort', service: name }));
    const before = this.typed(run).inputs[name] ?? {};
    const fields = inputs.map((it) => [it.name, field(it.name, it.schema, before[it.name])] as const);
    const given = () => Object.fromEntries(fields.map(([name, it]) => [name, it.read()] as const).filter(([, it]) => it !== undefined));
    const said = node('span', '', 'answer');
    said.setAttribute('role', 'status');
    const head = node('div', [node('span', name, 'name'), ...(doc ? [node('span', doc, 'doc')] : [])], 'head');
    const inside = node('div', fields.map(([, it]) => it.node), 'fields');
    const made = node('form', [head, inside, node('div', [send, abort, said], 'foot')], inputs.length === 0 ? 'bare' : '');
    made.setAttribute('aria-label', name);
    made.addEventListener('submit', (event) => {
      event.preventDefault();
      host.postMessage({ type: 'call', service: name, inputs: given() });
    });
    const keep = (): void => {
      const now = this.typed(run);
      host.setState({ ...now, inputs: { ...now.inputs, [name]: given() } });
    };
    // A click makes a list longer or shorter.
    if (inputs.length > 0) for (const it of ['input', 'change', 'click']) made.addEventListener(it, keep);
    return made;
  }
}

function answer(form: HTMLFormElement, service: Service, over: boolean): void {
  const said = form.querySelector('.answer');
  if (said !== null && said.textContent !== service.answer) said.textContent = service.answer;
  const [send, abort] = form.querySelectorAll<HTMLButtonElement>('.foot button');
  if (send !== undefined) send.disabled = over;
  if (abort !== undefined) abort.hidden = over || !service.active;
}
