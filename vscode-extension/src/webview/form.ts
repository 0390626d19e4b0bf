// Fields of a form, made from the schema of a value.
import { value, type Schema } from '../run/values';
import { node } from './element';

/** What a value is typed into. */
export interface Field {
  node: HTMLElement;
  /** The value; undefined where nothing was given: it has its default then, or is zero. */
  read: () => unknown;
}

/** An array with more elements is a text. */
const ELEMENTS = 16;

/** A field for a value of a name; `initial` is what it holds at first. */
export function field(name: string, schema: Schema, initial: unknown = schema.default): Field {
  const { type, anyOf = [], properties, items } = schema;
  const [choice, other] = anyOf;
  if (choice?.enum !== undefined) return chosen(name, schema, choice.enum, initial);
  if (choice !== undefined && other?.type === 'null') return optional(name, schema, choice, initial);
  if (type === 'boolean') return checked(name, schema, initial);
  if (type === 'integer' || (Array.isArray(type) && type.includes('number'))) return number(name, schema, initial);
  if (type === 'string') return text(name, schema, initial, (it) => it);
  if (properties !== undefined && properties['_d'] === undefined) return members(name, schema, properties, initial);
  if (items !== undefined && (schema.minItems ?? 0) <= ELEMENTS) return elements(name, schema, items, initial);
  // A union, or what is deep in itself.
  return text(name, schema, initial === undefined || typeof initial === 'string' ? initial : JSON.stringify(initial), value, 'JSON');
}

/** A control with its name, unit and doc text. */
function labelled(name: string, { unit, description }: Schema, control: HTMLElement): HTMLElement {
  const label = node('label', [node('span', name, 'label'), control], 'field');
  if (unit !== undefined) label.append(node('span', unit, 'unit'));
  if (description !== undefined) label.append(node('span', description, 'about'));
  // Else screen readers would tell all choices as the name.
  control.setAttribute('aria-label', name);
  const said = [unit, description].filter((it) => it !== undefined);
  if (said.length > 0) control.setAttribute('aria-description', said.join(', '));
  return label;
}

function input(type: string, name: string): HTMLInputElement {
  const it = document.createElement('input');
  it.type = type;
  it.name = name;
  return it;
}

function text(name: string, schema: Schema, initial: unknown, read: (text: string) => unknown, placeholder = ''): Field {
  const it = input('text', name);
  it.placeholder = placeholder;
  if (typeof initial === 'string') it.value = initial;
  return { node: labelled(name, schema, it), read: () => (it.value === '' ? undefined : read(it.value)) };
}

function number(name: string, schema: Schema, initial: unknown): Field {
  const it = input('number', name);
  const whole = schema.type === 'integer';
  it.step = whole ? '1' : 'any';
  it.placeholder = '0';
  if (whole) {
    // What is greater would not be sent as it was typed.
    it.min = String(Math.max(schema.minimum ?? -Infinity, Number.MIN_SAFE_INTEGER));
    it.max = String(Math.min(schema.maximum ?? Infinity, Number.MAX_SAFE_INTEGER));
  }
  if (typeof initial === 'number') it.value = String(initial);
  return { node: labelled(name, schema, it), read: () => (it.value === '' ? undefined : it.valueAsNumber) };
}

function checked(name: string, schema: Schema, initial: unknown): Field {
  const it = input('checkbox', name);
  it.checked = initial === true;
  return { node: labelled(name, schema, it), read: () => it.checked };
}

function chosen(name: string, schema: Schema, names: string[], initial: unknown): Field {
  const it = document.createElement('select');
  it.name = name;
  for (const each of names) it.add(new Option(each, each, false, each === initial));
  return { node: labelled(name, schema, it), read: () => it.value };
}

function group(name: string, { unit, description }: Schema, ...content: Node[]): HTMLFieldSetElement {
  const legend = node('legend', name);
  if (unit !== undefined) legend.append(' ', node('span', unit, 'unit'));
  if (description !== undefined) legend.append(' ', node('span', description, 'about'));
  return node('fieldset', [legend, ...content]);
}

function members(name: string, schema: Schema, properties: Record<string, Schema>, initial: unknown): Field {
  const given = (typeof initial === 'object' && initial !== null ? initial : {}) as Record<string, unknown>;
  // In order of declaration, which objects of JSON do not keep.
  const names = schema.required ?? Object.keys(properties);
  const all = names.map((it) => [it, field(it, properties[it] ?? {}, given[it] ?? properties[it]?.default)] as const);
  const read = () => {
    const out = all.map(([it, { read }]) => [it, read()] as const).filter(([, it]) => it !== undefined);
    return Object.fromEntries(out);
  };
  return { node: group(name, schema, ...all.map(([, it]) => it.node)), read };
}

function elements(name: string, schema: Schema, items: Schema, initial: unknown): Field {
  const { minItems = 0, maxItems = Infinity } = schema;
  const given = Array.isArray(initial) ? initial : [];
  const all: Field[] = [];
  const list = node('div', [], 'elements');
  const more = node('button', 'Add', 'more');
  const less = node('button', 'Remove', 'less');
  const add = (value?: unknown): void => {
    const it = field(`${name}[${all.length}]`, items, value ?? items.default);
    all.push(it);
    list.append(it.node);
    settle();
  };
  const settle = (): void => {
    more.disabled = all.length >= maxItems;
    less.disabled = all.length <= minItems;
  };
  for (const button of [more, less]) {
    button.type = 'button';
    button.setAttribute('aria-label', `${button.textContent ?? ''} an element of ${name}`);
  }
  more.addEventListener('click', () => add());
  less.addEventListener('click', () => {
    all.pop()?.node.remove();
    settle();
  });
  settle();
  for (let i = 0; i < Math.max(minItems, given.length); i++) add(given[i]);
  const isFixed = minItems === maxItems;
  // A hole would move what follows: null is zero.
  const read = () => all.map((it) => it.read() ?? null);
  return { node: group(name, schema, list, ...(isFixed ? [] : [more, less])), read };
}

function optional(name: string, schema: Schema, of: Schema, initial: unknown): Field {
  const given = input('checkbox', `${name} is given`);
  given.checked = initial !== undefined && initial !== null;
  const { unit, description } = schema;
  const said = { ...(unit === undefined ? {} : { unit }), ...(description === undefined ? {} : { description }) };
  const inner = field(name, { ...of, ...said }, initial ?? of.default);
  inner.node.hidden = !given.checked;
  given.addEventListener('change', () => (inner.node.hidden = !given.checked));
  const head = node('label', [given, node('span', `${name} is given`, 'label')], 'field');
  // Of a number that is not typed null would mean that it is not given.
  return { node: node('div', [head, inner.node], 'optional'), read: () => (given.checked ? (inner.read() ?? zero(of)) : null) };
}

function zero({ type }: Schema): unknown {
  if (type === 'string') return '';
  return type === undefined ? {} : 0;
}
