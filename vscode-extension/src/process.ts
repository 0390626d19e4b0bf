// The process of the server. A client cannot stop a server that is starting, so the process is ended here.
//
// Nothing here needs the editor, so that a start is tested without one.
import { execFile, spawn, type ChildProcess } from 'node:child_process';

const IS_WINDOWS = process.platform === 'win32';
/** Time that a server has to end after `exit`. */
const END_MS = 2000;

export interface Program {
  command: string;
  arguments: string[];
  env: NodeJS.ProcessEnv;
  cwd: string | undefined;
}

export class ServerProcess {
  private child: ChildProcess | undefined;
  private timer: NodeJS.Timeout | undefined;
  private isOver = false;

  constructor(
    private readonly program: Program,
    /** Time that a start may take, in milliseconds. */
    private readonly limit: number,
    /** A start took too long, and its process was killed. */
    private readonly late: () => void,
  ) {}

  /** Starts the program. The client calls this again after the process has ended. */
  spawn(): Promise<ChildProcess> {
    if (this.isOver) return Promise.reject(new Error('the start was given up'));
    const { command, arguments: words, env, cwd } = this.program;
    // A group of its own: a wrapper script is killed with what it started.
    const child = spawn(command, words, { env, cwd, detached: !IS_WINDOWS });
    this.child = child;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.kill();
      this.late();
    }, this.limit);
    child.once('exit', () => this.child === child && clearTimeout(this.timer));
    return new Promise((resolve, reject) => {
      child.once('spawn', () => resolve(child));
      child.on('error', (error) => {
        if (this.child === child) clearTimeout(this.timer);
        reject(error);
      });
    });
  }

  /** The server has answered: its start is over. */
  started(): void {
    clearTimeout(this.timer);
  }

  /** Kills the process, unless it ends by itself soon. */
  end(): void {
    this.isOver = true;
    clearTimeout(this.timer);
    const later = setTimeout(() => this.kill(), END_MS);
    this.child?.once('exit', () => clearTimeout(later));
  }

  kill(): void {
    this.isOver = true;
    clearTimeout(this.timer);
    const { child } = this;
    if (child?.pid === undefined || child.exitCode !== null || child.signalCode !== null) return;
    if (IS_WINDOWS) {
      execFile('taskkill', ['/T', '/F', '/PID', String(child.pid)], () => {});
      return;
    }
    try {
      process.kill(-child.pid, 'SIGKILL');
    } catch {
      // The group has ended meanwhile.
    }
  }
}
