// Show Syntax Tree: a read-only document beside the editor that follows it.
import * as vscode from 'vscode';
import { overtaken, type Server } from '../client';
import { LANGUAGE, syntaxTree } from '../protocol';

const SCHEME = 'dotgen-tree';
const TREE = vscode.Uri.from({ scheme: SCHEME, path: '/Syntax Tree' });
const TYPING_PAUSE_MS = 200;

export class SyntaxTreeView implements vscode.TextDocumentContentProvider, vscode.Disposable {
  private readonly changed = new vscode.EventEmitter<vscode.Uri>();
  readonly onDidChange = this.changed.event;
  private source: vscode.TextDocument | undefined;
  private timer: NodeJS.Timeout | undefined;
  /** The text on show. */
  private text = '';
  private readonly subscriptions: vscode.Disposable;

  constructor(private readonly server: Server) {
    this.subscriptions = vscode.Disposable.from(
      vscode.workspace.registerTextDocumentContentProvider(SCHEME, this),
      vscode.window.onDidChangeActiveTextEditor((editor) => this.follow(editor)),
      vscode.workspace.onDidChangeTextDocument(({ document }) => {
        if (document === this.source) {
          this.refresh(TYPING_PAUSE_MS);
        }
      }),
      server.onDidChange(() => this.refresh(0)),
    );
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.subscriptions.dispose();
    this.changed.dispose();
  }

  async show(): Promise<void> {
    this.follow(vscode.window.activeTextEditor);
    const document = await vscode.workspace.openTextDocument(TREE);
    await vscode.window.showTextDocument(document, { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true, preview: false });
    this.refresh(0);
  }

  async provideTextDocumentContent(_: vscode.Uri, token: vscode.CancellationToken): Promise<string> {
    const client = this.server.running;
    if (this.source === undefined) {
      return 'Open a .gen file to see its syntax tree.';
    }
    if (client === undefined) {
      return 'The dotgen server is not running.';
    }
    try {
      this.text = await client.sendRequest(syntaxTree, { textDocument: client.code2ProtocolConverter.asTextDocumentIdentifier(this.source) }, token);
    } catch (error) {
      // Overtaken by typing: the pause after it asks again.
      if (overtaken(error) && !token.isCancellationRequested) this.refresh(TYPING_PAUSE_MS);
    }
    return this.text;
  }

  private follow(editor: vscode.TextEditor | undefined): void {
    if (editor?.document.languageId === LANGUAGE && editor.document !== this.source) {
      this.source = editor.document;
      this.refresh(0);
    }
  }

  private refresh(delay: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (vscode.workspace.textDocuments.some((document) => document.uri.scheme === SCHEME)) {
        this.changed.fire(TREE);
      }
    }, delay);
  }
}
