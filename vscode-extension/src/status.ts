// The status bar item: what the server is doing, and which server it is.
import * as vscode from 'vscode';
import type { Server } from './client';
import { LANGUAGE, SCENARIO } from './protocol';

export function statusItem(server: Server): vscode.Disposable {
  const item = vscode.window.createStatusBarItem('dotgen.status', vscode.StatusBarAlignment.Left);
  item.name = 'dotgen';
  item.command = 'dotgen.showMenu';
  const update = () => {
    const state = server.current;
    item.text = { stopped: '$(circle-slash)', starting: '$(loading~spin)', ready: '$(check)', busy: '$(sync~spin)', failed: '$(error)' }[state.kind] + ' dotgen';
    item.backgroundColor = state.kind === 'failed' ? new vscode.ThemeColor('statusBarItem.errorBackground') : undefined;
    item.tooltip = tooltip(server);
    // Out of the way unless it concerns what is on screen; a failure always does.
    const editor = vscode.window.activeTextEditor;
    if (state.kind === 'failed' || [LANGUAGE, SCENARIO].includes(editor?.document.languageId ?? '') || editor?.document.fileName.endsWith('dotgen.toml')) {
      item.show();
    } else {
      item.hide();
    }
  };
  update();
  return vscode.Disposable.from(
    item,
    server.onDidChange(update),
    vscode.window.onDidChangeActiveTextEditor(update),
    // A change of language shows as an open.
    vscode.workspace.onDidOpenTextDocument(update),
    vscode.workspace.onDidChangeWorkspaceFolders(update),
  );
}

function tooltip(server: Server): vscode.MarkdownString {
  const state = server.current;
  const text = new vscode.MarkdownString('', true);
  text.isTrusted = {
    enabledCommands: ['dotgen.restartServer', 'dotgen.showOutput', 'dotgen.showLogs', 'workbench.action.openSettings', 'workbench.trust.manage'],
  };
  const headline = {
    stopped: 'dotgen is stopped',
    starting: 'dotgen is starting',
    ready: 'dotgen is ready',
    busy: `dotgen is busy: ${state.kind === 'busy' ? state.activity : ''}`,
    failed: 'dotgen does not work',
  }[state.kind];
  text.appendMarkdown(`**${headline}**\n\n`);
  if (state.kind === 'failed') {
    text.appendText(state.reason).appendMarkdown('\n\n');
  }
  const info = server.info;
  if (info !== undefined) {
    const origin = { setting: 'from the setting dotgen.server.path', package: 'packaged with the extension', PATH: 'found on PATH' }[info.origin];
    text.appendMarkdown(`Server: ${info.name} ${info.version}, ${origin ?? ''}\n\n`);
    text.appendCodeblock(info.path, 'text');
  }
  const folders = vscode.workspace.workspaceFolders ?? [];
  text.appendMarkdown(folders.length === 0 ? 'No folder is open: each file is looked at on its own.\n\n' : 'Workspace:\n\n');
  for (const folder of folders) {
    text.appendCodeblock(folder.uri.scheme === 'file' ? folder.uri.fsPath : folder.uri.toString(), 'text');
  }
  if (!vscode.workspace.isTrusted) {
    text.appendMarkdown('$(shield) Restricted: pkg-config, templates and components are not run. [Manage trust](command:workbench.trust.manage)\n\n');
  }
  const settings = encodeURIComponent(JSON.stringify(['dotgen']));
  text.appendMarkdown(
    `[Restart](command:dotgen.restartServer) · [Output](command:dotgen.showOutput) · [Log](command:dotgen.showLogs) · [Settings](command:workbench.action.openSettings?${settings})`,
  );
  return text;
}
