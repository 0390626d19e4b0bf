// The trace viewer, in the panel below the text: steps through a run, a counterexample or a recorded one, and shows each step
// in the text and in its state machine.
import * as vscode from 'vscode';
import type { WorkspaceEdit } from 'vscode-languageclient/node';
import { overtaken, type Server } from '../client';
import { ready } from '../commands/server';
import { reported } from '../failure';
import { range, reveal } from '../panel/reveal';
import { diagram, LANGUAGE, SCENARIO, trace as traceRequest, type DiagramAnswer, type NextSteps, type Place, type Remedy, type WhatIf } from '../protocol';
import { parse, type Trace } from './form';
import type { FromPage, Machine, ToPage } from './messages';
import { page } from './page';

const VIEW = 'dotgen.trace';
const NOTHING = 'No run is shown. Open one from a verification, or a recorded one.';
const OLD = 'The text has changed since: this run is of an earlier one.';

const NOT_YET = 'The run is not known at the moment: the text is being verified. Ask for it again.';

/** A request that a change has overtaken is made again. */
const ATTEMPTS = 3;

/** Chosen steps: the step of the original run before them, the choices, and the number of steps before each. */
interface Chosen {
  after: number;
  take: number[];
  before: number[];
}

/** The files that an edit changes: their text has to be the one that the edit was made for. */
function changed({ changes = {}, documentChanges = [] }: WorkspaceEdit): string[] {
  const edited = documentChanges.flatMap((it) => ('textDocument' in it ? [it.textDocument.uri] : []));
  return [...Object.keys(changes), ...edited];
}

/** Argument of the command. */
export interface TraceTarget {
  uri: string;
  check?: number | null;
  whatIf?: WhatIf;
}

export class TraceViewer implements vscode.Disposable, vscode.WebviewViewProvider {
  private view: vscode.WebviewView | undefined;
  private trace: Trace | undefined;
  /** What the trace was asked with; undefined for a file. */
  private target: TraceTarget | undefined;
  /** The chosen steps in the trace that is shown; undefined in an original run. */
  private chosen: Chosen | undefined;
  /** The choices before the steps that are listed. */
  private listed: Chosen | undefined;
  /** What repairs what the trace shows, and the number of its check. */
  private remedies: Remedy[] = [];
  private check: number | undefined;
  /** Ends the search for a preview. */
  private previewed: vscode.CancellationTokenSource | undefined;
  /** The text has changed since the trace was made. */
  private stale = false;
  private ready = false;
  /** What is said instead of a trace. */
  private otherwise: string | undefined;
  // Answers to older questions are dropped.
  private asked = 0;
  /** Ends the request for a state machine. */
  private drawing: vscode.CancellationTokenSource | undefined;
  private readonly machines = new Map<string, Promise<DiagramAnswer | null>>();
  private readonly mark = vscode.window.createTextEditorDecorationType({
    backgroundColor: new vscode.ThemeColor('editor.rangeHighlightBackground'),
    outlineColor: new vscode.ThemeColor('contrastActiveBorder'),
    borderRadius: '2px',
    border: '1px solid',
    borderColor: new vscode.ThemeColor('focusBorder'),
  });
  private readonly subscriptions: vscode.Disposable;

  constructor(
    private readonly server: Server,
    private readonly extension: vscode.Uri,
  ) {
    this.subscriptions = vscode.Disposable.from(
      this.mark,
      vscode.window.registerWebviewViewProvider(VIEW, this, { webviewOptions: { retainContextWhenHidden: true } }),
      vscode.workspace.onDidChangeTextDocument(({ document, contentChanges }) => {
        if (contentChanges.length === 0 || ![LANGUAGE, SCENARIO].includes(document.languageId)) return;
        this.machines.clear();
        const uri = document.uri.toString();
        const shown = this.trace?.places.some((it) => it?.uri === uri) ?? false;
        const concerned = shown || this.target?.uri === uri || this.remedies.some(({ edit }) => changed(edit).includes(uri));
        if (concerned && this.target !== undefined) {
          this.stale = true;
          this.send({ type: 'notice', text: OLD });
        }
        if (concerned) this.highlight(undefined);
      }),
    );
  }

  dispose(): void {
    this.subscriptions.dispose();
  }

  resolveWebviewView(view: vscode.WebviewView): void {
    this.view = view;
    this.ready = false;
    view.webview.options = { enableScripts: true, localResourceRoots: [vscode.Uri.joinPath(this.extension, 'dist')] };
    view.webview.onDidReceiveMessage((message: FromPage) => void reported(() => this.receive(message)));
    view.onDidChangeVisibility(() => !view.visible && this.highlight(undefined));
    view.onDidDispose(() => {
      this.view = undefined;
      this.highlight(undefined);
    });
    view.webview.html = page(view.webview, this.extension);
  }

