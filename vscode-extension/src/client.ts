// The language client: one server process for the window, started, watched and restarted.
import { existsSync } from 'node:fs';
import { createInterface } from 'node:readline';
import type { Readable } from 'node:stream';
import * as vscode from 'vscode';
import {
  CloseAction,
  ErrorAction,
  LanguageClient,
  LSPErrorCodes,
  ResponseError,
  RevealOutputChannelOn,
  State,
  vsdiag,
  type CloseHandlerResult,
  type LanguageClientOptions,
  type MessageSignature,
} from 'vscode-languageclient/node';
import { SECTION, explicitSettings, serverSettingNames, serverSettings } from './config';
import { previewed } from './manual';
import type { OfferedCommands } from './offered';
import { withMachine } from './preview/hover';
import { ServerProcess, type Program } from './process';
import { LANGUAGE, SCENARIO, TEMPLATE, documentText, verificationStatus, type InitializationOptions, type VerificationStatus } from './protocol';
import { reviewed } from './review';
import { locateServer, surroundings, type Located } from './server';
import { done } from './walkthrough';

/** What the server is doing. */
export type ServerState =
  | { kind: 'stopped' }
  | { kind: 'starting' }
  | { kind: 'ready' }
  | { kind: 'busy'; activity: string }
  | { kind: 'failed'; reason: string };

/** The program that is running, for display. */
export interface ServerInfo {
  path: string;
  origin: string;
  name: string;
  version: string;
}

/** Whether a request failed because the text had changed, or was given up for a newer one. */
export function overtaken(error: unknown): boolean {
  const codes: number[] = [LSPErrorCodes.ContentModified, LSPErrorCodes.RequestCancelled, LSPErrorCodes.ServerCancelled];
  return error instanceof ResponseError && codes.includes(error.code);
}

// A server that ends this often within the window is not started again by itself.
const MAX_RESTARTS = 4;
const RESTART_WINDOW_MS = 3 * 60 * 1000;
// A server that has not answered by then is killed.
const START_MS = 30_000;
// A failed start is told once it is clear that the end of the process has not led to another attempt.
const START_FAILURE_GRACE_MS = 500;

export class Server implements vscode.Disposable {
  private client: LanguageClient | undefined;
  private process: ServerProcess | undefined;
  private located: Located | undefined;
  private state: ServerState = { kind: 'stopped' };
  private readonly changed = new vscode.EventEmitter<ServerState>();
  /** Fires whenever the state, or what is known of the server, has changed. */
  readonly onDidChange = this.changed.event;
  private readonly verified = new vscode.EventEmitter<VerificationStatus>();
  /** Fires when a verification begins, ends, or is overtaken by an edit. */
  readonly onDidVerify = this.verified.event;
  // Starts and stops are queued: two restarts in a row must not leave two processes. None waits for an answer of the server.
  private queue: Promise<void> = Promise.resolve();
  // When the process ended unexpectedly, in milliseconds.
  private readonly ends: number[] = [];
  private startError = '';
  private readonly activities = new Map<string | number, string>();
  private disposed = false;

  constructor(
    private readonly extension: vscode.Extension<unknown>,
    /** What the extension does. */
    private readonly log: vscode.LogOutputChannel,
    /** What the server writes, and the messages when they are traced. */
    readonly output: vscode.LogOutputChannel,
    private readonly offered: OfferedCommands,
  ) {}

  private get settingNames(): string[] {
    return serverSettingNames(this.extension.packageJSON as Parameters<typeof serverSettingNames>[0]);
  }

  /** The code of a finding leads to its page of the manual, shown as Markdown is. */
  private linked(it: vscode.Diagnostic): vscode.Diagnostic {
    if (typeof it.code === 'object') {
      it.code = { ...it.code, target: previewed(it.code.target, this.extension.extensionUri) };
    }
    return it;
  }

  get current(): ServerState {
    return this.state;
  }

  /** The client, if it can take requests. */
  get running(): LanguageClient | undefined {
    return this.state.kind === 'ready' || this.state.kind === 'busy' ? this.client : undefined;
  }

  get info(): ServerInfo | undefined {
    if (this.located?.found !== true) {
      return undefined;
    }
    const info = this.client?.initializeResult?.serverInfo;
    return { path: this.located.path, origin: this.located.origin, name: info?.name ?? 'dotgen', version: info?.version ?? '' };
  }

  start(): Promise<void> {
    return this.enqueue(() => this.launch());
  }

  stop(): Promise<void> {
    return this.enqueue(() => this.shutDown());
  }

  restart(): Promise<void> {
    return this.enqueue(async () => {
      await this.shutDown();
      await this.launch();
    });
  }

  async dispose(): Promise<void> {
    this.disposed = true;
    await this.stop();
    this.changed.dispose();
  }

  private enqueue(step: () => Promise<void>): Promise<void> {
    this.queue = this.queue.then(step).catch((error: unknown) => this.fail(text(error)));
    return this.queue;
  }

