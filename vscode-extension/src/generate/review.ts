// Showing what a template would write, before it does: a comparison of all files, then a question.
import { chmod } from 'node:fs/promises';
import * as vscode from 'vscode';
import type { FileChange, Plan } from './protocol';

const SCHEME = 'dotgen-generated';

interface FileItem extends vscode.QuickPickItem {
  file: FileChange;
}

/** The texts before and after, for the comparison. */
export class Review implements vscode.TextDocumentContentProvider, vscode.Disposable {
  private texts = new Map<string, string>();
  private number = 0;
  private readonly registration = vscode.workspace.registerTextDocumentContentProvider(SCHEME, this);

  dispose(): void {
    this.registration.dispose();
  }

  provideTextDocumentContent(uri: vscode.Uri): string {
    return this.texts.get(uri.toString()) ?? '';
  }

  /** Shows the files and writes those the user wants; whether there were any. */
  async confirm(title: string, plan: Plan): Promise<boolean> {
    await this.show(title, plan.files);
    const created = plan.files.filter((it) => it.change === 'create').length;
    const changed = plan.files.length - created;
    const counts = [created > 0 ? `${created} new` : '', changed > 0 ? `${changed} changed` : ''].filter((it) => it !== '').join(', ');
    const marked = plan.files.filter((it) => it.concern).map((it) => `${vscode.workspace.asRelativePath(vscode.Uri.parse(it.uri))} is ${it.concern}. `);
    const question = `${title}: ${counts}. ${marked.join('')}Nothing is written yet.`;
    const choices = [...(marked.length > 0 ? [] : ['Write']), 'Choose Files…', 'Discard'];
    const answer = await vscode.window.showInformationMessage(question, ...choices);
    let files: FileChange[] | undefined;
    if (answer === 'Write') {
      files = plan.files;
    } else if (answer === 'Choose Files…') {
      files = await choose(title, plan.files);
    }
    await this.close();
    if (files === undefined || files.length === 0) {
      return false;
    }
    return write(title, files);
  }

  private async show(title: string, files: FileChange[]): Promise<void> {
    this.texts = new Map();
    this.number += 1;
    const pairs = files.map((file) => {
      const uri = vscode.Uri.parse(file.uri);
      const side = (name: string, text: string): vscode.Uri => {
        const it = uri.with({ scheme: SCHEME, authority: '', query: `${name}-${this.number}` });
        this.texts.set(it.toString(), text);
        return it;
      };
      const before = file.before === null ? undefined : side('before', file.before);
      return [uri, before, side('after', file.after)];
    });
    await vscode.commands.executeCommand('vscode.changes', title, pairs);
  }

  private async close(): Promise<void> {
    const generated = (uri: vscode.Uri | undefined): boolean => uri?.scheme === SCHEME;
    const ours = vscode.window.tabGroups.all
      .flatMap((group) => group.tabs)
      .filter(({ input, label }) =>
        input instanceof vscode.TabInputTextDiff ? generated(input.modified) : input instanceof vscode.TabInputText ? generated(input.uri) : label.startsWith('Generate: '),
      );
    await vscode.window.tabGroups.close(ours);
  }
}

async function choose(title: string, files: FileChange[]): Promise<FileChange[] | undefined> {
  const items = files.map((file): FileItem => ({
    label: vscode.workspace.asRelativePath(vscode.Uri.parse(file.uri)),
    description: (file.change === 'create' ? 'new' : 'changed') + (file.concern ? `, ${file.concern}` : ''),
    picked: !file.concern,
    file,
  }));
  const picked = await vscode.window.showQuickPick(items, { title, placeHolder: 'Files to write', canPickMany: true });
  return picked?.map((it) => it.file);
}

/** Makes the changes as one edit that can be undone, saves them, and sets permissions. */
async function write(title: string, files: FileChange[]): Promise<boolean> {
  const edit = new vscode.WorkspaceEdit();
  for (const file of files) {
    const uri = vscode.Uri.parse(file.uri);
    if (file.before === null) {
      edit.createFile(uri, { contents: Buffer.from(file.after), overwrite: false });
    } else {
      const document = await vscode.workspace.openTextDocument(uri);
      edit.replace(uri, new vscode.Range(0, 0, document.lineCount, 0), file.after);
    }
  }
  if (!(await vscode.workspace.applyEdit(edit, { isRefactoring: true }))) {
    void vscode.window.showErrorMessage(`${title}: the files could not be written.`);
    return false;
  }
  for (const file of files) {
    const uri = vscode.Uri.parse(file.uri);
    const open = vscode.workspace.textDocuments.find((it) => it.uri.toString() === uri.toString());
    if (open?.isDirty === true) {
      await open.save();
    }
    if (file.mode !== null && uri.scheme === 'file') {
      await chmod(uri.fsPath, file.mode).catch(() => undefined);
    }
  }
  return true;
}
