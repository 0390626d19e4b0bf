// The Testing view: scenarios are files of tests, and each check of a scenario is a test. An untrusted folder
// has no tests.
import { dirname } from 'node:path';
import * as vscode from 'vscode';
import type { Server } from '../client';
import { ready } from '../commands/server';
import { explicitSettings, serverSettings } from '../config';
import { reported } from '../failure';
import { SCENARIO } from '../protocol';
import { readingOf } from '../run/process';
import { reportOf, resultsOf, type Result } from './answers';
import { verify } from './verify';
import { checksOf, type WrittenCheck } from './written';

const PATTERN = '**/*.scn';
/** Time without typing after which the tests of a scenario are read again. */
const CALM_MS = 300;

export class ScenarioTests implements vscode.Disposable {
  private readonly controller = vscode.tests.createTestController('dotgen', 'dotgen');
  private readonly subscriptions: vscode.Disposable[];
  /** Runs that have not ended. */
  private readonly running = new Set<AbortController>();
  private later: NodeJS.Timeout | undefined;

  constructor(private readonly server: Server) {
    this.controller.resolveHandler = async (item) => {
      await (item === undefined ? this.findAll() : this.read(item));
    };
    this.controller.refreshHandler = () => this.findAll();
    const run = (request: vscode.TestRunRequest, token: vscode.CancellationToken) => reported(() => this.run(request, token));
    const profile = this.controller.createRunProfile('Verify', vscode.TestRunProfileKind.Run, run, true);
    profile.supportsContinuousRun = true;
    const watcher = vscode.workspace.createFileSystemWatcher(PATTERN);
    const changed = (uri: vscode.Uri) => void reported(() => this.read(this.file(uri)));
    this.subscriptions = [
      this.controller,
      watcher,
      watcher.onDidCreate(changed),
      watcher.onDidChange(changed),
      watcher.onDidDelete((uri) => this.controller.items.delete(uri.toString())),
      vscode.workspace.onDidOpenTextDocument((document) => this.show(document)),
      vscode.workspace.onDidChangeTextDocument(({ document }) => {
        clearTimeout(this.later);
        this.later = setTimeout(() => this.show(document), CALM_MS);
      }),
    ];
    vscode.workspace.textDocuments.forEach((document) => this.show(document));
  }

  dispose(): void {
    clearTimeout(this.later);
    this.running.forEach((one) => one.abort());
    vscode.Disposable.from(...this.subscriptions).dispose();
  }

  private show(document: vscode.TextDocument): void {
    if (document.languageId === SCENARIO && document.uri.scheme === 'file') this.fill(this.file(document.uri), document.getText());
  }

  private async findAll(): Promise<void> {
    const found = await vscode.workspace.findFiles(PATTERN);
    const known = new Set(found.map((uri) => uri.toString()));
    this.controller.items.forEach(({ id }) => known.has(id) || this.controller.items.delete(id));
    await Promise.all(found.map((uri) => this.read(this.file(uri))));
  }

  /** The test item of a scenario. */
  private file(uri: vscode.Uri): vscode.TestItem {
    const id = uri.toString();
    const known = this.controller.items.get(id);
    if (known !== undefined) return known;
    const item = this.controller.createTestItem(id, vscode.workspace.asRelativePath(uri), uri);
    item.canResolveChildren = true;
    this.controller.items.add(item);
    return item;
  }

  /** Reads the checks of a scenario from the editor, or else from the disk. Returns them in order. */
  private async read(item: vscode.TestItem): Promise<WrittenCheck[]> {
    const { uri } = item;
    if (uri === undefined || item.parent !== undefined) return [];
    const open = vscode.workspace.textDocuments.find((document) => document.uri.toString() === item.id);
    try {
      return this.fill(item, open?.getText() ?? Buffer.from(await vscode.workspace.fs.readFile(uri)).toString('utf8'));
    } catch (error) {
      item.error = error instanceof Error ? error.message : String(error);
      return [];
    }
  }

  private fill(item: vscode.TestItem, text: string): WrittenCheck[] {
    const place = placesIn(text);
    const checks = checksOf(text);
    const ids = idsOf(checks);
    item.error = undefined;
    item.children.replace(
      checks.map((check, i) => {
        const id = ids[i] ?? '';
        const label = check.name ?? check.text.replace(/^check /, '');
        const known = item.children.get(id);
        const test = known?.label === label ? known : this.controller.createTestItem(id, label, item.uri);
        test.description = check.name === undefined ? '' : check.kind;
        test.range = new vscode.Range(place(check.start), place(check.end));
        test.sortText = String(i).padStart(4, '0');
        return test;
      }),
    );
    return checks;
  }

  private async run(request: vscode.TestRunRequest, token: vscode.CancellationToken): Promise<void> {
    if (request.continuous !== true) return this.once(request, token);
    // A newer text makes the run of the older one useless.
    let last: vscode.CancellationTokenSource | undefined;
    const saved = vscode.workspace.onDidSaveTextDocument(({ fileName }) => {
      if (!/\.(gen|scn|idl|toml)$/.test(fileName)) return;
      last?.cancel();
      const one = new vscode.CancellationTokenSource();
      last = one;
      void reported(() => this.once(request, one.token));
    });
    this.subscriptions.push(saved);
    token.onCancellationRequested(() => {
      last?.cancel();
      saved.dispose();
    });
  }

