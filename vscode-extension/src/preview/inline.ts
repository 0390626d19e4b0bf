// The diagram between the lines: a comment thread below the task or activity, the stable way to have a zone in the text.
import * as vscode from 'vscode';
import { overtaken, type Server } from '../client';
import { ready } from '../commands/server';
import { reveal } from '../panel/reveal';
import { LANGUAGE, type DiagramAnswer, type DiagramPlace } from '../protocol';
import { drawMachine, image, nodeAt } from './machine';
import type { Target } from './target';

const TYPING_PAUSE_MS = 100;
/** Where the workspace keeps the machines that are shown. */
const SHOWN = 'diagram.inline';
/** Until VS Code has made room for a comment. */
const DRAWN_MS = 300;
const MOST_LINKS = 20;

/** A machine between the lines, as the workspace keeps it. */
interface Kept {
  uri: string;
  component: string;
  owner: string;
}

interface Zone {
  thread: vscode.CommentThread;
  answer: DiagramAnswer;
  /** The state that is marked. */
  state: string | undefined;
  /** What it shows: set only when that changes, or the zone would flicker while typing elsewhere. */
  shown?: string;
}

export class InlineDiagrams implements vscode.Disposable {
  private readonly controller = vscode.comments.createCommentController('dotgen.inline', 'dotgen diagrams');
  private kept: Kept[];
  private readonly zones = new Map<Kept, Zone>();
  private readonly subscriptions: vscode.Disposable;
  private timer: NodeJS.Timeout | undefined;
  /** Ends the pictures that are being drawn anew. */
  private asked: vscode.CancellationTokenSource | undefined;

  constructor(
    private readonly server: Server,
    private readonly memory: vscode.Memento,
  ) {
    this.kept = memory.get<Kept[]>(SHOWN) ?? [];
    const changed = ({ languageId }: vscode.TextDocument) => languageId === LANGUAGE && this.refresh(TYPING_PAUSE_MS);
    this.subscriptions = vscode.Disposable.from(
      vscode.workspace.onDidChangeTextDocument(({ document }) => changed(document)),
      vscode.workspace.onDidOpenTextDocument(changed),
      vscode.workspace.onDidCloseTextDocument(({ uri }) => this.closed(uri.toString())),
      vscode.workspace.onDidDeleteFiles(({ files }) => this.forget(files)),
      vscode.workspace.onDidRenameFiles(({ files }) => this.forget(files.map((it) => it.oldUri))),
      vscode.window.onDidChangeTextEditorSelection(({ textEditor }) => this.follow(textEditor)),
      vscode.window.onDidChangeActiveColorTheme(() => this.refresh(0)),
      server.onDidChange(() => this.refresh(0)),
      vscode.commands.registerCommand('dotgen.reveal', ({ uri, selectionRange }: DiagramPlace) => reveal(uri, selectionRange)),
    );
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.asked?.cancel();
    this.subscriptions.dispose();
    this.controller.dispose();
  }

