// Values of services and ports, as docs/socket.md has them.

/** What is said of a value: JSON Schema, as far as dotgen writes it. */
export interface Schema {
  type?: string | string[];
  enum?: string[];
  anyOf?: Schema[];
  properties?: Record<string, Schema>;
  required?: string[];
  items?: Schema;
  minItems?: number;
  maxItems?: number;
  minimum?: number;
  maximum?: number;
  description?: string;
  unit?: string;
  default?: unknown;
}

/** What somebody has typed: JSON, or else a text. */
export function value(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}

/** The numbers in a value, with the members on the way to them. */
export function numbers(value: unknown, name = ''): [string, number][] {
  if (typeof value === 'number') return [[name, value]];
  if (typeof value !== 'object' || value === null) return [];
  return Object.entries(value).flatMap(([member, it]) => numbers(it, name === '' ? member : `${name}.${member}`));
}