  private async launch(): Promise<void> {
    if (this.disposed) {
      return;
    }
    const settings = serverSettings();
    const root = vscode.workspace.workspaceFolders?.[0]?.uri;
    this.set({ kind: 'starting' });
    const located = locateServer(surroundings(settings.path, this.extension.extensionPath, root?.scheme === 'file' ? root.fsPath : undefined));
    this.located = located;
    if (!located.found) {
      this.fail(located.message);
      return;
    }
    if (this.disposed) {
      return;
    }
    const command = located.path;
    this.log.info(`starting ${command} (${located.origin})`);
    this.activities.clear();
    const process = new ServerProcess(this.program(located), START_MS, () => {
      if (this.process === process) {
        this.fail(`The server ${command} did not answer within ${START_MS / 1000} s and was stopped. Read its output, then correct dotgen.server.path or restart the server.`);
      }
    });
    this.process = process;
    const client = new LanguageClient(SECTION, 'dotgen', () => process.spawn(), this.clientOptions(process));
    this.client = client;
    client.onDidChangeState(({ newState }) => {
      if (this.client !== client) {
        return;
      }
      if (newState === State.Running) {
        process.started();
        const { name, version } = client.initializeResult?.serverInfo ?? { name: 'server', version: '' };
        this.log.info(`${name} ${version ?? ''} is ready`);
        this.set({ kind: 'ready' });
      } else if (newState === State.StartFailed) {
        setTimeout(() => {
          if (this.client === client && client.state === State.StartFailed && this.state.kind === 'starting') {
            process.kill();
            this.fail(`The server ${command} could not be started: ${this.startError}`);
          }
        }, START_FAILURE_GRACE_MS);
      }
    });
    client.onNotification(verificationStatus, (status) => this.verified.fire(status));
    client.onRequest(documentText, ({ uri }) => {
      const wanted = client.protocol2CodeConverter.asUri(uri).toString();
      const document = vscode.workspace.textDocuments.find((it) => it.uri.toString() === wanted);
      return document ? { version: document.version, text: document.getText() } : null;
    });
    client.start().catch((error: unknown) => {
      this.startError = text(error);
      this.log.warn(`start: ${this.startError}`);
    });
  }

  private program({ path: command }: Located & { found: true }): Program {
    const { extraEnv, logLevel } = serverSettings();
    // The level is that of dotgen's own modules; libraries are quiet unless something is wrong.
    const log = logLevel === 'error' ? 'error' : `warn,dotgen=${logLevel}`;
    const folder = vscode.workspace.workspaceFolders?.[0]?.uri;
    const cwd = folder?.scheme === 'file' && existsSync(folder.fsPath) ? folder.fsPath : undefined;
    return { command, arguments: ['lsp'], cwd, env: { ...process.env, DOTGEN_LOG: log, ...extraEnv } };
  }

  private clientOptions(process: ServerProcess): LanguageClientOptions {
    return {
      documentSelector: [
        { language: LANGUAGE, scheme: 'file' },
        { language: LANGUAGE, scheme: 'untitled' },
        { language: SCENARIO, scheme: 'file' },
        { language: SCENARIO, scheme: 'untitled' },
        { language: TEMPLATE, scheme: 'file' },
      ],
      outputChannel: this.output,
      traceOutputChannel: this.output,
      // A request that fails is in the output; what the user has to know is told by the server, or below.
      revealOutputChannelOn: RevealOutputChannelOn.Never,
      stdioOptions: { stdout: forwardLog, stderr: forwardLog },
      initializationOptions: (): InitializationOptions => ({ trusted: vscode.workspace.isTrusted, verificationStatus: true, documentText: true, runs: vscode.workspace.isTrusted }),
      initializationFailedHandler: (error) => {
        this.startError = text(error);
        return false;
      },
      errorHandler: {
        // A server that died breaks every request on its way, and is started again once the connection is seen to be closed.
        error: (error: Error) => {
          this.log.error(`connection: ${error.message}`);
          return { action: ErrorAction.Continue, handled: true };
        },
        closed: () => this.ended(process),
      },
      middleware: {
        workspace: {
          // Only what is set; the server knows its defaults, and what dotgen.toml says.
          configuration: async (params, token, next) => {
            const whole = await next(params, token);
            if (!Array.isArray(whole)) {
              return whole;
            }
            return whole.map((value, i) => {
              const { section, scopeUri } = params.items[i] ?? {};
              return section === SECTION ? explicitSettings(this.settingNames, scopeUri === undefined ? undefined : vscode.Uri.parse(scopeUri)) : value;
            });
          },
        },
        provideHover: async (document, position, token, next) => {
          const hover = await next(document, position, token);
          return hover && withMachine(this.running, document, position, hover, token);
        },
        // The details stand behind the title.
        provideCodeLenses: async (document, token, next) => {
          const lenses = await next(document, token);
          lenses?.forEach(withDetails);
          return lenses;
        },
        resolveCodeLens: async (lens, token, next) => {
          const resolved = await next(lens, token);
          return resolved && withDetails(resolved);
        },
        provideCodeActions: async (document, range, context, token, next) => {
          const actions = await next(document, range, context, token);
          this.offered.keep(actions);
          return actions;
        },
        resolveCodeAction: async (item, token, next) => {
          const action = await next(item, token);
          this.offered.keep(action && [action]);
          return action;
        },
        handleDiagnostics: (uri, diagnostics, next) => next(uri, diagnostics.map((it) => this.linked(it))),
        provideDiagnostics: async (document, previous, token, next) => {
          const report = await next(document, previous, token);
          return report?.kind === vsdiag.DocumentDiagnosticReportKind.full ? { ...report, items: report.items.map((it) => this.linked(it)) } : report;
        },
        provideWorkspaceDiagnostics: (previous, token, reporter, next) =>
          next(previous, token, (chunk) =>
            reporter(
              chunk && {
                items: chunk.items.map((it) => (it.kind === vsdiag.DocumentDiagnosticReportKind.full ? { ...it, items: it.items.map((one) => this.linked(one)) } : it)),
              },
            ),
          ),
        sendRequest: async <P, R>(
          type: string | MessageSignature,
          param: P | undefined,
          token: vscode.CancellationToken | undefined,
          next: (type: string | MessageSignature, param?: P, token?: vscode.CancellationToken) => Promise<R>,
        ): Promise<R> => reviewed(typeof type === 'string' ? type : type.method, await next(type, param, token)) as R,
        // Actions of the server that ask something have better questions here.
        executeCommand: (command, args, next) => {
          // The action that writes a stub shows the stub.
          if (command === 'dotgen.showCodel') done('stubs');
          const ours = { 'dotgen.generate': 'dotgen.generateFiles', 'dotgen.regenerate': 'dotgen.regenerateFiles' }[command];
          return ours === undefined ? next(command, args) : vscode.commands.executeCommand(ours, ...args);
        },
        handleWorkDoneProgress: (token, params, next) => {
          if (params.kind === 'end') {
            this.activities.delete(token);
          } else if (params.kind === 'begin') {
            this.activities.set(token, params.title);
          }
          this.showActivity();
          next(token, params);
        },
      },
    };
  }