  /** Shows a machine, that at the cursor if none is given, between the lines; or takes it away again. */
  async toggle(target?: Target): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    const uri = target?.uri ?? (editor?.document.languageId === LANGUAGE ? editor.document.uri.toString() : undefined);
    if (uri === undefined) {
      void vscode.window.showInformationMessage('Open a .gen file first.');
      return;
    }
    const client = await ready(this.server);
    if (client === undefined) return;
    let answer: DiagramAnswer | null;
    try {
      answer = await drawMachine(client, uri, target ?? (editor === undefined ? {} : { position: editor.selection.active }));
    } catch {
      void vscode.window.showWarningMessage('The text changed while the picture was drawn. Show the state machine again.');
      return;
    }
    if (answer === null || answer.component === null || answer.owner === null || answer.place === null) {
      void vscode.window.showInformationMessage('There is no state machine at the cursor.');
      return;
    }
    const { component, owner } = answer;
    const known = this.kept.filter((it) => it.uri === uri && it.component === component && it.owner === owner);
    // A picture that is being drawn would come back after it is hidden.
    this.asked?.cancel();
    known.forEach((it) => this.hide(it));
    this.kept = known.length > 0 ? this.kept.filter((it) => !known.includes(it)) : [...this.kept, { uri, component, owner }];
    await this.memory.update(SHOWN, this.kept);
    await this.update();
    if (known.length === 0 && editor?.document.uri.toString() === uri) setTimeout(() => reach(editor, answer.place), DRAWN_MS);
  }

  /** Forgets the machines of files that are gone, and of those in folders that are gone. */
  private forget(gone: readonly vscode.Uri[]): void {
    const isGone = ({ uri }: Kept) => gone.some((it) => uri === it.toString() || uri.startsWith(`${it.toString()}/`));
    const known = this.kept.filter(isGone);
    if (known.length === 0) return;
    this.asked?.cancel();
    known.forEach((it) => this.hide(it));
    this.kept = this.kept.filter((it) => !isGone(it));
    void this.memory.update(SHOWN, this.kept);
    this.refresh(0);
  }

  private closed(uri: string): void {
    const known = this.kept.filter((it) => it.uri === uri);
    if (known.length === 0) return;
    this.asked?.cancel();
    known.forEach((it) => this.hide(it));
    this.refresh(0);
  }

  private hide(kept: Kept): void {
    this.zones.get(kept)?.thread.dispose();
    this.zones.delete(kept);
  }

  private refresh(delay: number): void {
    if (this.kept.length > 0) {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => void this.update(), delay);
    }
  }

  /** Marks the state at the cursor. */
  private follow({ document }: vscode.TextEditor): void {
    const uri = document.uri.toString();
    for (const [kept, zone] of this.zones) {
      if (kept.uri === uri && stateAt(zone.answer, uri) !== zone.state) return this.refresh(TYPING_PAUSE_MS);
    }
  }

  private async update(): Promise<void> {
    this.asked?.cancel();
    const { token } = (this.asked = new vscode.CancellationTokenSource());
    const open = new Set(vscode.workspace.textDocuments.map((it) => it.uri.toString()));
    for (const kept of this.kept.filter((it) => open.has(it.uri))) {
      const { running: client } = this.server;
      if (client === undefined) return;
      const { uri, component, owner } = kept;
      const before = this.zones.get(kept);
      try {
        let answer = await drawMachine(client, uri, { component, owner, state: before && stateAt(before.answer, uri) }, token);
        let state = before && answer && stateAt(before.answer, uri);
        // The first answer says where the states are.
        if (answer !== null && stateAt(answer, uri) !== state) {
          state = stateAt(answer, uri);
          answer = await drawMachine(client, uri, { component, owner, state }, token);
        }
        if (token.isCancellationRequested) return;
        if (answer === null || answer.place === null) {
          // The task or activity has gone, and so does its picture, until the name is there again.
          this.hide(kept);
        } else {
          this.show(kept, answer, answer.place, state ?? undefined);
        }
      } catch (error) {
        // Overtaken by typing: what is typed next, or the pause after it, asks again.
        if (token.isCancellationRequested) return;
        if (overtaken(error)) this.refresh(TYPING_PAUSE_MS);
      }
    }
  }

  private show(kept: Kept, answer: DiagramAnswer, place: DiagramPlace, state: string | undefined): void {
    let zone = this.zones.get(kept);
    const { line } = place.range.end;
    const at = new vscode.Range(line, 0, line, 0);
    if (zone === undefined) {
      const thread = this.controller.createCommentThread(vscode.Uri.parse(kept.uri), at, []);
      thread.canReply = false;
      thread.collapsibleState = vscode.CommentThreadCollapsibleState.Expanded;
      zone = { thread, answer, state };
      this.zones.set(kept, zone);
    }
    const { thread } = zone;
    zone.answer = answer;
    zone.state = state;
    if (answer.stale === null && thread.range?.end.line !== line) thread.range = at;
    const body = text(answer, state);
    if (zone.shown === body.value) return;
    zone.shown = body.value;
    // The one header: a comment without an author has none.
    thread.label = answer.title;
    thread.comments = [{ body, mode: vscode.CommentMode.Preview, author: { name: '' } }];
  }
}

/** Scrolls to the picture as far as the cursor remains in sight. */
function reach(editor: vscode.TextEditor, place: DiagramPlace | null): void {
  if (place === null) return;
  const below = new vscode.Position(place.range.end.line + 1, 0);
  editor.revealRange(new vscode.Range(below, below));
  editor.revealRange(editor.selection);
}

/** Returns the state at the cursor of the editor that shows a file. */
function stateAt({ nodes }: DiagramAnswer, uri: string): string | undefined {
  const shows = (it: vscode.TextEditor | undefined) => it?.document.uri.toString() === uri;
  const editor = shows(vscode.window.activeTextEditor) ? vscode.window.activeTextEditor : vscode.window.visibleTextEditors.find(shows);
  return editor && nodeAt(nodes, uri, editor.selection.active)?.names[0];
}

/** Returns the picture, which opens the preview, and links to the states. */
function text(answer: DiagramAnswer, state: string | undefined): vscode.MarkdownString {
  const { place, component, owner, nodes, stale, incomplete } = answer;
  const body = new vscode.MarkdownString();
  body.isTrusted = { enabledCommands: ['dotgen.reveal', 'dotgen.showDiagram'] };
  const link = (title: string, command: string, argument: unknown) => `[${title}](command:${command}?${encodeURIComponent(JSON.stringify([argument]))})`;
  const picture = image(answer, state);
  body.appendMarkdown(link(picture ?? 'The picture is too large. Open it next to the text.', 'dotgen.showDiagram', { uri: place?.uri, component, owner, place: 'beside' }));
  const places = nodes.flatMap((node) => (node.place === null ? [] : [{ name: node.names.join(', '), isCurrent: state !== undefined && node.names.includes(state), place: node.place }]));
  const links = places.slice(0, MOST_LINKS).map(({ name, isCurrent, place }) => link(isCurrent ? `**${name}**` : name, 'dotgen.reveal', place));
  const others = places.length > MOST_LINKS ? ` · ${places.length - MOST_LINKS} others` : '';
  body.appendMarkdown(`\n\n${links.join(' · ')}${others}`);
  if (stale !== null) body.appendMarkdown('\n\nThe text has an error; this is the last good picture.');
  else if (incomplete !== null) body.appendMarkdown('\n\nThe text has an error; the picture may be incomplete.');
  return body;
}
