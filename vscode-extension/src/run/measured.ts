// Execution times of the last run: beside the declared ones, and into the specification as one edit.
import { execFile } from 'node:child_process';
import * as vscode from 'vscode';
import type { Range } from 'vscode-languageclient/node';
import type { Server } from '../client';
import { SECTION } from '../config';
import { range as rangeOf } from '../panel/reveal';
import { LANGUAGE } from '../protocol';

/** As `dotgen wcet import --format json` writes it (docs/measuring.md), as far as it is used. Times are in nanoseconds. */
export interface Times {
  codels: { codel: string; function: string; runs: number; mean: number; greatest: number; declared: number | null; place: Place | null }[];
  edits: (Place & { text: string })[];
  refused: { function: string; why: string }[];
}

interface Place {
  file: string;
  range: Range;
}

/** What reads the log of a run. */
export interface Question {
  command: string;
  arguments: string[];
  cwd: string;
  env: NodeJS.ProcessEnv;
}

export class MeasuredTimes implements vscode.InlayHintsProvider, vscode.CodeLensProvider, vscode.CodeActionProvider {
  private question: Question | undefined;
  private times: Times | undefined;
  /** Where hints are, by file; they move with what is typed. */
  private hints = new Map<string, { offset: number; label: string; tooltip: string }[]>();
  private readonly changed = new vscode.EventEmitter<void>();
  readonly onDidChangeInlayHints = this.changed.event;
  readonly onDidChangeCodeLenses = this.changed.event;
  private readonly subscriptions: vscode.Disposable;

  constructor(private readonly server: Server) {
    this.subscriptions = vscode.Disposable.from(
      this.changed,
      vscode.languages.registerInlayHintsProvider(LANGUAGE, this),
      vscode.languages.registerCodeLensProvider(LANGUAGE, this),
      vscode.languages.registerCodeActionsProvider(LANGUAGE, this, { providedCodeActionKinds: [vscode.CodeActionKind.QuickFix] }),
      vscode.workspace.onDidChangeTextDocument((change) => this.move(change)),
      vscode.workspace.onDidChangeConfiguration((change) => change.affectsConfiguration(`${SECTION}.run`) && void this.ask(this.question)),
    );
  }

  dispose(): void {
    this.subscriptions.dispose();
  }

  /** How many times there are to import. */
  get count(): number {
    return this.times?.edits.length ?? 0;
  }

  /** Reads the log of a run; undefined: there is none any more. */
  async ask(question: Question | undefined): Promise<void> {
    this.question = question;
    const times = question === undefined ? undefined : await read(question);
    if (question !== this.question) return;
    this.times = times;
    this.hints = await placed(times);
    this.changed.fire();
  }

  /** Writes the times into the specification, or that of one codel: one edit, which is undone in one step. */
  async write(codel?: string): Promise<void> {
    // What is on the disk was read: edits are about that.
    if (!(await vscode.workspace.saveAll(false))) return;
    await this.ask(this.question);
    const { times } = this;
    if (times === undefined) {
      void vscode.window.showInformationMessage('No times to import: times of a simulation are not measured. Run the codels of a component first.');
      return;
    }
    const edit = new vscode.WorkspaceEdit();
    const wanted = codel === undefined ? times.edits : editsOf(times, codel);
    for (const { file, range, text } of wanted) edit.replace(vscode.Uri.file(file), rangeOf(range), text);
    if (wanted.length > 0 && !(await vscode.workspace.applyEdit(edit))) {
      void vscode.window.showWarningMessage('The times were not written: the text has changed.');
      return;
    }
    const byHand = times.refused.map((it) => it.function).filter((it) => codel === undefined || it === codel).join(', ');
    if (byHand !== '') void vscode.window.showWarningMessage(`To be written by hand: the times of ${byHand}, which come from a macro or have a comment in them.`);
    else if (wanted.length === 0) void vscode.window.showInformationMessage('All measured times are within those declared.');
    // What was written is not left to import; what was measured stays beside.
    this.times = { ...times, edits: times.edits.filter((it) => !wanted.includes(it)) };
    this.changed.fire();
  }

  provideInlayHints(document: vscode.TextDocument, range: vscode.Range): vscode.InlayHint[] {
    const wanted = vscode.workspace.getConfiguration(SECTION, document.uri).get<boolean>('run.measuredHints', true);
    const all = wanted ? (this.hints.get(document.uri.fsPath) ?? []) : [];
    const hints = all.map(({ offset, label, tooltip }) => {
      const hint = new vscode.InlayHint(document.positionAt(offset), label);
      hint.paddingLeft = true;
      hint.tooltip = tooltip;
      return hint;
    });
    return hints.filter((it) => range.contains(it.position));
  }

