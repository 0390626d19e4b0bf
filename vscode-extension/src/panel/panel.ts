// What the panels beside the text have in common: there is one of each kind, it comes back with the window, and its page
// talks to us.
import * as vscode from 'vscode';
import { reported } from '../failure';
import { columnOfPanel } from './column';

export interface PanelKind {
  /** What the editor keeps it by. */
  type: string;
  /** Title until there is something to show. */
  title: string;
  /** The editor's own search in the page. */
  find: boolean;
  page: (webview: vscode.Webview, extension: vscode.Uri) => string;
}

export abstract class SidePanel<Subject, FromPage, ToPage> implements vscode.Disposable, vscode.WebviewPanelSerializer<Subject> {
  protected panel: vscode.WebviewPanel | undefined;
  protected subject: Subject | undefined;
  private readonly serializer: vscode.Disposable;

  protected constructor(
    private readonly kind: PanelKind,
    private readonly extension: vscode.Uri,
  ) {
    this.serializer = vscode.window.registerWebviewPanelSerializer(kind.type, this);
  }

  /** Asks for what the panel shows. */
  protected abstract update(): Promise<void>;
  protected abstract receive(message: FromPage): Promise<void> | void;
  /** The panel was closed. */
  protected abstract closed(): void;

  dispose(): void {
    this.serializer.dispose();
    this.panel?.dispose();
  }

  async deserializeWebviewPanel(panel: vscode.WebviewPanel, state: Subject | undefined): Promise<void> {
    // The panel that was opened before the window had restored this one stays.
    if (this.panel !== undefined) {
      panel.dispose();
      return;
    }
    this.subject = state;
    this.adopt(panel);
    await this.update();
  }

  /** Brings the panel to the front, beside or below the text. */
  protected async open(): Promise<void> {
    const viewColumn = this.panel === undefined ? await columnOfPanel() : undefined;
    // Another call, or the window, may have opened it meanwhile.
    if (this.panel !== undefined) {
      this.panel.reveal(undefined, true);
      return;
    }
    const { type, title, find } = this.kind;
    const place = { viewColumn: viewColumn ?? vscode.ViewColumn.Beside, preserveFocus: true };
    this.adopt(vscode.window.createWebviewPanel(type, title, place, { enableFindWidget: find }));
  }

  protected send(message: ToPage): void {
    void this.panel?.webview.postMessage(message);
  }

  private adopt(panel: vscode.WebviewPanel): void {
    this.panel = panel;
    panel.webview.options = { enableScripts: true, localResourceRoots: [vscode.Uri.joinPath(this.extension, 'dist')] };
    panel.onDidDispose(() => {
      if (this.panel !== panel) return;
      this.panel = undefined;
      this.closed();
    });
    panel.webview.onDidReceiveMessage((message: FromPage) => void reported(() => this.receive(message)));
    panel.webview.html = this.kind.page(panel.webview, this.extension);
  }
}
