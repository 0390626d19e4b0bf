// `dotgen run` as a child: one run, and the view of it.
import { spawn, type ChildProcess } from 'node:child_process';
import { mkdtempSync, rmSync, existsSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { isAbsolute, join } from 'node:path';
import { createInterface } from 'node:readline';
import type { Report, RunState, RunView } from './messages';
import type { Question } from './measured';
import { Talk } from './talk';

/** Lines of the log that are kept. */
const LINES = 500;

export interface RunOptions {
  /** The program. */
  command: string;
  env: NodeJS.ProcessEnv;
  /** A scenario or specification on disk. */
  file: string;
  cwd: string;
  clock: RunView['clock'];
  /** Is told of each component that waits for a debugger; without it they wait for none. */
  waiting?: ((host: Host) => void) | undefined;
  /** How specifications are read, where the editor is set to something. */
  reading?: Reading;
}

/** A component that waits for a debugger. */
export interface Host {
  component: string;
  process: number;
}

/** Settings of the editor that decide how a specification is read; `dotgen run` finds those of dotgen.toml itself. */
export interface Reading {
  includePaths?: string[];
  defines?: Record<string, boolean | number | string>;
  release?: string;
}

export class Run {
  private readonly child: ChildProcess;
  private readonly folder = mkdtempSync(join(tmpdir(), 'dotgen-'));
  private readonly talk: Talk | undefined;
  private readonly log: string[] = [];
  private state: RunState = 'starting';
  private report: Report | null = null;
  private said = '';

  constructor(
    private readonly options: RunOptions,
    private readonly name: string,
    /** Something is to be shown anew. */
    private readonly changed: () => void,
  ) {
    const socket = join(this.folder, 'run.sock');
    this.child = spawn(options.command, argumentsOf(options, this.trace, socket, this.profile), { cwd: options.cwd, env: options.env, stdio: ['ignore', 'pipe', 'pipe'] });
    const { stdout, stderr } = this.child;
    stdout?.setEncoding('utf8').on('data', (text: string) => this.hear(text));
    if (stderr !== null) createInterface({ input: stderr, crlfDelay: Infinity }).on('line', (line) => this.tell(line));
    this.child.on('error', (error) => this.finish(error.message));
    this.child.on('close', (code, signal) => this.finish(code === null ? `ended by ${signal}` : ''));
    this.child.on('spawn', () => this.state === 'starting' && this.become('running'));
    if (options.clock === 'real') {
      this.talk = new Talk(socket, changed);
    }
  }

  /** The first run, for the trace viewer. */
  get trace(): string {
    return join(this.folder, 'run.json');
  }

  /** Every run of a codel, in the format of GenoM3's profiler. */
  private get profile(): string {
    return join(this.folder, 'run.out');
  }

  /** How execution times are read from this run; undefined before it has ended, and of what somebody looked at in a debugger. */
  get question(): Question | undefined {
    if (!this.isOver || this.options.waiting !== undefined || !existsSync(this.profile)) return undefined;
    const { command, env, cwd, file, reading } = this.options;
    return { command, env, cwd, arguments: [this.profile, file, ...readingOf(reading, cwd)] };
  }

  get isOver(): boolean {
    return this.state === 'ended' || this.state === 'failed';
  }

  get view(): RunView {
    const { talk } = this;
    return {
      name: this.name,
      clock: this.options.clock,
      debug: this.options.waiting !== undefined,
      state: this.state,
      report: this.report,
      progress: talk?.progress ?? null,
      violations: talk?.violations ?? [],
      simulated: talk?.simulated ?? [],
      times: 0,
      hasTrace: this.isOver && existsSync(this.trace),
      services: talk?.services ?? [],
      ports: talk?.ports ?? [],
      log: this.log,
    };
  }

  /** Ends the run, which then tells what happened until now. The second time it ends at once. */
  stop(): void {
    if (this.isOver) return;
    this.child.kill('SIGINT');
    this.become('stopping');
  }

  call(service: string, inputs: Record<string, unknown>): void {
    this.talk?.call(service, inputs);
  }

  abort(service: string): void {
    this.talk?.abort(service);
  }

  dispose(): void {
    this.talk?.end();
    this.child.kill('SIGTERM');
    rmSync(this.folder, { recursive: true, force: true });
  }

  /** What the program writes: a line for each component that waits, then the report. */
  private hear(text: string): void {
    this.said += text;
    const { waiting } = this.options;
    if (waiting === undefined) return;
    for (let end = this.said.indexOf('\n'); end !== -1; end = this.said.indexOf('\n')) {
      const host = hostOf(this.said.slice(0, end));
      if (host === undefined) return;
      this.said = this.said.slice(end + 1);
      waiting(host);
    }
  }

  private tell(line: string): void {
    this.log.push(line);
    if (this.log.length > LINES) this.log.shift();
    this.changed();
  }

  private finish(why: string): void {
    if (this.isOver) return;
    this.talk?.end();
    if (why !== '') this.log.push(why);
    this.report = reportOf(this.said);
    this.become(this.report === null ? 'failed' : 'ended');
  }

  private become(state: RunState): void {
    this.state = state;
    this.changed();
  }
}

/** Of `dotgen run`. */
export function argumentsOf({ file, clock, cwd, waiting, reading }: RunOptions, trace: string, socket: string, profile: string): string[] {
  // A robot does not wait for a search; what is verified is in the verification panel.
  const how = clock === 'real'
    ? ['--clock', 'real', '--bounds', 'analysed', '--socket', socket]
    : [...(waiting === undefined ? ['--simulate', 'all'] : []), '--trace', trace];
  const debug = waiting === undefined ? [] : ['--debug'];
  return ['run', file, ...how, ...debug, '--profile', profile, ...readingOf(reading, cwd), '--format', 'json'];
}

/** How specifications are read, as arguments. */
export function readingOf({ includePaths = [], defines = {}, release = '' }: Reading = {}, cwd: string): string[] {
  const include = includePaths.flatMap((it) => ['-I', isAbsolute(it) ? it : join(cwd, it)]);
  const defined = Object.entries(defines).filter(([, body]) => body !== false);
  const define = defined.flatMap(([name, body]) => ['-D', body === true ? name : `${name}=${body}`]);
  return [...include, ...define, ...(release === '' ? [] : ['--release', release])];
}

/** A line of the program about a component that waits; undefined if it is none. */
export function hostOf(line: string): Host | undefined {
  try {
    const it = JSON.parse(line) as Partial<Host> | null;
    return typeof it?.component === 'string' && typeof it.process === 'number' ? { component: it.component, process: it.process } : undefined;
  } catch {
    return undefined;
  }
}

/** What the program wrote; null if that is no report of one run. */
export function reportOf(text: string): Report | null {
  try {
    const it = JSON.parse(text) as Partial<Report> | null;
    return Array.isArray(it?.tasks) ? (it as Report) : null;
  } catch {
    return null;
  }
}