  /** Shows the run of a check: of what a lens or the verification names, or of the active document. */
  async show(target?: TraceTarget): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    const here = editor !== undefined && [LANGUAGE, SCENARIO].includes(editor.document.languageId) ? editor.document.uri.toString() : undefined;
    const wanted = typeof target?.uri === 'string' ? target : here === undefined ? undefined : { uri: here };
    if (wanted === undefined) {
      void vscode.window.showInformationMessage('Open a specification (.gen) or a scenario (.scn) first.');
      return;
    }
    const client = await ready(this.server);
    if (client === undefined) return;
    const asked = ++this.asked;
    await vscode.commands.executeCommand(`${VIEW}.focus`);
    let trace: (Trace & { check: number; remedies?: Remedy[] }) | null;
    for (let attempt = 1; ; attempt++) {
      try {
        const { uri, check, whatIf } = wanted;
        trace = await client.sendRequest(traceRequest, {
          textDocument: { uri },
          ...(typeof check === 'number' ? { check } : {}),
          ...(whatIf === undefined ? {} : { whatIf }),
        });
        break;
      } catch (error) {
        if (asked !== this.asked) return;
        if (overtaken(error) && attempt < ATTEMPTS) continue;
        void vscode.window.showWarningMessage('The text changed while the run was looked for. Ask for it again.');
        return;
      }
    }
    if (asked !== this.asked) return;
    this.target = wanted;
    this.stale = false;
    this.remedies = trace?.remedies ?? [];
    this.check = trace?.check;
    this.present(trace ?? undefined, 'There is no run to show: no check of this document is refuted or has a longest run, or it is not verified yet.');
  }

  /** Shows a recorded run from a file. */
  async open(file?: vscode.Uri): Promise<void> {
    const [chosen] = file instanceof vscode.Uri ? [file] : ((await vscode.window.showOpenDialog({ title: 'Open Recorded Run', filters: { 'Recorded runs': ['json'] } })) ?? []);
    if (chosen === undefined) return;
    let trace: Trace;
    try {
      trace = parse(new TextDecoder().decode(await vscode.workspace.fs.readFile(chosen)));
    } catch (error) {
      void vscode.window.showErrorMessage(`${vscode.workspace.asRelativePath(chosen)}: ${error instanceof Error ? error.message : String(error)}`);
      return;
    }
    this.asked++;
    this.target = undefined;
    this.remedies = [];
    await vscode.commands.executeCommand(`${VIEW}.focus`);
    this.present(trace, NOTHING);
  }

  private present(trace: Trace | undefined, otherwise: string, chosen?: Chosen): void {
    this.trace = trace;
    this.chosen = chosen;
    this.listed = undefined;
    this.machines.clear();
    this.otherwise = otherwise;
    this.sendAll();
    if (trace === undefined) this.highlight(undefined);
  }

  /** Sends all that a page shows, also to a page that was not ready before. */
  private sendAll(): void {
    const { trace, otherwise } = this;
    this.send({ type: 'notice', text: this.stale ? OLD : '' });
    if (trace !== undefined) this.sendTrace(trace);
    else if (otherwise !== undefined) this.send({ type: 'nothing', text: otherwise });
  }

  private sendTrace(trace: Trace): void {
    const remedies = this.remedies.map(({ title, whatIf }) => ({ title, previews: whatIf !== null }));
    this.send({ type: 'trace', trace, simulates: this.target !== undefined, remedies: this.chosen === undefined ? remedies : [] });
  }

  private send(message: ToPage): void {
    if (this.ready) void this.view?.webview.postMessage(message);
  }

  private async receive(message: FromPage): Promise<void> {
    switch (message.type) {
      case 'ready':
        this.ready = true;
        return this.sendAll();
      case 'choices':
        return this.choices(message.step);
      case 'take':
        return this.take(message.choice);
      case 'preview':
        return this.preview(message.remedy);
      case 'unpreview':
        return this.previewed?.cancel();
      case 'remedy':
        return this.write(message.remedy);
      case 'open':
        return this.open();
      case 'refresh':
        return this.target === undefined ? undefined : this.show(this.target);
      case 'go': {
        const place = this.place(message.step);
        return place === undefined ? undefined : reveal(place.uri, place.range);
      }
      case 'step': {
        const place = this.place(message.step);
        this.highlight(place);
        const machine = place === undefined ? null : await this.machine(place);
        this.send({ type: 'machine', step: message.step, machine });
      }
    }
  }

  /** Shows the run with a remedy. */
  private async preview(remedy: number): Promise<void> {
    const { running: client } = this.server;
    const { target, asked, check } = this;
    const whatIf = this.remedies[remedy]?.whatIf ?? undefined;
    if (client === undefined || target === undefined || check === undefined || whatIf === undefined || this.stale) return;
    this.previewed?.cancel();
    const source = new vscode.CancellationTokenSource();
    this.previewed = source;
    try {
      const trace = await client.sendRequest(traceRequest, { textDocument: { uri: target.uri }, check, whatIf }, source.token);
      if (asked === this.asked) this.send({ type: 'preview', remedy, trace });
    } catch {
      // Cancelled, or overtaken by an edit.
    } finally {
      source.dispose();
      if (this.previewed === source) this.previewed = undefined;
    }
  }

  /** Writes a remedy. */
  private async write(remedy: number): Promise<void> {
    const { running: client } = this.server;
    const { edit, title } = this.remedies[remedy] ?? {};
    if (client === undefined || edit === undefined) return;
    if (this.stale) return this.send({ type: 'notice', text: OLD });
    // An edit that is written twice would be another one.
    this.stale = true;
    const done = await vscode.workspace.applyEdit(await client.protocol2CodeConverter.asWorkspaceEdit(edit));
    this.send({ type: 'notice', text: done ? `Done: ${title?.replaceAll('`', '') ?? ''}. The run is the one before.` : OLD });
  }

  /** Lists the steps that may follow a step. The choices that led to it are kept. */
  private async choices(step: number): Promise<void> {
    const { chosen } = this;
    const last = (this.trace?.steps.length ?? 0) - 1;
    const kept = chosen === undefined || (step <= chosen.after && step !== last) ? 0 : chosen.before.filter((it) => it <= step || step === last).length;
    const listed = chosen === undefined || kept === 0 ? { after: step, take: [], before: [] } : { after: chosen.after, take: chosen.take.slice(0, kept), before: chosen.before.slice(0, kept) };
    const answer = await this.simulate(listed);
    if (answer?.next === undefined) return;
    this.listed = listed;
    this.send({ type: 'next', step, choices: answer.next.choices });
  }

  /** Goes on with one of the listed steps. */
  private async take(choice: number): Promise<void> {
    if (this.listed === undefined) return;
    const { after, take } = this.listed;
    const answer = await this.simulate({ after, take: [...take, choice] });
    if (answer?.next === undefined) return;
    const { choices, taken } = answer.next;
    const chosen = { after, take: [...take, choice].slice(0, taken.length), before: taken };
    this.present(answer, NOTHING, chosen);
    this.listed = chosen;
    this.send({ type: 'next', step: answer.steps.length - 1, choices });
  }

  /** The run with chosen steps; undefined after an edit. */
  private async simulate({ after, take }: Omit<Chosen, 'before'>): Promise<(Trace & { next?: NextSteps }) | undefined> {
    const { running: client } = this.server;
    const { target } = this;
    if (client === undefined || target === undefined) return undefined;
    if (this.stale) {
      this.send({ type: 'notice', text: OLD });
      return undefined;
    }
    const asked = ++this.asked;
    const { uri, check, whatIf } = target;
    try {
      const answer = await client.sendRequest(traceRequest, {
        textDocument: { uri },
        ...(typeof check === 'number' ? { check } : {}),
        ...(whatIf === undefined ? {} : { whatIf }),
        after,
        take,
      });
      if (asked !== this.asked) return undefined;
      if (answer?.next === undefined) this.send({ type: 'notice', text: NOT_YET });
      return answer ?? undefined;
    } catch {
      this.send({ type: 'notice', text: OLD });
      return undefined;
    }
  }

  private place(step: number): Place | undefined {
    const index = this.trace?.steps[step]?.place;
    return index === undefined ? undefined : (this.trace?.places[index] ?? undefined);
  }

  /** Marks a codel wherever its text is open to be seen. The focus stays. */
  private highlight(place: Place | undefined): void {
    for (const editor of vscode.window.visibleTextEditors) {
      const here = place !== undefined && editor.document.uri.toString() === place.uri ? [range(place.range)] : [];
      editor.setDecorations(this.mark, here);
      const [first] = here;
      if (first !== undefined) editor.revealRange(first, vscode.TextEditorRevealType.InCenterIfOutsideViewport);
    }
  }

  /** The state machine around a place, and the state that is there. */
  private async machine({ uri, range: { start } }: Place): Promise<Machine | null> {
    const { running: client } = this.server;
    if (client === undefined) return null;
    const key = `${uri} ${start.line}:${start.character}`;
    let known = this.machines.get(key);
    if (known === undefined) {
      this.drawing?.cancel();
      const drawing = new vscode.CancellationTokenSource();
      this.drawing = drawing;
      drawing.token.onCancellationRequested(() => this.machines.delete(key));
      const over = () => {
        if (this.drawing === drawing) this.drawing = undefined;
      };
      known = client.sendRequest(diagram, { textDocument: { uri }, position: start, kind: 'fsm', theme: 'editor' }, drawing.token);
      known.then(over, over);
      this.machines.set(key, known);
    }
    try {
      const answer = await known;
      if (answer === null) return null;
      const inside = ({ place }: DiagramAnswer['nodes'][number]) => place !== null && range(place.range).contains(new vscode.Position(start.line, start.character));
      return { title: answer.title, svg: answer.picture, node: answer.nodes.find(inside)?.id ?? null };
    } catch {
      // Overtaken by an edit, or by another step.
      if (this.machines.get(key) === known) this.machines.delete(key);
      return null;
    }
  }
}
