// Entry point: puts the parts together.
import * as vscode from 'vscode';
import { Server } from './client';
import { CodelHeaders } from './codels/headers';
import { CompiledRuns } from './codels/problems';
import { Changes } from './commands/changes';
import { showReferences, type ReferencesTarget } from './commands/references';
import { IncludingRoot } from './commands/includingRoot';
import { MacroExpansion } from './commands/expandMacro';
import { offerRestart, reportFailure } from './commands/server';
import { SyntaxTreeView } from './commands/syntaxTree';
import { affectsServerProcess } from './config';
import { openExample } from './examples/open';
import { GenerateCommands, type Target as GenerateTarget } from './generate/commands';
import { exportModel } from './generate/exportModel';
import { Review } from './generate/review';
import { reported } from './failure';
import { IdlAssociation } from './idl';
import { openManual } from './manual';
import { showMenu } from './menu';
import { createComponent, showNewComponent } from './newComponent';
import { OfferedCommands } from './offered';
import { InlineDiagrams } from './preview/inline';
import { DiagramPreview } from './preview/panel';
import { named, opensInline, type Target } from './preview/target';
import { ReleaseStatus } from './commands/release';
import { tellRestricted } from './restricted';
import { MeasuredTimes } from './run/measured';
import { Debugging } from './run/debug';
import type { RunTarget } from './run/panel';
import type { Changed } from './review';
import { statusItem } from './status';
import { registerTasks } from './tasks';
import { registerTests } from './testing/scenarios';
import { TraceViewer, type TraceTarget } from './trace/panel';
import { watchRepairs } from './walkthrough';
import { VerificationPanel, type VerificationTarget } from './verification/panel';

let server: Server | undefined;

export async function activate(context: vscode.ExtensionContext): Promise<void> {
  const log = vscode.window.createOutputChannel('dotgen', { log: true });
  const output = vscode.window.createOutputChannel('dotgen Language Server', { log: true });
  server = new Server(context.extension, log, output, new OfferedCommands(context.subscriptions));
  const it = server;
  const tree = new SyntaxTreeView(it);
  const macros = new MacroExpansion(it);
  const measured = new MeasuredTimes(it);
  const runs = new CompiledRuns(it, measured, context.extensionUri);
  const debugging = new Debugging(runs);
  const preview = new DiagramPreview(it, context.extensionUri, context.workspaceState, runs.onDidChange);
  const inline = new InlineDiagrams(it, context.workspaceState);
  const verification = new VerificationPanel(it, context.extensionUri);
  const traces = new TraceViewer(it, context.extensionUri);
  const headers = new CodelHeaders(it, context.workspaceState);
  const review = new Review();
  const generate = new GenerateCommands(it, review);
  const changes = new Changes();
  context.subscriptions.push(
    review,
    vscode.commands.registerCommand('dotgen.generateFiles', (target?: GenerateTarget) => generate.generate(target)),
    vscode.commands.registerCommand('dotgen.regenerateFiles', (target?: GenerateTarget) => generate.regenerate(target)),
    vscode.commands.registerCommand('dotgen.exportModel', () => reported(() => exportModel(it, review))),
    log,
    output,
    statusItem(it),
    watchRepairs(),
    registerTasks(it),
    registerTests(it),
    new ReleaseStatus(it),
    tree,
    macros,
    preview,
    inline,
    verification,
    vscode.commands.registerCommand('dotgen.showVerification', (target?: VerificationTarget) => {
      const { uri, check, run } = target ?? {};
      return run === true && typeof uri === 'string' && typeof check === 'number' ? traces.show({ uri, check }) : verification.show(target);
    }),
    runs,
    measured,
    debugging,
    vscode.commands.registerCommand('dotgen.debug', (target?: RunTarget) => debugging.start(target)),
    vscode.commands.registerCommand('dotgen.importTimes', (codel?: unknown) => measured.write(typeof codel === 'string' ? codel : undefined)),
    vscode.commands.registerCommand('dotgen.simulate', (target?: RunTarget) => runs.start('virtual', target)),
    vscode.commands.registerCommand('dotgen.run', (target?: RunTarget) => runs.start('real', target)),
    vscode.commands.registerCommand('dotgen.stopRun', () => runs.stop()),
    traces,
    vscode.commands.registerCommand('dotgen.showTrace', (target?: TraceTarget) => traces.show(target)),
    vscode.commands.registerCommand('dotgen.openTrace', (file?: vscode.Uri) => traces.open(file)),
    headers,
    vscode.commands.registerCommand('dotgen.writeCodelHeaders', () => headers.write()),
    vscode.commands.registerCommand('dotgen.showDiagram', (target?: Target) => (opensInline(named(target)) ? inline.toggle(target) : preview.show('fsm', named(target)))),
    vscode.commands.registerCommand('dotgen.showReferences', (target: ReferencesTarget) => showReferences(it, target)),
    changes,
    vscode.commands.registerCommand('dotgen.tellChanges', (title: string, changed: Changed[]) => changes.tell(title, changed)),
    vscode.commands.registerCommand('dotgen.showSystemDiagram', () => preview.show('system')),
    vscode.commands.registerCommand('dotgen.showLockDiagram', () => preview.show('locks')),
    vscode.commands.registerCommand('dotgen.toggleInlineDiagram', (target?: Target) => inline.toggle(named(target))),
    new IncludingRoot(it, context.workspaceState),
    new IdlAssociation(log),
    vscode.commands.registerCommand('dotgen.showMenu', () => showMenu(it)),
    vscode.commands.registerCommand('dotgen.newComponent', () => createComponent(it, context.globalState)),
    vscode.commands.registerCommand('dotgen.openExample', () => openExample(context.extensionUri)),
    vscode.commands.registerCommand('dotgen.openManual', () => openManual(context.extensionUri)),
    vscode.commands.registerCommand('dotgen.openWalkthrough', () => vscode.commands.executeCommand('workbench.action.openWalkthrough', 'dotgen.dotgen#start')),
    vscode.commands.registerCommand('dotgen.restartServer', () => it.restart()),
    vscode.commands.registerCommand('dotgen.showSyntaxTree', () => tree.show()),
    vscode.commands.registerCommand('dotgen.expandMacro', () => reported(() => macros.expand())),
    vscode.commands.registerCommand('dotgen.showOutput', () => output.show(true)),
    vscode.commands.registerCommand('dotgen.showLogs', () => log.show(true)),
    watchServer(it),
  );
  // Commands about the workspace are shown where there is something to show.
  void vscode.commands.executeCommand('setContext', 'dotgen.active', true);
  void tellRestricted(context.workspaceState);
  await it.start();
  await showNewComponent(context.globalState);
}

/** Reports a server that fails, and restarts the server for other settings and for trust. */
const watchServer = (server: Server): vscode.Disposable =>
  vscode.Disposable.from(
    server.onDidChange((state) => {
      if (state.kind === 'failed') void reportFailure(server, state.reason);
    }),
    vscode.workspace.onDidChangeConfiguration((change) => {
      if (affectsServerProcess(change)) void offerRestart(server);
    }),
    // Settings of the folder may name another server now, and programs may be run.
    vscode.workspace.onDidGrantWorkspaceTrust(() => server.restart()),
  );

export async function deactivate(): Promise<void> {
  await server?.dispose();
}
