// The checks of a scenario as they are written. Scenarios that are not open are listed too. Their text is
// read here, because the server verifies every scenario that is opened.

export interface WrittenCheck {
  /** Name before the colon, if it has one. */
  name: string | undefined;
  /** `schedulable`, `response`, and so on. */
  kind: string;
  /** The whole check in one line, without `;`. */
  text: string;
  /** Offsets in the text of the scenario. */
  start: number;
  end: number;
}

/** Comments, strings, names and marks. Other characters are skipped. */
const TOKEN = /\/\/[^\n]*|\/\*(?:[^*]|\*(?!\/))*(?:\*\/|$)|"[^"\n]*"?|no-overdue|[A-Za-z_]\w*|[{}:;]/g;
/** A scenario of this many checks is written by nobody. */
const MOST = 1000;

/** Returns the checks of a scenario, in order. A check that never ends is left out. */
export function checksOf(text: string): WrittenCheck[] {
  const checks: WrittenCheck[] = [];
  let depth = 0;
  let words: string[] | undefined;
  let start = 0;
  let before = '';
  for (const { 0: token, index } of text.matchAll(TOKEN)) {
    if (token.startsWith('/')) continue;
    if (token === '{' || token === '}') {
      depth += token === '{' ? 1 : -1;
      words = undefined;
    } else if (words !== undefined && token === ';') {
      checks.push(check(text, start, index, words));
      words = undefined;
      if (checks.length === MOST) break;
    } else if (words !== undefined) {
      words.push(token);
    } else if (depth === 1 && token === 'check' && ['{', '}', ';'].includes(before)) {
      words = [];
      start = index;
    }
    before = token;
  }
  return checks;
}

function check(text: string, start: number, end: number, words: string[]): WrittenCheck {
  const name = words[1] === ':' ? words[0] : undefined;
  const kind = (name === undefined ? words[0] : words[2]) ?? '';
  return { name, kind, text: text.slice(start, end).replace(/\s+/g, ' ').trim(), start, end: end + 1 };
}