  private ended(process: ServerProcess): CloseHandlerResult {
    if (this.disposed || this.state.kind === 'failed' || this.process !== process) {
      return { action: CloseAction.DoNotRestart, handled: true };
    }
    const now = Date.now();
    this.ends.push(now);
    while (this.ends.length > 0 && now - (this.ends[0] ?? now) > RESTART_WINDOW_MS) {
      this.ends.shift();
    }
    this.activities.clear();
    if (this.ends.length <= MAX_RESTARTS) {
      this.log.warn('the server ended unexpectedly; starting it again');
      this.set({ kind: 'starting' });
      return { action: CloseAction.Restart, handled: true };
    }
    this.fail(`The server ended ${this.ends.length} times within three minutes and is not started again. Its output says why.`);
    return { action: CloseAction.DoNotRestart, handled: true };
  }

  private async shutDown(): Promise<void> {
    const { client, process } = this;
    this.client = undefined;
    this.process = undefined;
    this.ends.length = 0;
    this.activities.clear();
    if (client !== undefined) {
      try {
        await client.dispose();
        process?.end();
      } catch (error) {
        // A server that is starting, or that is gone, cannot be asked to stop.
        process?.kill();
        this.log.debug(`stopping: ${text(error)}`);
      }
    }
    this.set({ kind: 'stopped' });
  }

  private showActivity(): void {
    if (this.state.kind === 'ready' || this.state.kind === 'busy') {
      const activity = [...this.activities.values()].at(-1);
      this.set(activity === undefined ? { kind: 'ready' } : { kind: 'busy', activity });
    }
  }

  private fail(reason: string): void {
    this.log.error(reason);
    this.set({ kind: 'failed', reason });
  }

  private set(state: ServerState): void {
    this.state = state;
    if (!this.disposed) {
      this.changed.fire(state);
    }
  }
}

const LOG_LINE = /^\S+Z\s+(TRACE|DEBUG|INFO|WARN|ERROR)\s+(.*)$/;

/** Shows the server's log at the levels its lines have; other lines (of a crash) as errors. */
function forwardLog(stream: Readable, channel: vscode.LogOutputChannel): void {
  createInterface({ input: stream, crlfDelay: Infinity }).on('line', (line) => {
    const [, level, message = line] = LOG_LINE.exec(line) ?? [];
    switch (level) {
      case 'TRACE':
        return channel.trace(message);
      case 'DEBUG':
        return channel.debug(message);
      case 'INFO':
        return channel.info(message);
      case 'WARN':
        return channel.warn(message);
      default:
        return channel.error(message);
    }
  });
}

function text(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** Shows the details of a lens when the pointer rests on it. */
function withDetails(lens: vscode.CodeLens): vscode.CodeLens {
  const { tooltip } = (lens.command?.arguments?.[0] ?? {}) as { tooltip?: string };
  if (lens.command !== undefined && tooltip !== undefined) {
    lens.command.tooltip = tooltip;
  }
  return lens;
}
