// The server program: the one of the setting, then the one packaged with the extension, then the one on PATH.
//
// Nothing here needs the editor: the surroundings are a parameter, so that the search is tested without one.
import { accessSync, chmodSync, constants, existsSync, statSync } from 'node:fs';
import { homedir } from 'node:os';
import { delimiter, isAbsolute, join } from 'node:path';

/** What the search looks at. */
export interface Surroundings {
  /** Value of `dotgen.server.path`; empty when not set. */
  setting: string;
  /** The program of the package, if it has one. */
  packaged: string | undefined;
  /** Root of the first workspace folder, if any. */
  workspaceRoot: string | undefined;
  env: Record<string, string | undefined>;
  platform: NodeJS.Platform;
  homeDirectory: string;
  isExecutable(path: string): boolean;
}

/** A server program, or why there is none. */
export type Located =
  | { found: true; path: string; origin: 'setting' | 'package' | 'PATH' }
  | { found: false; reason: 'setting' | 'package' | 'nowhere'; message: string };

export function locateServer(at: Surroundings): Located {
  const setting = at.setting.trim();
  if (setting !== '') {
    const path = expandPath(setting, at);
    if (at.isExecutable(path)) {
      return { found: true, path, origin: 'setting' };
    }
    // No fallback: running another server than the one asked for would only confuse.
    const message = `dotgen.server.path is "${setting}", but ${path} is not a program that can be run. Correct the setting, or clear it to use the packaged server.`;
    return { found: false, reason: 'setting', message };
  }
  if (at.packaged !== undefined) {
    if (at.isExecutable(at.packaged)) {
      return { found: true, path: at.packaged, origin: 'package' };
    }
    const message = `${at.packaged} cannot be executed: the file or its file system forbids that. Set dotgen.server.path to a dotgen elsewhere.`;
    return { found: false, reason: 'package', message };
  }
  for (const directory of searchPath(at.env)) {
    const path = join(directory, programName(at.platform));
    if (isAbsolute(directory) && at.isExecutable(path)) {
      return { found: true, path, origin: 'PATH' };
    }
  }
  const message =
    'No dotgen server found: this package of the extension has none for your system, and there is no "dotgen" on PATH. Install dotgen, or set dotgen.server.path.';
  return { found: false, reason: 'nowhere', message };
}

/** Replaces `~`, `${workspaceFolder}`, `${userHome}` and `${env:NAME}`; a relative path starts at the workspace root. */
export function expandPath(path: string, at: Pick<Surroundings, 'env' | 'homeDirectory' | 'workspaceRoot'>): string {
  const expanded = path
    .replace(/^~(?=$|[\\/])/, () => at.homeDirectory)
    .replace(/\$\{workspaceFolder\}/g, () => at.workspaceRoot ?? '')
    .replace(/\$\{userHome\}/g, () => at.homeDirectory)
    .replace(/\$\{env:([^}]+)\}/g, (_, name: string) => at.env[name] ?? '');
  return isAbsolute(expanded) || at.workspaceRoot === undefined ? expanded : join(at.workspaceRoot, expanded);
}

function searchPath(env: Record<string, string | undefined>): string[] {
  // On Windows the variable may be spelled `Path`.
  const name = Object.keys(env).find((key) => key.toUpperCase() === 'PATH');
  return (name === undefined ? '' : (env[name] ?? '')).split(delimiter).filter((directory) => directory !== '');
}

const programName = (platform: NodeJS.Platform) => (platform === 'win32' ? 'dotgen.exe' : 'dotgen');

/** The program of the extension in `folder`. A package that was made on Windows, or copied, lacks the permission to execute. */
export function packagedProgram(folder: string): string | undefined {
  const program = join(folder, 'server', programName(process.platform));
  if (!existsSync(program)) {
    return undefined;
  }
  try {
    if (!isExecutable(program)) chmodSync(program, 0o755);
  } catch {
    // Not the owner: the search reports the program.
  }
  return program;
}

/** The real surroundings of the extension in `folder`. */
export function surroundings(setting: string, folder: string, workspaceRoot: string | undefined): Surroundings {
  return {
    setting,
    packaged: packagedProgram(folder),
    workspaceRoot,
    env: process.env,
    platform: process.platform,
    homeDirectory: homedir(),
    isExecutable,
  };
}

function isExecutable(path: string): boolean {
  try {
    accessSync(path, constants.X_OK);
    return statSync(path).isFile();
  } catch {
    return false;
  }
}
