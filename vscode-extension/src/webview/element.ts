// Elements of the pages, and numbers in them.

export const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

export function node<K extends keyof HTMLElementTagNameMap>(tag: K, content: (Node | string)[] | string = '', className = ''): HTMLElementTagNameMap[K] {
  const it = document.createElement(tag);
  it.append(...(typeof content === 'string' ? [content] : content));
  if (className !== '') it.className = className;
  return it;
}

/** Text in which `this` is code. */
export function rich(text: string): (Node | string)[] {
  return text.split('`').map((part, i) => (i % 2 === 1 ? node('code', part) : part));
}

/** A number of a report, to what can be read. */
export const number = (it: number | undefined): string => (it === undefined ? '–' : String(Number(it.toPrecision(4))));

export const percent = (share: number): string => `${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;
