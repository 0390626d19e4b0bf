// Open Example…: copies an example of the package into a folder that the user picks, and opens the copy.
import * as vscode from 'vscode';
import { reported } from '../failure';

interface Example {
  name: string;
  description: string;
}

const TITLE = 'Open Example';

export function openExample(extension: vscode.Uri): Promise<void> {
  return reported(async () => {
    const examples = vscode.Uri.joinPath(extension, 'dist', 'examples');
    const list = JSON.parse(Buffer.from(await vscode.workspace.fs.readFile(vscode.Uri.joinPath(examples, 'list.json'))).toString('utf8')) as Example[];
    const items = list.map(({ name, description }) => ({ label: name, description }));
    const picked = await vscode.window.showQuickPick(items, { title: TITLE, ignoreFocusOut: true, placeHolder: 'Example to copy', matchOnDescription: true });
    if (picked === undefined) return;
    const parent = await vscode.window.showOpenDialog({
      canSelectFolders: true,
      canSelectFiles: false,
      title: `Folder that gets the folder ${picked.label}`,
      openLabel: 'Copy Here',
    });
    if (parent?.[0] === undefined) return;
    const folder = vscode.Uri.joinPath(parent[0], picked.label);
    try {
      await vscode.workspace.fs.copy(vscode.Uri.joinPath(examples, picked.label), folder, { overwrite: false });
    } catch (error) {
      if (!(error instanceof vscode.FileSystemError) || error.code !== 'FileExists') throw error;
      void vscode.window.showErrorMessage(`The example was not copied: ${folder.fsPath} exists. Choose another folder, or rename that one.`);
      return;
    }
    // The window of another folder stays.
    await vscode.commands.executeCommand('vscode.openFolder', folder, { forceNewWindow: vscode.workspace.workspaceFolders !== undefined });
  });
}
