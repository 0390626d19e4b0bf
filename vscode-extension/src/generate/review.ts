// Showing what a template or an export would write, before it does: a comparison of all files, then a question.
import { chmod } from 'node:fs/promises';
import * as vscode from 'vscode';
import type { FileChange } from './protocol';
import { isStale } from './stale';

const SCHEME = 'dotgen-generated';

/** `all`: every file may be written at once; `some`: files that act later have to be chosen. */
const CONTEXT = 'dotgen.preview';

type Answer = 'write' | 'choose' | 'elsewhere' | 'discard';

/** Asks for another folder, and gives the files there. */
type Elsewhere = () => Promise<FileChange[] | undefined>;

interface FileItem extends vscode.QuickPickItem {
  file: FileChange;
}

/** The texts before and after, for the comparison. */
export class Review implements vscode.TextDocumentContentProvider, vscode.Disposable {
  private texts = new Map<string, string>();
  private number = 0;
  /** Answers the question that is open. */
  private answer: ((it: Answer) => void) | undefined;
  private readonly registrations = vscode.Disposable.from(
    vscode.workspace.registerTextDocumentContentProvider(SCHEME, this),
    vscode.commands.registerCommand('dotgen.writeGenerated', () => this.answer?.('write')),
    vscode.commands.registerCommand('dotgen.chooseGenerated', () => this.answer?.('choose')),
    vscode.commands.registerCommand('dotgen.discardGenerated', () => this.answer?.('discard')),
    // To close the preview is an answer too.
    vscode.window.tabGroups.onDidChangeTabs(({ closed }) => closed.some(isOurs) && !tabs().some(isOurs) && this.answer?.('discard')),
  );

  dispose(): void {
    this.answer?.('discard');
    this.registrations.dispose();
  }

  provideTextDocumentContent(uri: vscode.Uri): string {
    return this.texts.get(uri.toString()) ?? '';
  }

  /** Shows the files and writes those the user wants and that have not changed meanwhile; whether there were any. */
  async confirm(title: string, files: FileChange[], elsewhere?: Elsewhere): Promise<boolean> {
    await this.show(title, files);
    const created = files.filter((it) => it.change === 'create').length;
    const changed = files.length - created;
    const counts = [created > 0 ? `${created} new` : '', changed > 0 ? `${changed} changed` : ''].filter((it) => it !== '').join(', ');
    const marked = files.filter((it) => it.concern).map((it) => `${vscode.workspace.asRelativePath(vscode.Uri.parse(it.uri))} is ${it.concern}. `);
    const question = `${title}: ${counts}. ${marked.join('')}Nothing is written yet.`;
    const answer = await this.ask(question, marked.length > 0, elsewhere !== undefined);
    const moved = answer === 'elsewhere' ? await elsewhere?.() : undefined;
    let wanted: FileChange[] = [];
    if (answer === 'write') {
      wanted = files;
    } else if (answer === 'choose') {
      wanted = (await choose(title, files)) ?? [];
    }
    await this.close();
    if (moved !== undefined) {
      return this.confirm(title, moved, elsewhere);
    }
    return wanted.length > 0 && write(title, wanted);
  }

  /** The buttons are in the title of the preview and in the message. A message that is closed answers nothing. */
  private async ask(question: string, choose: boolean, moves: boolean): Promise<Answer> {
    this.answer?.('discard');
    const answered = new Promise<Answer>((resolve) => (this.answer = resolve));
    const mine = this.answer;
    await vscode.commands.executeCommand('setContext', CONTEXT, choose ? 'some' : 'all');
    const choices: (vscode.MessageItem & { answer: Answer })[] = [
      ...(choose ? [] : [{ title: 'Write', answer: 'write' as const }]),
      { title: 'Choose Files…', answer: 'choose' },
      ...(moves ? [{ title: 'Other Folder…', answer: 'elsewhere' as const }] : []),
      { title: 'Discard', answer: 'discard' },
    ];
    void vscode.window.showInformationMessage(question, ...choices).then((it) => it !== undefined && mine?.(it.answer));
    const answer = await answered;
    if (this.answer === mine) {
      this.answer = undefined;
      await vscode.commands.executeCommand('setContext', CONTEXT, undefined);
    }
    return answer;
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
    await vscode.window.tabGroups.close(tabs().filter(isOurs));
  }
}

function tabs(): vscode.Tab[] {
  return vscode.window.tabGroups.all.flatMap((group) => [...group.tabs]);
}

/** A tab of a preview. */
function isOurs({ input, label }: vscode.Tab): boolean {
  if (input instanceof vscode.TabInputTextDiff) return input.modified.scheme === SCHEME;
  if (input instanceof vscode.TabInputText) return input.uri.scheme === SCHEME;
  return /^(Generate|Export): /.test(label);
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
async function write(title: string, wanted: FileChange[]): Promise<boolean> {
  const edit = new vscode.WorkspaceEdit();
  const files: FileChange[] = [];
  const stale: string[] = [];
  for (const file of wanted) {
    const uri = vscode.Uri.parse(file.uri);
    const document = await documentAt(uri);
    if (isStale(document?.getText(), file.before)) {
      stale.push(vscode.workspace.asRelativePath(uri));
      continue;
    }
    files.push(file);
    if (document === undefined) {
      edit.createFile(uri, { contents: Buffer.from(file.after), overwrite: false });
    } else {
      edit.replace(uri, new vscode.Range(0, 0, document.lineCount, 0), file.after);
    }
  }
  if (stale.length > 0) {
    const [them, text] = stale.length === 1 ? ['it was', 'the text'] : ['they were', 'the texts'];
    void vscode.window.showWarningMessage(`${title}: ${stale.join(', ')} changed after the preview, so ${them} not written. Repeat the command to compare ${text}.`);
  }
  if (files.length === 0) {
    return false;
  }
  if (!(await vscode.workspace.applyEdit(edit, { isRefactoring: true }))) {
    void vscode.window.showErrorMessage(`${title}: the files could not be written.`);
    return false;
  }
  for (const file of files) {
    const uri = vscode.Uri.parse(file.uri);
    const open = openDocument(uri);
    if (open?.isDirty === true) {
      await open.save();
    }
    if (file.mode !== null && uri.scheme === 'file') {
      await chmod(uri.fsPath, file.mode).catch(() => undefined);
    }
  }
  return true;
}

function openDocument(uri: vscode.Uri): vscode.TextDocument | undefined {
  return vscode.workspace.textDocuments.find((it) => it.uri.toString() === uri.toString());
}

/** The text of a file in the editor, or else on the disk; undefined if there is no file. */
async function documentAt(uri: vscode.Uri): Promise<vscode.TextDocument | undefined> {
  const exists = await vscode.workspace.fs.stat(uri).then(() => true, () => false);
  return exists ? vscode.workspace.openTextDocument(uri) : undefined;
}
