// Errors of compilers in the Problems view. Errors of a run are reported here. Errors of the task
// `codels build` come from the problem matcher `dotgen-codels`, which has the same owner: either build
// replaces the errors of the other.
import { existsSync } from 'node:fs';
import { dirname, relative, sep } from 'node:path';
import * as vscode from 'vscode';
import type { ToPage } from '../run/messages';
import { RunPanel } from '../run/panel';
import { compilerErrors, type CompilerError } from './compilerErrors';

/** The owner of the problem matcher in package.json. */
const OWNER = 'dotgen codels';
const CODE = 'codel/compiler';
const BUILD = 'codels build';

export class CodelProblems implements vscode.Disposable {
  private readonly collection = vscode.languages.createDiagnosticCollection(OWNER);
  /** Files with errors, by what was run. */
  private readonly files = new Map<string, vscode.Uri[]>();
  private readonly tasks: vscode.Disposable;

  constructor() {
    this.tasks = vscode.tasks.onDidStartTask(({ execution: { task } }) => {
      const { definition, scope } = task;
      if (definition.type === 'dotgen' && definition['command'] === BUILD && typeof scope === 'object') this.clear(scope.uri.fsPath);
    });
  }

  dispose(): void {
    this.tasks.dispose();
    this.collection.dispose();
  }

  /** A build begins: removes the errors of an earlier build of `subject`, and those below `folder`. */
  begin(subject: string, folder: string): void {
    this.files.get(subject)?.forEach((uri) => this.collection.delete(uri));
    this.files.delete(subject);
    this.clear(folder);
  }

  /** Replaces the errors of a build. */
  report(subject: string, errors: readonly CompilerError[]): void {
    const byFile = new Map<string, vscode.Diagnostic[]>();
    for (const error of errors) byFile.set(error.file, [...(byFile.get(error.file) ?? []), diagnostic(error)]);
    this.files.get(subject)?.forEach((uri) => byFile.has(uri.fsPath) || this.collection.delete(uri));
    const found = [...byFile].map(([file, all]) => [vscode.Uri.file(file), all] as const);
    found.forEach(([uri, all]) => this.collection.set(uri, all));
    this.files.set(subject, found.map(([uri]) => uri));
  }

  private clear(folder: string): void {
    for (const [uri, all] of vscode.languages.getDiagnostics()) {
      if (all.some(({ code }) => code === CODE) && isWithin(folder, uri.fsPath)) this.collection.delete(uri);
    }
  }
}

function isWithin(folder: string, path: string): boolean {
  const way = relative(folder, path);
  return way !== '..' && !way.startsWith(`..${sep}`);
}

function diagnostic({ line, column, severity, message }: CompilerError): vscode.Diagnostic {
  const at = new vscode.Position(Math.max(line - 1, 0), Math.max(column - 1, 0));
  const weight = severity === 'error' ? vscode.DiagnosticSeverity.Error : vscode.DiagnosticSeverity.Warning;
  const made = new vscode.Diagnostic(new vscode.Range(at, at), message, weight);
  made.source = 'dotgen';
  made.code = CODE;
  return made;
}

/** The panel of runs, which reports what does not compile. */
export class CompiledRuns extends RunPanel {
  private readonly problems = new CodelProblems();
  /** The run whose build was announced. */
  private begun: object | undefined;
  private last: string | undefined;
  /** Errors of this run by their text. The log keeps its last lines only. */
  private found = new Map<string, CompilerError>();

  override dispose(): void {
    super.dispose();
    this.problems.dispose();
  }

  protected override send(message: ToPage): void {
    super.send(message);
    const { subject } = this;
    // A simulation compiles nothing.
    if (subject === undefined || (subject.clock === 'virtual' && !subject.debug)) return;
    const file = vscode.Uri.parse(subject.uri);
    const component = dirname(file.fsPath);
    if (subject !== this.begun) {
      this.begun = subject;
      this.last = undefined;
      this.found = new Map();
      this.problems.begin(subject.uri, component);
    }
    const { log } = message.view;
    const last = `${log.length} ${log.at(-1)}`;
    if (last === this.last) return;
    this.last = last;
    const cwd = vscode.workspace.getWorkspaceFolder(file)?.uri.fsPath ?? component;
    const before = this.found.size;
    compilerErrors(log, { cwd, component, exists: existsSync }).forEach((error) => this.found.set(JSON.stringify(error), error));
    if (this.found.size > before) this.problems.report(subject.uri, [...this.found.values()]);
  }
}
