// `dotgen verify` as a child that a cancelled test run kills.
import { spawn } from 'node:child_process';

export interface Command {
  program: string;
  arguments: string[];
  cwd: string;
  env: NodeJS.ProcessEnv;
}

export interface Ended {
  /** Standard output and the last part of the error output. */
  out: string;
  errors: string;
}

/** A report with long runs has a few megabytes. */
const MOST_OUT = 256 * 1024 * 1024;
const MOST_ERRORS = 64 * 1024;

/** Runs the program to its end. Returns undefined if `signal` killed it. Throws if it cannot be started. */
export function verify({ program, arguments: words, cwd, env }: Command, signal: AbortSignal): Promise<Ended | undefined> {
  return new Promise((resolve, reject) => {
    if (signal.aborted) return resolve(undefined);
    const child = spawn(program, words, { cwd, env, stdio: ['ignore', 'pipe', 'pipe'] });
    const kill = () => child.kill('SIGKILL');
    signal.addEventListener('abort', kill, { once: true });
    const out: string[] = [];
    let length = 0;
    let errors = '';
    child.stdout.setEncoding('utf8').on('data', (text: string) => {
      out.push(text);
      length += text.length;
      if (length > MOST_OUT) kill();
    });
    child.stderr.setEncoding('utf8').on('data', (text: string) => (errors = (errors + text).slice(-MOST_ERRORS)));
    child.on('error', reject);
    child.on('close', () => {
      signal.removeEventListener('abort', kill);
      resolve(signal.aborted ? undefined : { out: out.join(''), errors });
    });
  });
}