  async provideCodeLenses(document: vscode.TextDocument): Promise<vscode.CodeLens[]> {
    const own = this.times?.edits.filter((it) => it.file === document.uri.fsPath) ?? [];
    if (own.length === 0 || this.server.running === undefined) return [];
    const symbols = await vscode.commands.executeCommand<vscode.DocumentSymbol[] | undefined>('vscode.executeDocumentSymbolProvider', document.uri);
    const title = own.length === 1 ? 'Import 1 measured time' : `Import ${own.length} measured times`;
    const tooltip = 'Writes what the last run took, with the margin of dotgen.run.margin, where it is more than what is declared';
    // Over what has them: an edit that stands in an included file has no component there.
    const around = (symbols ?? []).filter(({ range }) => own.some((it) => range.contains(rangeOf(it.range))));
    return around.map((it) => new vscode.CodeLens(it.selectionRange, { title, tooltip, command: 'dotgen.importTimes' }));
  }

  /** In the light bulb of a codel: its time, and those of all. */
  provideCodeActions(document: vscode.TextDocument, range: vscode.Range): vscode.CodeAction[] {
    const { times } = this;
    if (times === undefined || document.isDirty) return [];
    const here = ({ place }: Times['codels'][number]) => {
      if (place === null || place.file !== document.uri.fsPath) return false;
      // Behind its `;` one is still at a codel.
      const { start, end } = rangeOf(place.range);
      return new vscode.Range(start, document.lineAt(end.line).range.end).intersection(range) !== undefined;
    };
    const names = new Set(times.codels.filter(here).map((it) => it.function));
    const action = (title: string, ...words: string[]) => {
      const it = new vscode.CodeAction(title, vscode.CodeActionKind.QuickFix);
      it.command = { title, command: 'dotgen.importTimes', arguments: words };
      return it;
    };
    return [...names].flatMap((name) => {
      const text = editsOf(times, name)[0]?.text;
      if (text === undefined) return [];
      const one = action(`Import the measured time of ${name}: ${text.trim()}`, name);
      return times.edits.length > 1 ? [one, action(`Import all ${times.edits.length} measured times`)] : [one];
    });
  }

  private move({ document, contentChanges }: vscode.TextDocumentChangeEvent): void {
    for (const { rangeOffset, rangeLength, text } of contentChanges) {
      for (const it of this.hints.get(document.uri.fsPath) ?? []) {
        if (it.offset >= rangeOffset + rangeLength) it.offset += text.length - rangeLength;
      }
    }
  }
}

/** The edits that stand in the declaration of a codel. */
function editsOf(times: Times, codel: string): Times['edits'] {
  const places = times.codels.filter((it) => it.function === codel).flatMap(({ place }) => (place === null ? [] : [place]));
  return times.edits.filter((edit) => places.some((it) => it.file === edit.file && rangeOf(it.range).contains(rangeOf(edit.range))));
}

function read({ command, arguments: given, cwd, env }: Question): Promise<Times | undefined> {
  const margin = vscode.workspace.getConfiguration(SECTION).get<number>('run.margin', 1.2);
  const all = ['wcet', 'import', ...given, '--diff', '--format', 'json', '--margin', String(margin)];
  return new Promise((resolve) => {
    // It says by its exit status that some are to be written by hand.
    execFile(command, all, { cwd, env, maxBuffer: 64 << 20 }, (_, text) => resolve(timesOf(text)));
  });
}

/** What the program wrote; undefined where nothing was measured. */
export function timesOf(text: string): Times | undefined {
  try {
    const it = JSON.parse(text) as Partial<Times> | null;
    return Array.isArray(it?.codels) && Array.isArray(it.edits) ? (it as Times) : undefined;
  } catch {
    return undefined;
  }
}

async function placed(times: Times | undefined): Promise<Map<string, { offset: number; label: string; tooltip: string }[]>> {
  const out = new Map<string, { offset: number; label: string; tooltip: string }[]>();
  // A declaration is for all of its states.
  const places = new Map<string, Times['codels']>();
  for (const it of times?.codels ?? []) {
    const key = JSON.stringify(it.place);
    places.set(key, [...(places.get(key) ?? []), it]);
  }
  for (const all of places.values()) {
    const place = all[0]?.place;
    if (place === undefined || place === null) continue;
    // A file that has gone since has no hints.
    const document = await vscode.workspace.openTextDocument(place.file).then((it) => it, () => undefined);
    if (document === undefined) continue;
    const greatest = Math.max(...all.map((it) => it.greatest));
    const tooltip = all.map((it) => `${it.codel}: at most ${time(it.greatest)}, ${time(it.mean)} on average, in ${it.runs} ${it.runs === 1 ? 'run' : 'runs'}`).join('\n');
    const hint = { offset: document.offsetAt(rangeOf(place.range).end), label: `‹took ${time(greatest)}›`, tooltip };
    const path = document.uri.fsPath;
    out.set(path, [...(out.get(path) ?? []), hint]);
  }
  return out;
}

/** Nanoseconds, as people read them. */
export function time(nanos: number): string {
  const [unit, size] = ([['s', 1e9], ['ms', 1e6], ['µs', 1e3]] as const).find(([, size]) => nanos >= size) ?? (['ns', 1] as const);
  return `${Number((nanos / size).toPrecision(3))} ${unit}`;
}
