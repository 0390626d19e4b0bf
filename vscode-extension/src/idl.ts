// `.idl` is the extension of many languages. Files of that name are taken for GenoM3 interface files in workspace folders
// that hold `.gen` files, and nowhere else.
import * as vscode from 'vscode';
import { mayAssociateIdl } from './config';
import { LANGUAGE } from './protocol';

export class IdlAssociation implements vscode.Disposable {
  // Files given our language. One that then appears with another was changed by the user: leave it.
  private readonly associated = new Set<string>();
  private readonly subscriptions: vscode.Disposable[] = [];

  constructor(private readonly log: vscode.LogOutputChannel) {
    const watcher = vscode.workspace.createFileSystemWatcher('**/*.gen', false, true, true);
    this.subscriptions.push(
      watcher,
      watcher.onDidCreate(() => this.associateOpen()),
      vscode.workspace.onDidOpenTextDocument((document) => void this.associate(document)),
      vscode.workspace.onDidCloseTextDocument((document) => this.closed(document)),
      vscode.workspace.onDidChangeWorkspaceFolders(() => this.associateOpen()),
    );
    this.associateOpen();
  }

  dispose(): void {
    vscode.Disposable.from(...this.subscriptions).dispose();
  }

  private associateOpen(): void {
    for (const document of vscode.workspace.textDocuments) {
      void this.associate(document);
    }
  }

  private async associate(document: vscode.TextDocument): Promise<void> {
    const key = document.uri.toString();
    if (
      document.uri.scheme !== 'file' ||
      !document.uri.path.toLowerCase().endsWith('.idl') ||
      document.languageId === LANGUAGE ||
      this.associated.has(key) ||
      !mayAssociateIdl(document.uri) ||
      !(await holdsSpecifications(document.uri))
    ) {
      return;
    }
    this.associated.add(key);
    try {
      await vscode.languages.setTextDocumentLanguage(document, LANGUAGE);
    } catch (error) {
      // The document was closed meanwhile.
      this.log.debug(`${key}: ${String(error)}`);
    }
  }

  private closed(document: vscode.TextDocument): void {
    const key = document.uri.toString();
    // A change of language shows as a close followed at once by an open.
    setTimeout(() => {
      if (!vscode.workspace.textDocuments.some((open) => open.uri.toString() === key)) {
        this.associated.delete(key);
      }
    }, 0);
  }
}

/** Whether the workspace folder of `file` (any folder, for files outside: installed interfaces) has a `.gen` file. */
async function holdsSpecifications(file: vscode.Uri): Promise<boolean> {
  const folder = vscode.workspace.getWorkspaceFolder(file);
  const folders = folder === undefined ? (vscode.workspace.workspaceFolders ?? []) : [folder];
  for (const { uri } of folders) {
    const found = await vscode.workspace.findFiles(new vscode.RelativePattern(uri, '**/*.gen'), undefined, 1);
    if (found.length > 0) {
      return true;
    }
  }
  return false;
}
