// Expand Macro at Cursor: what a macro call stands for, in a read-only document beside the editor.
import * as vscode from 'vscode';
import type { Server } from '../client';
import { expandMacro, LANGUAGE } from '../protocol';
import { ready } from './server';

const SCHEME = 'dotgen-expansion';

export class MacroExpansion implements vscode.TextDocumentContentProvider, vscode.Disposable {
  private readonly changed = new vscode.EventEmitter<vscode.Uri>();
  readonly onDidChange = this.changed.event;
  private readonly texts = new Map<string, string>();
  private readonly registration: vscode.Disposable;

  constructor(private readonly server: Server) {
    this.registration = vscode.workspace.registerTextDocumentContentProvider(SCHEME, this);
  }

  dispose(): void {
    this.registration.dispose();
    this.changed.dispose();
  }

  provideTextDocumentContent(uri: vscode.Uri): string {
    return this.texts.get(uri.toString()) ?? '';
  }

  async expand(): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    if (editor?.document.languageId !== LANGUAGE) {
      void vscode.window.showInformationMessage('Put the cursor on a macro call in a .gen file first.');
      return;
    }
    const client = await ready(this.server);
    if (client === undefined) return;
    const { code2ProtocolConverter: convert } = client;
    const expansion = await client.sendRequest(expandMacro, {
      textDocument: convert.asTextDocumentIdentifier(editor.document),
      position: convert.asPosition(editor.selection.active),
    });
    if (expansion === null) {
      void vscode.window.showInformationMessage('There is no macro call at the cursor.');
      return;
    }
    const uri = vscode.Uri.from({ scheme: SCHEME, path: `/${expansion.name}.gen` });
    this.texts.set(uri.toString(), expansion.expansion.trimEnd() + '\n');
    this.changed.fire(uri);
    const document = await vscode.workspace.openTextDocument(uri);
    await vscode.window.showTextDocument(document, { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true, preview: true });
  }
}
