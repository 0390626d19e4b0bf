// Codels in a debugger: a run whose components wait, and a debug session for each of them.
import { execFile } from 'node:child_process';
import * as vscode from 'vscode';
import { SECTION } from '../config';
import { LANGUAGE } from '../protocol';
import { adapter, attaching, DEBUG_TYPE, type Debugger } from './debugger';
import type { RunPanel, RunTarget } from './panel';
import type { Host } from './process';

const runs = (command: string, ...words: string[]) =>
  new Promise<boolean>((resolve) => execFile(command, words, { timeout: 10_000 }, (error) => resolve(error === null)));

/** The debugger that is set, else the first that is there. */
async function find(): Promise<Debugger | undefined> {
  const set = vscode.workspace.getConfiguration(SECTION).get<string>('run.debugger', '');
  if (set !== '') return adapter(set);
  if (vscode.extensions.getExtension('vadimcn.vscode-lldb') !== undefined) return { kind: 'lldb' };
  if (vscode.extensions.getExtension('ms-vscode.cpptools') !== undefined) return { kind: 'cppdbg' };
  // Before version 14 gdb does not speak the protocol.
  if (await runs('gdb', '-nx', '-batch', '-ex', 'python import gdb.dap')) return adapter('gdb');
  if (await runs('lldb-dap', '--help')) return adapter('lldb-dap');
  return undefined;
}

export class Debugging implements vscode.DebugConfigurationProvider, vscode.DebugAdapterDescriptorFactory, vscode.Disposable {
  private readonly disposables: vscode.Disposable[];
  private debugger: Debugger | undefined;
  /** Sessions of the run that goes on. */
  private readonly sessions = new Set<vscode.DebugSession>();
  private readonly waiting = new Set<number>();

  constructor(private readonly panel: RunPanel) {
    this.disposables = [
      vscode.debug.registerDebugConfigurationProvider(DEBUG_TYPE, this),
      vscode.debug.registerDebugAdapterDescriptorFactory(DEBUG_TYPE, this),
      panel.onDidWait((host) => void this.attach(host)),
      vscode.debug.onDidStartDebugSession((it) => this.isOurs(it) && this.sessions.add(it)),
      // Who ends the last session ends the run.
      vscode.debug.onDidTerminateDebugSession((it) => this.sessions.delete(it) && this.sessions.size === 0 && panel.stop()),
    ];
  }

  dispose(): void {
    for (const it of this.disposables) it.dispose();
  }

  /** Runs what a lens names, or the active document, in a debugger. It stops at the codel at the cursor. */
  async start(target?: RunTarget): Promise<void> {
    await this.stopAtCodel();
    await this.run('virtual', target);
  }

  /** F5: what is to be debugged runs, and each of its components gets a session of its own when it waits. */
  async resolveDebugConfigurationWithSubstitutedVariables(_: unknown, configuration: vscode.DebugConfiguration): Promise<vscode.DebugConfiguration | undefined> {
    if (configuration.request === 'attach') return configuration;
    const { program, clock } = configuration as { program?: string; clock?: string };
    const target = program === undefined || program === '' ? undefined : { uri: vscode.Uri.file(program).toString() };
    await this.run(clock === 'real' ? 'real' : 'virtual', target);
    return undefined;
  }

  createDebugAdapterDescriptor({ configuration }: vscode.DebugSession): vscode.DebugAdapterDescriptor | undefined {
    const [command, ...words] = (configuration.adapter ?? []) as string[];
    return command === undefined ? undefined : new vscode.DebugAdapterExecutable(command, words);
  }

  private async run(clock: 'virtual' | 'real', target?: RunTarget): Promise<void> {
    this.debugger = await find();
    if (this.debugger === undefined) {
      const message = 'No debugger found: install gdb (14 or later), lldb-dap, or the extension CodeLLDB or C/C++; or name one in the settings.';
      const settings = 'Open Settings';
      if ((await vscode.window.showErrorMessage(message, settings)) === settings) {
        await vscode.commands.executeCommand('workbench.action.openSettings', 'dotgen.run.debugger');
      }
      return;
    }
    this.waiting.clear();
    await this.panel.start(clock, target, true);
  }

  private async attach(host: Host): Promise<void> {
    const it = this.debugger;
    const program = this.panel.program;
    if (it === undefined || program === undefined) return;
    this.waiting.add(host.process);
    const folder = vscode.workspace.workspaceFolders?.[0];
    const started = await vscode.debug.startDebugging(folder, attaching(it, host, program), { suppressSaveBeforeStart: true });
    // The debugger has said why. Nobody else will attach.
    if (!started) this.panel.stop();
  }

  private isOurs({ configuration }: vscode.DebugSession): boolean {
    return this.waiting.has(Number(configuration.pid ?? configuration.processId));
  }

  /** A breakpoint in the function of the codel at the cursor, unless there is one. */
  private async stopAtCodel(): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    if (editor?.document.languageId !== LANGUAGE) return;
    const { document, selection } = editor;
    const found = await vscode.commands.executeCommand<(vscode.Location | vscode.LocationLink)[]>('vscode.executeImplementationProvider', document.uri, selection.active);
    for (const it of found ?? []) {
      const uri = 'targetUri' in it ? it.targetUri : it.uri;
      const range = 'targetUri' in it ? (it.targetSelectionRange ?? it.targetRange) : it.range;
      if (!/\.(c|cc|cpp|cxx|c\+\+)$/i.test(uri.path)) continue;
      const { line } = range.start;
      const isHere = (other: vscode.Breakpoint) => other instanceof vscode.SourceBreakpoint && other.location.uri.toString() === uri.toString() && other.location.range.start.line === line;
      if (vscode.debug.breakpoints.some(isHere)) continue;
      vscode.debug.addBreakpoints([new vscode.SourceBreakpoint(new vscode.Location(uri, new vscode.Position(line, 0)))]);
    }
  }
}
