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
