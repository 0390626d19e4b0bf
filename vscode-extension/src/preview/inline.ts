// The diagram between the lines: a comment thread under the heading of the task or activity, the stable way to have a
// zone in the text.
import * as vscode from 'vscode';
import { overtaken, type Server } from '../client';
import { notRunning } from '../commands/server';
import { diagram, LANGUAGE, type DiagramAnswer } from '../protocol';
import { isDark, type Target } from './target';

const TYPING_PAUSE_MS = 100;
/** Without a limit of VS Code. */
const HIGHEST = 420;
/** VS Code scrolls a comment higher than 20 em, unless `comments.maxHeight` is off. */
const HIGHEST_WITHOUT_SCROLLING = 236;

interface Zone {
  thread: vscode.CommentThread;
  uri: vscode.Uri;
  component: string;
  owner: string;
  /** What it shows: set only when that changes, or the zone would flicker while typing elsewhere. */
  shown?: string;
}

export class InlineDiagrams implements vscode.Disposable {
  private readonly controller = vscode.comments.createCommentController('dotgen.inline', 'dotgen diagrams');
  private zones: Zone[] = [];
  private readonly subscriptions: vscode.Disposable;
  private timer: NodeJS.Timeout | undefined;

  constructor(private readonly server: Server) {
    this.subscriptions = vscode.Disposable.from(
      vscode.workspace.onDidChangeTextDocument(({ document }) => {
        if (document.languageId === LANGUAGE) {
          this.refresh(TYPING_PAUSE_MS);
        }
      }),
      vscode.workspace.onDidCloseTextDocument(({ uri }) => this.remove(this.zones.filter((it) => it.uri.toString() === uri.toString()))),
      vscode.window.onDidChangeActiveColorTheme(() => this.refresh(0)),
      server.onDidChange(() => this.refresh(0)),
    );
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.subscriptions.dispose();
    this.controller.dispose();
  }

  /** Shows a machine, that at the cursor if none is given, between the lines; or takes it away again. */
  async toggle(target?: Target): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    const uri = target === undefined ? editor?.document.uri : vscode.Uri.parse(target.uri);
    if (uri === undefined || (target === undefined && editor?.document.languageId !== LANGUAGE)) {
      void vscode.window.showInformationMessage('Open a .gen file first.');
      return;
    }
    if (this.server.running === undefined) {
      await notRunning(this.server);
      return;
    }
    const answer = await this.ask(uri, target ?? (editor === undefined ? {} : { position: editor.selection.active }));
    if (answer === null || answer.component === null || answer.owner === null || answer.place === null) {
      void vscode.window.showInformationMessage('There is no state machine at the cursor.');
      return;
    }
    const { component, owner } = answer;
    const known = this.zones.filter((it) => it.uri.toString() === uri.toString() && it.component === component && it.owner === owner);
    if (known.length > 0) {
      this.remove(known);
      return;
    }
    const thread = this.controller.createCommentThread(uri, at(answer.place), []);
    thread.canReply = false;
    thread.collapsibleState = vscode.CommentThreadCollapsibleState.Expanded;
    const zone = { thread, uri, component, owner };
    this.zones.push(zone);
    fill(zone, answer);
  }

  private remove(zones: Zone[]): void {
    this.zones = this.zones.filter((it) => !zones.includes(it));
    for (const { thread } of zones) {
      thread.dispose();
    }
  }

  private refresh(delay: number): void {
    if (this.zones.length > 0) {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => void this.update(), delay);
    }
  }

  private async update(): Promise<void> {
    for (const zone of [...this.zones]) {
      try {
        const answer = await this.ask(zone.uri, zone);
        if (answer !== null) {
          fill(zone, answer);
        } else if (this.server.running !== undefined) {
          // The task or activity has gone, and so does its picture.
          this.remove([zone]);
        }
      } catch (error) {
        // Overtaken by typing: what is typed next, or the pause after it, asks again.
        if (overtaken(error)) this.refresh(TYPING_PAUSE_MS);
      }
    }
  }

  private async ask(uri: vscode.Uri, what: { position?: vscode.Position; component?: string; owner?: string }): Promise<DiagramAnswer | null> {
    const { running: client } = this.server;
    if (client === undefined) {
      return null;
    }
    const { position, component, owner } = what;
    return client.sendRequest(diagram, {
      textDocument: { uri: uri.toString() },
      kind: 'fsm',
      // An image cannot see the theme of the editor around it.
      theme: isDark() ? 'dark-clear' : 'light-clear',
      ...(position === undefined ? {} : { position: client.code2ProtocolConverter.asPosition(position) }),
      ...(component === undefined ? {} : { component }),
      ...(owner === undefined ? {} : { owner }),
    });
  }
}

/** Under the line of the name. */
function at({ selectionRange: { start } }: NonNullable<DiagramAnswer['place']>): vscode.Range {
  return new vscode.Range(start.line, 0, start.line, 0);
}

function fill(zone: Zone, answer: DiagramAnswer): void {
  const { thread } = zone;
  const state = `${answer.stale === null ? 'good' : 'stale'} ${answer.picture}`;
  if (answer.stale === null && answer.place !== null && thread.range?.start.line !== answer.place.selectionRange.start.line) {
    thread.range = at(answer.place);
  }
  if (zone.shown === state) {
    return;
  }
  zone.shown = state;
  const data = Buffer.from(answer.picture, 'utf8').toString('base64');
  const isLimited = vscode.workspace.getConfiguration('comments').get('maxHeight', true);
  const height = Math.round(Math.min(answer.height, isLimited ? HIGHEST_WITHOUT_SCROLLING : HIGHEST));
  const width = Math.round((answer.width * height) / answer.height);
  const body = new vscode.MarkdownString(`![state machine ${answer.title}](data:image/svg+xml;base64,${data}|width=${width},height=${height})`);
  if (answer.stale !== null) {
    body.appendMarkdown('\n\nThe text has an error; this is the last good picture.');
  }
  // The one header: a comment without an author has none.
  thread.label = answer.title;
  thread.comments = [{ body, mode: vscode.CommentMode.Preview, author: { name: '' } }];
}
