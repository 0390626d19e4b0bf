// Says what a fix has changed in files that are not in sight: otherwise nothing seems to have happened.
import * as vscode from 'vscode';
import type { Changed } from '../review';

const SHOWN_FOR_MS = 15_000;

export class Changes implements vscode.Disposable {
  private item: vscode.StatusBarItem | undefined;
  private timer: NodeJS.Timeout | undefined;

  dispose(): void {
    clearTimeout(this.timer);
    this.item?.dispose();
    this.item = undefined;
  }

  /** Shows the files in the status bar for a while. A click opens the first of them. */
  tell(title: string, changed: Changed[]): void {
    const visible = vscode.window.visibleTextEditors.map((it) => it.document.uri.toString());
    const others = changed.map(({ uri, edits }) => ({ uri: vscode.Uri.parse(uri), edits })).filter(({ uri }) => !visible.includes(uri.toString()));
    const [first] = others;
    this.dispose();
    if (first === undefined) {
      return;
    }
    const files = others.map(({ uri, edits }) => `${vscode.workspace.asRelativePath(uri)} (${edits} ${edits === 1 ? 'change' : 'changes'})`);
    const item = vscode.window.createStatusBarItem('dotgen.changes', vscode.StatusBarAlignment.Left, -1);
    item.name = 'dotgen: changes of a fix';
    item.text = `$(edit) Changed ${files[0]}${files.length > 1 ? ` and ${files.length - 1} more` : ''} · Open`;
    item.tooltip = [title.replaceAll('`', ''), ...files].join('\n');
    item.command = { title: 'Open', command: 'vscode.open', arguments: [first.uri] };
    item.show();
    this.item = item;
    this.timer = setTimeout(() => this.dispose(), SHOWN_FOR_MS);
  }
}
