// The diagram beside the text: follows the cursor and the typing, and leads back to the text.
import * as vscode from 'vscode';
import { overtaken, type Server } from '../client';
import { ready } from '../commands/server';
import { diagram, LANGUAGE, type Arrangement, type DiagramAnswer, type DiagramKind, type DiagramNode, type DiagramParams } from '../protocol';
import { SidePanel } from '../panel/panel';
import { range, reveal } from '../panel/reveal';
import type { Ran } from '../run/messages';
import { writeOut } from '../verification/writeOut';
import type { FromPage, Live, Subject, ToPage } from './messages';
import { nodeAt } from './machine';
import { page } from './page';
import { isDark, type Target } from './target';
import { done } from '../walkthrough';

const TYPING_PAUSE_MS = 40;
/** Class of nodes on a chain of data. */
const MARKED = 'marked';
/** Where the workspace keeps what was made of its system. */
const ARRANGEMENT = 'diagram.arrangement';

export class DiagramPreview extends SidePanel<Subject, FromPage, ToPage> {
  private nodes: DiagramNode[] = [];
  private ran: Ran | undefined;
  private selected: string | undefined;
  /** Width of the view, in pixels, once the page has told it. */
  private width: number | undefined;
  private timer: NodeJS.Timeout | undefined;
  // Where the picture is wanted, until it has been drawn: the page may ask before the first answer is there.
  private at: vscode.Position | undefined;
  // Answers to older questions are dropped, and their work is ended.
  private asked: vscode.CancellationTokenSource | undefined;
  private readonly subscriptions: vscode.Disposable;

  constructor(
    private readonly server: Server,
    private readonly extensionUri: vscode.Uri,
    private readonly memory: vscode.Memento,
    /** What runs, whenever that has come further. */
    runs: vscode.Event<Ran | undefined>,
  ) {
    super({ type: 'dotgen.diagram', title: 'Diagram', find: false, page }, extensionUri);
    this.subscriptions = vscode.Disposable.from(
      vscode.workspace.onDidChangeTextDocument(({ document }) => {
        if (document.languageId === LANGUAGE && this.panel !== undefined) {
          this.refresh(TYPING_PAUSE_MS);
        }
      }),
      vscode.window.onDidChangeTextEditorSelection(({ textEditor }) => this.follow(textEditor)),
      vscode.window.onDidChangeActiveTextEditor((editor) => editor !== undefined && this.follow(editor)),
      vscode.languages.onDidChangeDiagnostics(() => this.sendDiagnostics()),
      server.onDidChange(() => this.refresh(0)),
      runs((it) => {
        this.ran = it;
        this.sendLive();
      }),
    );
  }

  override dispose(): void {
    clearTimeout(this.timer);
    this.asked?.cancel();
    this.subscriptions.dispose();
    super.dispose();
  }

