// Messages of compilers in the output of `dotgen run`: in dotgen's form, with the place in a line of its own,
// or in the form of gcc and clang.
import { isAbsolute, join, normalize } from 'node:path';

export interface CompilerError {
  file: string;
  /** From 1. */
  line: number;
  column: number;
  severity: 'error' | 'warning';
  message: string;
}

/** Places that a relative path may start from. */
export interface Roots {
  /** Current directory of the program. dotgen's own paths start there. */
  cwd: string;
  /** Folder of the component. Paths of compilers start there. */
  component: string;
  exists(path: string): boolean;
}

const MOST_ERRORS = 500;
const LONGEST_LINE = 4000;
const LONGEST_MESSAGE = 1000;

const TITLE = /^(error|warning)\[codel\/compiler\]: (.*)$/;
const PLACE = /^ *--> (.+):(\d{1,9}):(\d{1,9})$/;
const COMPILER = /^(.+?):(\d{1,9}):(\d{1,9}): (?:fatal )?(error|warning): (.*)$/;

/** Returns the errors and warnings in the lines, each once. */
export function compilerErrors(lines: readonly string[], { cwd, component, exists }: Roots): CompilerError[] {
  const found = new Map<string, CompilerError>();
  const add = (file: string, roots: string[], line: string, column: string, severity: string, message: string) => {
    const places = isAbsolute(file) ? [normalize(file)] : roots.map((root) => join(root, file));
    const path = places.find(exists) ?? places[0] ?? file;
    const error = { file: path, line: Number(line), column: Number(column), severity: severity === 'error' ? 'error' : 'warning', message: message.slice(0, LONGEST_MESSAGE) } as const;
    found.set(JSON.stringify(error), error);
  };
  let title: RegExpExecArray | null = null;
  for (const line of lines.map((whole) => whole.slice(0, LONGEST_LINE))) {
    if (found.size === MOST_ERRORS) break;
    const [, of, row, column] = (title !== null && PLACE.exec(line)) || [];
    const plain = COMPILER.exec(line);
    if (title !== null && of !== undefined) add(of, [cwd, component], row ?? '1', column ?? '1', title[1] ?? '', title[2] ?? '');
    else if (plain !== null) add(plain[1] ?? '', [component, cwd], plain[2] ?? '1', plain[3] ?? '1', plain[4] ?? '', plain[5] ?? '');
    title = TITLE.exec(line);
  }
  return [...found.values()];
}
