// Writes the scenario that is verified without one to a file.
import * as vscode from 'vscode';

/** The kind of the action of the server. */
const WRITE_SCENARIO = vscode.CodeActionKind.RefactorRewrite.append('scenario');

export async function writeOut(uri: vscode.Uri): Promise<void> {
  const document = await vscode.workspace.openTextDocument(uri);
  const heading = /\bcomponent\s+\w/.exec(document.getText());
  const at = document.positionAt(heading === null ? 0 : heading.index + heading[0].length);
  const actions = await vscode.commands.executeCommand<vscode.CodeAction[]>('vscode.executeCodeActionProvider', uri, new vscode.Range(at, at), WRITE_SCENARIO.value);
  const action = actions.find((action) => action.kind !== undefined && WRITE_SCENARIO.contains(action.kind));
  if (action?.edit === undefined) {
    void vscode.window.showInformationMessage('The scenario cannot be written: there is one already, or the specification has errors.');
    return;
  }
  await vscode.workspace.applyEdit(action.edit);
  const [entry] = action.edit.entries();
  const target = entry?.[0] ?? uri.with({ path: uri.path.replace(/\.gen$/, '.scn') });
  await vscode.window.showTextDocument(target, { viewColumn: vscode.ViewColumn.One });
}