  private async once(request: vscode.TestRunRequest, token: vscode.CancellationToken): Promise<void> {
    if (this.server.info === undefined && (await ready(this.server)) === undefined) return;
    const run = this.controller.createTestRun(request);
    const abort = new AbortController();
    const cancelled = [token, run.token].map((one) => one.onCancellationRequested(() => abort.abort()));
    if (token.isCancellationRequested) abort.abort();
    this.running.add(abort);
    try {
      if (!(await vscode.workspace.saveAll(false))) {
        run.appendOutput('Not verified: dotgen reads files from the disk. Save the files first.\r\n');
        return;
      }
      if (request.include === undefined) await this.findAll();
      for (const item of filesOf(request.include, this.controller.items)) {
        if (abort.signal.aborted) break;
        await this.verify(run, item, request, abort.signal);
      }
    } finally {
      this.running.delete(abort);
      cancelled.forEach((one) => one.dispose());
      run.end();
    }
  }

  /** Verifies a scenario, and reports the results of the wanted checks. */
  private async verify(run: vscode.TestRun, item: vscode.TestItem, request: vscode.TestRunRequest, signal: AbortSignal): Promise<void> {
    const { info } = this.server;
    const written = await this.read(item);
    const tests = idsOf(written).map((id) => item.children.get(id));
    const wanted = (test: vscode.TestItem) => isIncluded(test, request);
    const all = tests.filter((test) => test !== undefined && wanted(test)) as vscode.TestItem[];
    if (item.uri === undefined || info === undefined || all.length === 0) return;
    all.forEach((test) => run.started(test));
    const file = item.uri;
    const cwd = vscode.workspace.getWorkspaceFolder(file)?.uri.fsPath ?? dirname(file.fsPath);
    const reading = readingOf(explicitSettings(['includePaths', 'defines', 'release'], file), cwd);
    const begun = Date.now();
    const fail = (text: string) => all.forEach((test) => run.errored(test, at(new vscode.TestMessage(text), test)));
    try {
      const env = { ...process.env, ...serverSettings().extraEnv };
      const ended = await verify({ program: info.path, arguments: ['verify', '--format', 'json', ...reading, file.fsPath], cwd, env }, signal);
      if (ended === undefined) return all.forEach((test) => run.skipped(test));
      const report = reportOf(ended.out);
      if (report === undefined) return fail(`Not verified: the scenario or a specification has errors.\n${ended.errors.trim()}`);
      const results = resultsOf(report, written);
      const time = Date.now() - begun;
      tests.forEach((test, i) => {
        const result = results[i];
        if (test !== undefined && result !== undefined && wanted(test)) tell(run, test, result, time);
      });
    } catch (error) {
      fail(`Not verified: ${error instanceof Error ? error.message : String(error)}`);
    }
  }
}

function tell(run: vscode.TestRun, test: vscode.TestItem, { outcome, messages, lines }: Result, time: number): void {
  for (const line of lines) run.appendOutput(`${line}\r\n`, undefined, test);
  if (outcome === 'passed') return run.passed(test, time);
  run[outcome](test, messages.map((text) => at(new vscode.TestMessage(text), test)), time);
}

/** Puts a message at its check. */
function at(message: vscode.TestMessage, { uri, range }: vscode.TestItem): vscode.TestMessage {
  if (uri !== undefined && range !== undefined) message.location = new vscode.Location(uri, range);
  return message;
}

/** The files of the wanted tests; all of them if nothing is named. */
function filesOf(include: readonly vscode.TestItem[] | undefined, items: vscode.TestItemCollection): Set<vscode.TestItem> {
  const files = new Set(include?.map((test) => test.parent ?? test));
  if (include === undefined) items.forEach((item) => files.add(item));
  return files;
}

/** Items are compared by id: those of a changed text are new. */
function isIncluded(test: vscode.TestItem, { include, exclude }: vscode.TestRunRequest): boolean {
  const isIn = (list: readonly vscode.TestItem[] | undefined) =>
    list?.some((one) => (one.parent === undefined ? one.id === test.parent?.id : one.id === test.id && one.parent.id === test.parent?.id));
  return isIn(include) !== false && isIn(exclude) !== true;
}

/** Names, or texts of checks without name. A second one of the same name gets a number. */
function idsOf(checks: readonly WrittenCheck[]): string[] {
  const seen = new Map<string, number>();
  return checks.map(({ name, text }) => {
    const id = name ?? text;
    const count = (seen.get(id) ?? 0) + 1;
    seen.set(id, count);
    return count === 1 ? id : `${id} #${count}`;
  });
}

/** Returns the position of an offset. Lines end as in the editor. */
function placesIn(text: string): (offset: number) => vscode.Position {
  const starts = [0, ...[...text.matchAll(/\r\n|\r|\n/g)].map(({ 0: end, index }) => index + end.length)];
  return (offset) => {
    const next = starts.findIndex((start) => start > offset);
    const line = (next === -1 ? starts.length : next) - 1;
    return new vscode.Position(line, offset - (starts[line] ?? 0));
  };
}

/** Shows the tests once the folder is trusted. */
export function registerTests(server: Server): vscode.Disposable {
  const shown: vscode.Disposable[] = [];
  const show = () => shown.push(new ScenarioTests(server));
  if (vscode.workspace.isTrusted) show();
  else shown.push(vscode.workspace.onDidGrantWorkspaceTrust(show));
  return new vscode.Disposable(() => vscode.Disposable.from(...shown).dispose());
}
