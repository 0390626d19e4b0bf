// From a place that the server gave to the text.
import * as vscode from 'vscode';
import type { Range } from 'vscode-languageclient/node';

export function range({ start, end }: Range): vscode.Range {
  return new vscode.Range(start.line, start.character, end.line, end.character);
}

/** Shows a place, in the editor that has the file already if there is one. */
export async function reveal(uri: string, at: Range): Promise<void> {
  const shown = vscode.window.visibleTextEditors.find((it) => it.document.uri.toString() === uri);
  await vscode.window.showTextDocument(vscode.Uri.parse(uri), { selection: range(at), viewColumn: shown?.viewColumn ?? vscode.ViewColumn.One });
}

/** The menus of an editor, with the command and the kind of what they offer. */
const MENUS = {
  fixes: ['editor.action.quickFix', vscode.CodeActionKind.QuickFix],
  refactorings: ['editor.action.refactor', vscode.CodeActionKind.Refactor],
} as const;

/** Shows a place with a menu of what can be done there. */
export async function offer(menu: keyof typeof MENUS, uri: string, at: Range): Promise<void> {
  await reveal(uri, at);
  const [command, kind] = MENUS[menu];
  // So the menu has its answer at once: the next automatic request of the editor can cancel a slow one.
  await vscode.commands.executeCommand('vscode.executeCodeActionProvider', vscode.Uri.parse(uri), range(at), kind.value);
  await vscode.commands.executeCommand(command);
}
