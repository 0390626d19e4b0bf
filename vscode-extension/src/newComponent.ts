// New Component…: asks for name, tasks and interfaces, and writes what the server makes of the answers.
import * as vscode from 'vscode';
import type { Server } from './client';
import { ready } from './commands/server';
import { interfaces, newComponent, type InterfaceInfo, type NewTask } from './protocol';
import { questions, titleOf } from './questions';
import { done } from './walkthrough';

/** `exec 10 ms`, `plan`: names with periods, between commas. */
export function parseTasks(text: string): NewTask[] {
  const words = text.split(',').map((it) => it.trim()).filter((it) => it !== '');
  return words.map((it) => {
    const [name = '', ...period] = it.split(/\s+/);
    return period.length === 0 ? { name } : { name, period: period.join(' ') };
  });
}

interface InterfaceItem extends vscode.QuickPickItem {
  it: InterfaceInfo;
  role: 'provides' | 'uses';
}

/** Asks which interfaces it provides or uses; `undefined` when the user gives up. */
async function askInterfaces(known: InterfaceInfo[], title: string): Promise<readonly InterfaceItem[] | undefined> {
  if (known.length === 0) {
    return [];
  }
  const items = known.flatMap((it): InterfaceItem[] =>
    (['provides', 'uses'] as const).filter((role) => role === 'uses' || it.canBeProvided).map((role) => ({
      label: `${role} ${it.name}`,
      description: it.ports.join(', '),
      detail: vscode.workspace.asRelativePath(vscode.Uri.parse(it.uri)),
      it,
      role,
    })),
  );
  return vscode.window.showQuickPick(items, {
    title,
    ignoreFocusOut: true,
    placeHolder: 'Select the interfaces to provide or use, if any, then press OK',
    canPickMany: true,
    matchOnDescription: true,
  });
}

/** The folder in which the folder of the component goes. With no folder open, the dialog asks at once. */
async function askFolder(open: vscode.WorkspaceFolder[], title: string): Promise<vscode.Uri | undefined> {
  const another = { label: '$(folder-opened) Another Folder…', description: '', uri: undefined };
  const items = [...open.map((it) => ({ label: it.name, description: it.uri.fsPath, uri: it.uri as vscode.Uri | undefined })), another];
  const picked = open.length < 2 ? items[0] : await vscode.window.showQuickPick(items, { title, ignoreFocusOut: true, placeHolder: 'Where its folder goes' });
  if (picked === undefined || picked.uri !== undefined) {
    return picked?.uri;
  }
  return (await vscode.window.showOpenDialog({ canSelectFolders: true, canSelectFiles: false, title: `${title}: where the folder of the component goes` }))?.[0];
}

/** The specification to show when the window has opened the folder of its component. */
const OPENED = 'openedComponent';

/** Shows the component for which this window was opened. */
export async function showNewComponent(state: vscode.Memento): Promise<void> {
  const uri = state.get<string>(OPENED);
  if (uri !== undefined && vscode.workspace.getWorkspaceFolder(vscode.Uri.parse(uri)) !== undefined) {
    await state.update(OPENED, undefined);
    // Its step of the walkthrough is done.
    done('component');
    await vscode.window.showTextDocument(vscode.Uri.parse(uri)).then(undefined, () => undefined);
  }
}

export async function createComponent(server: Server, state: vscode.Memento): Promise<void> {
  const client = await ready(server);
  if (client === undefined) return;
  const open = (vscode.workspace.workspaceFolders ?? []).filter((it) => it.uri.scheme === 'file');
  let known: InterfaceInfo[];
  try {
    known = await client.sendRequest(interfaces, {});
  } catch (error) {
    void vscode.window.showErrorMessage(error instanceof Error ? error.message : String(error));
    return;
  }
  const asked = questions(open.length, known.length);
  const parent = await askFolder(open, titleOf('folder', asked));
  if (parent === undefined) {
    return;
  }
  const name = await vscode.window.showInputBox({
    title: titleOf('name', asked),
    // Other parts of the window may take the focus, and answers would be lost.
    ignoreFocusOut: true,
    prompt: 'A name in C: letters, digits and _',
    validateInput: (text) => (/^[A-Za-z_]\w*$/.test(text) ? undefined : 'A letter or _, then letters, digits and _'),
  });
  if (name === undefined) {
    return;
  }
  const tasks = await vscode.window.showInputBox({
    title: titleOf('tasks', asked),
    ignoreFocusOut: true,
    prompt: 'Tasks between commas, each with its period unless it has none',
    value: 'exec 10 ms',
  });
  if (tasks === undefined) {
    return;
  }
  const folder = vscode.Uri.joinPath(parent, name);
  try {
    const ports = await askInterfaces(known, titleOf('ports', asked));
    if (ports === undefined) {
      return;
    }
    const chosen = (role: string) => ports.filter((it) => it.role === role).map(({ it }) => ({ name: it.name, uri: it.uri }));
    const made = await client.sendRequest(newComponent, {
      folder: folder.toString(),
      name,
      tasks: parseTasks(tasks),
      provides: chosen('provides'),
      uses: chosen('uses'),
    });
    const edit = new vscode.WorkspaceEdit();
    for (const { uri, text } of made.files) {
      edit.createFile(vscode.Uri.parse(uri), { contents: Buffer.from(text, 'utf8'), overwrite: false });
    }
    if (!(await vscode.workspace.applyEdit(edit))) {
      void vscode.window.showErrorMessage(`The component was not written: a file of it is in ${folder.fsPath} already. Choose another name, or remove that folder.`);
      return;
    }
    const specification = made.files[0]?.uri ?? '';
    if ((vscode.workspace.workspaceFolders ?? []).length === 0) {
      await state.update(OPENED, specification);
      await vscode.commands.executeCommand('vscode.openFolder', folder);
      return;
    }
    await vscode.window.showTextDocument(vscode.Uri.parse(specification));
    // Its step of the walkthrough is done now, and not when the questions begin: done, it takes the focus from them.
    done('component');
  } catch (error) {
    void vscode.window.showErrorMessage(error instanceof Error ? error.message : String(error));
  }
}