  /** Opens the preview on what a lens names, or on what is at the cursor. */
  async show(kind: DiagramKind, target?: Target): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    const uri = target?.uri ?? (editor?.document.languageId === LANGUAGE ? editor.document.uri.toString() : undefined);
    if (uri === undefined) {
      void vscode.window.showInformationMessage('Open a .gen file first.');
      return;
    }
    if ((await ready(this.server)) === undefined) return;
    this.subject = {
      uri,
      kind,
      options: this.subject?.options ?? {},
      ...(target?.component === undefined ? {} : { component: target.component }),
      ...(target?.owner === undefined ? {} : { owner: target.owner }),
    };
    await this.open();
    await this.draw(target === undefined ? editor?.selection.active : undefined);
  }

  protected update(): Promise<void> {
    return this.draw();
  }

  protected closed(): void {
    this.asked?.cancel();
    this.nodes = [];
  }

  protected receive(message: FromPage): Promise<void> | void {
    switch (message.type) {
      case 'ready':
        return this.draw();
      case 'width':
        this.width = message.width;
        return this.subject?.kind === 'system' ? this.draw() : undefined;
      case 'jump':
        return this.jump(message.id, message.line);
      case 'open':
        return this.arrange(({ opened, moved }) => ({ opened: { ...opened, [message.id]: message.open }, moved }));
      case 'move':
        return this.arrange(({ opened, moved }) => {
          const [x, y] = moved[message.id] ?? [0, 0];
          const [dx, dy] = message.by;
          return { opened, moved: { ...moved, [message.id]: [Math.round(x + dx), Math.round(y + dy)] } };
        });
      case 'arrange':
        return this.arrange(() => ({ opened: {}, moved: {} }));
      case 'scenario':
        return this.subject === undefined ? undefined : writeOut(vscode.Uri.parse(this.subject.uri));
      case 'aboutChains':
        return void vscode.commands.executeCommand('markdown.showPreview', vscode.Uri.joinPath(this.extensionUri, 'docs', 'verification.md').with({ fragment: 'chains' }));
      case 'way':
        if (this.subject !== undefined) {
          this.subject = { ...this.subject, way: message.states };
        }
        return this.draw();
      case 'select':
        this.selected = message.id;
        return this.sendDiagnostics();
      case 'kind':
        if (this.subject !== undefined) {
          this.subject = { ...this.subject, kind: message.kind };
        }
        return this.draw();
      case 'options':
        if (this.subject !== undefined) {
          this.subject = { ...this.subject, options: message.options };
        }
        return this.draw();
      case 'export':
        return this.export(message.format);
      case 'png':
        return this.save('png', Buffer.from(message.data, 'base64'));
    }
  }

  private get arrangement(): Arrangement {
    return this.memory.get<Arrangement>(ARRANGEMENT) ?? { opened: {}, moved: {} };
  }

  private async arrange(change: (now: Arrangement) => Arrangement): Promise<void> {
    await this.memory.update(ARRANGEMENT, change(this.arrangement));
    await this.draw();
  }

  private refresh(delay: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.draw(), delay);
  }

  private async ask(position?: vscode.Position, more: Partial<DiagramParams> = {}, token?: vscode.CancellationToken): Promise<DiagramAnswer | null | undefined> {
    const { running: client } = this.server;
    const { subject } = this;
    if (client === undefined || subject === undefined) {
      return undefined;
    }
    const { uri, kind, component, owner, options, way } = subject;
    const wanted: DiagramParams = {
      textDocument: { uri },
      kind,
      ...options,
      ...(kind === 'system' ? this.arrangement : {}),
      ...(kind === 'system' && this.width !== undefined ? { width: this.width } : {}),
      ...(way === undefined || kind !== 'fsm' ? {} : { way }),
      ...(component === undefined ? {} : { component }),
      ...(owner === undefined ? {} : { owner }),
      ...(position === undefined ? {} : { position: client.code2ProtocolConverter.asPosition(position) }),
      ...more,
    };
    return client.sendRequest(diagram, wanted, token);
  }

  private async draw(position = this.at): Promise<void> {
    this.at = position;
    const { panel, subject } = this;
    if (panel === undefined || subject === undefined) {
      return;
    }
    this.asked?.cancel();
    const { token } = (this.asked = new vscode.CancellationTokenSource());
    let answer: DiagramAnswer | null | undefined;
    try {
      answer = await this.ask(position, {}, token);
    } catch (error) {
      // Overtaken by typing: what is typed next, or the pause after it, asks again.
      if (overtaken(error) && !token.isCancellationRequested) this.refresh(TYPING_PAUSE_MS);
      return;
    }
    if (token.isCancellationRequested || answer === undefined) {
      return;
    }
    if (answer === null) {
      this.send({ type: 'notice', text: this.nodes.length > 0 ? 'There is nothing to draw here; this is the last picture.' : 'There is no state machine here.' });
      return;
    }
    const { component, owner, way } = subject;
    // A state of the same name in another machine is another state.
    if (way !== undefined && way.length > 0 && (answer.component !== component || answer.owner !== owner)) {
      this.subject = { ...subject, way: [] };
      return this.draw(position);
    }
    this.subject = { ...subject, kind: answer.kind };
    if (answer.component !== null) {
      this.subject.component = answer.component;
    }
    if (answer.owner !== null) {
      this.subject.owner = answer.owner;
    }
    this.at = undefined;
    this.nodes = answer.nodes;
    panel.title = answer.title;
    const { title, picture: svg, width, height, nodes } = answer;
    const told = answer.kind === 'fsm' && (way?.length ?? 0) > 1 ? answer.notes.at(-1) : undefined;
    const { opened, moved } = this.arrangement;
    const arranged = Object.keys(opened).length + Object.keys(moved).length > 0;
    const withoutChains = answer.kind === 'system' && this.subject.options.chains === true && !nodes.some((it) => it.classes.includes(MARKED));
    if (answer.kind === 'fsm') done('machine');
    this.send({ type: 'picture', shown: { subject: this.subject, title, svg, width, height, nodes, told, withoutChains, arranged } });
    const stale = answer.stale === null ? undefined : `The text has an error (${answer.stale}); this is the last good picture.`;
    const incomplete = answer.incomplete === null ? undefined : `The text has an error (${answer.incomplete}); something may be missing.`;
    this.send({ type: 'notice', text: stale ?? incomplete });
    this.sendLive();
    const active = vscode.window.activeTextEditor;
    const of = vscode.window.visibleTextEditors.find((it) => it.document.uri.toString() === subject.uri);
    const editor = active !== undefined && this.shows(active) ? active : of;
    if (editor !== undefined) {
      this.highlight(editor);
    }
    this.sendDiagnostics();
  }

  /** The picture of what is at the cursor, and the state there. */
  private follow(editor: vscode.TextEditor): void {
    if (this.panel === undefined || this.subject === undefined || editor.document.languageId !== LANGUAGE) {
      return;
    }
    const uri = editor.document.uri.toString();
    if (this.highlight(editor) || (uri !== this.subject.uri && this.shows(editor))) {
      return;
    }
    if (uri !== this.subject.uri) {
      const { kind, options } = this.subject;
      this.subject = { uri, kind, options };
    }
    void this.draw(editor.selection.active);
  }

  /** Whether something of the picture is written in a document. */
  private shows(editor: vscode.TextEditor): boolean {
    const uri = editor.document.uri.toString();
    return this.nodes.some((it) => it.place?.uri === uri);
  }

  /** Marks the innermost node around the cursor; false if there is none. */
  private highlight(editor: vscode.TextEditor): boolean {
    const node = nodeAt(this.nodes, editor.document.uri.toString(), editor.selection.active);
    this.send({ type: 'highlight', id: node?.id });
    return node !== undefined;
  }

  private async jump(id: string, line?: number): Promise<void> {
    const node = this.nodes.find((it) => it.id === id);
    const place = (line === undefined ? undefined : node?.parts[line]) ?? node?.place;
    if (place === undefined || place === null) {
      return;
    }
    await reveal(place.uri, place.selectionRange);
  }

  /** What a run does in the machine that is shown. */
  private sendLive(): void {
    const { ran, subject } = this;
    if (subject === undefined || this.panel === undefined) return;
    const name = subject.kind === 'fsm' ? `${subject.component ?? ''}.${subject.owner ?? ''}` : undefined;
    const machine = ran?.machines.find((it) => it.machine === name);
    const activities = ran?.activities.filter((it) => it.machine === name) ?? [];
    const live: Live | undefined = ran === undefined || machine === undefined ? undefined : { unit: ran.unit, transitions: machine.transitions, activities };
    this.send({ type: 'live', live });
  }

  private sendDiagnostics(): void {
    const node = this.nodes.find((it) => it.id === this.selected);
    if (node === undefined || node.place === null) {
      return;
    }
    const at = range(node.place.range);
    const all = vscode.languages.getDiagnostics(vscode.Uri.parse(node.place.uri));
    const messages = all.filter((it) => at.intersection(it.range) !== undefined).map((it) => it.message);
    this.send({ type: 'diagnostics', id: node.id, messages });
  }

  private async export(format: 'svg' | 'png'): Promise<void> {
    const image = isDark() ? 'dark' : 'light';
    let answer: DiagramAnswer | null | undefined;
    try {
      answer = await this.ask(undefined, { theme: format === 'svg' ? 'auto' : image });
    } catch {
      void vscode.window.showWarningMessage('The text changed while the picture was drawn. Export it again.');
      return;
    }
    if (answer === null || answer === undefined) {
      return;
    }
    if (format === 'svg') {
      await this.save('svg', Buffer.from(answer.picture, 'utf8'));
    } else {
      this.send({ type: 'raster', svg: answer.picture, width: answer.width, height: answer.height });
    }
  }

  private async save(extension: string, bytes: Uint8Array): Promise<void> {
    if (this.subject === undefined) {
      return;
    }
    const { uri, kind, component, owner } = this.subject;
    const parts = { fsm: [component, owner], system: ['system'], locks: [component, 'locks'] }[kind];
    const name = parts.filter((it) => it !== undefined).join('.');
    const defaultUri = vscode.Uri.joinPath(vscode.Uri.parse(uri), '..', `${name}.${extension}`);
    const file = await vscode.window.showSaveDialog({ defaultUri, filters: { [extension.toUpperCase()]: [extension] } });
    if (file !== undefined) {
      try {
        await vscode.workspace.fs.writeFile(file, bytes);
      } catch (error) {
        void vscode.window.showErrorMessage(`The picture was not written: ${error instanceof Error ? error.message : String(error)}`);
      }
    }
  }
}
