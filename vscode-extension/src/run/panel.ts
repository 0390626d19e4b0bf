// The panel of a run: starts `dotgen run`, hands its view to the page, and does what is asked there.
import { dirname } from 'node:path';
import * as vscode from 'vscode';
import type { Server } from '../client';
import { ready } from '../commands/server';
import { explicitSettings, serverSettings } from '../config';
import { reported } from '../failure';
import { SidePanel } from '../panel/panel';
import { offer } from '../panel/reveal';
import { offerTrust } from '../restricted';
import { LANGUAGE, SCENARIO } from '../protocol';
import type { FromPage, Ran, RunView, ToPage } from './messages';
import { MeasuredTimes } from './measured';
import { page } from './page';
import { Run, type Host, type Reading } from './process';
import { done } from '../walkthrough';

/** A port may be written a thousand times a second; nobody sees that. */
const SHOWN_EVERY_MS = 150;

/** Argument of the commands, as lenses give it. */
export interface RunTarget {
  uri: string;
}

interface Subject {
  uri: string;
  clock: RunView['clock'];
  /** Its components wait for a debugger. */
  debug: boolean;
}

export class RunPanel extends SidePanel<Subject, FromPage, ToPage> {
  private run: Run | undefined;
  /** The run that has ended and whose times were read. */
  private read: Run | undefined;
  private later: NodeJS.Timeout | undefined;
  private readonly changed = new vscode.EventEmitter<Ran | undefined>();
  /** What runs has come further; undefined: nothing has run. */
  readonly onDidChange = this.changed.event;

  private readonly waits = new vscode.EventEmitter<Host>();
  /** A component waits for a debugger. */
  readonly onDidWait = this.waits.event;
  /** One of the times may be imported elsewhere: from a lens or the light bulb. */
  private readonly imported: vscode.Disposable;

  constructor(
    private readonly server: Server,
    private readonly measured: MeasuredTimes,
    extension: vscode.Uri,
  ) {
    super({ type: 'dotgen.run', title: 'Run', find: true, page }, extension);
    this.imported = measured.onDidChangeCodeLenses(() => {
      if (this.run?.isOver === true) this.soon();
    });
  }

  /** What was typed is the page's; no run comes back with a window. */
  override deserializeWebviewPanel(panel: vscode.WebviewPanel): Promise<void> {
    return super.deserializeWebviewPanel(panel, undefined);
  }

  override dispose(): void {
    this.imported.dispose();
    this.end();
    this.changed.dispose();
    this.waits.dispose();
    super.dispose();
  }

  /** Runs what a lens names, or the active document. The one that runs is ended. */
  async start(clock: RunView['clock'], target?: RunTarget, debug = false): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    const here = editor !== undefined && [LANGUAGE, SCENARIO].includes(editor.document.languageId) ? editor.document.uri.toString() : undefined;
    const uri = typeof target?.uri === 'string' ? target.uri : here;
    if (uri === undefined) {
      void vscode.window.showInformationMessage('Open a specification (.gen) or a scenario (.scn) first.');
      return;
    }
    if (!vscode.workspace.isTrusted) {
      return offerTrust('Components are run and simulated in trusted folders only.');
    }
    const file = vscode.Uri.parse(uri);
    if (this.server.info === undefined) await ready(this.server);
    const { info } = this.server;
    if (info === undefined) return;
    if (file.scheme !== 'file' || !(await vscode.workspace.saveAll(false))) {
      void vscode.window.showWarningMessage('What runs is read from the disk: save the files first.');
      return;
    }
    this.end();
    this.subject = { uri, clock, debug };
    const cwd = vscode.workspace.getWorkspaceFolder(file)?.uri.fsPath ?? dirname(file.fsPath);
    const env = { ...process.env, ...serverSettings().extraEnv };
    const reading: Reading = explicitSettings(['includePaths', 'defines', 'release'], file);
    const waiting = debug ? (host: Host) => this.waits.fire(host) : undefined;
    this.run = new Run({ command: info.path, env, file: file.fsPath, cwd, clock, waiting, reading }, vscode.workspace.asRelativePath(file), () => this.soon());
    await this.open();
    if (this.panel !== undefined) this.panel.title = clock === 'real' || debug ? 'Run' : 'Simulation';
    await this.update();
  }

  /** What executes codels; undefined while the server does not run. */
  get program(): string | undefined {
    return this.server.info?.path;
  }

  stop(): void {
    this.run?.stop();
  }

  protected async update(): Promise<void> {
    this.later = undefined;
    const { run } = this;
    // `dotgen.runs`: the command Stop is shown while something runs.
    void vscode.commands.executeCommand('setContext', 'dotgen.runs', run?.isOver === false);
    const view = run?.view;
    const known = view?.report ?? view?.progress;
    this.changed.fire(known === undefined || known === null ? undefined : { unit: known.unit, machines: known.machines, activities: run?.isOver === true ? [] : (view?.progress?.activities ?? []) });
    if (run !== undefined && run !== this.read && run.isOver) {
      this.read = run;
      if (view?.clock === 'virtual' && view.report !== null) done('simulate');
      // The last view is sent without times too.
      await reported(() => this.measured.ask(run.question));
    }
    if (view !== undefined) this.send({ type: 'run', view: { ...view, times: this.measured.count } });
  }

  protected closed(): void {
    this.end();
    void reported(() => this.update());
  }

  protected async receive(message: FromPage): Promise<void> {
    const { run, subject } = this;
    switch (message.type) {
      case 'ready':
        return this.update();
      case 'stop':
        return this.stop();
      case 'again':
        return subject === undefined ? undefined : this.start(subject.clock, subject, subject.debug);
      case 'trace':
        if (run !== undefined) await vscode.commands.executeCommand('dotgen.openTrace', vscode.Uri.file(run.trace));
        return;
      case 'stubs':
        return offerStubs(run?.view.simulated[0]);
      case 'import':
        await vscode.commands.executeCommand('dotgen.importTimes');
        return this.update();
      case 'call':
        return run?.call(message.service, message.inputs);
      case 'abort':
        return run?.abort(message.service);
    }
  }

  private soon(): void {
    this.later ??= setTimeout(() => void reported(() => this.update()), SHOWN_EVERY_MS);
  }

  private end(): void {
    clearTimeout(this.later);
    this.later = undefined;
    this.run?.dispose();
    this.run = undefined;
    void reported(() => this.measured.ask(undefined));
  }
}

/** Shows the name of a component, and what rewrites it: its stubs are among that. */
async function offerStubs(component: string | undefined): Promise<void> {
  if (component === undefined) return;
  const symbols = await vscode.commands.executeCommand<vscode.SymbolInformation[]>('vscode.executeWorkspaceSymbolProvider', component);
  const at = symbols.find((it) => it.name === component)?.location;
  if (at === undefined) {
    void vscode.window.showWarningMessage(`The component ${component} was not found in this workspace. Open its specification to write its stubs.`);
    return;
  }
  const { start } = at.range;
  await offer('refactorings', at.uri.toString(), { start, end: start });
}
