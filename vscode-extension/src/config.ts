// The settings this extension itself reads. All others in section `dotgen` are the server's: it asks for them with
// `workspace/configuration`.
import * as vscode from 'vscode';

export const SECTION = 'dotgen';

export interface ServerSettings {
  path: string;
  extraEnv: Record<string, string>;
  logLevel: string;
}

export function serverSettings(): ServerSettings {
  const settings = vscode.workspace.getConfiguration(SECTION);
  return {
    path: settings.get<string>('server.path', ''),
    extraEnv: settings.get<Record<string, string>>('server.extraEnv', {}),
    logLevel: settings.get<string>('server.logLevel', 'info'),
  };
}

/** Whether a change needs a new server process. */
export function affectsServerProcess(change: vscode.ConfigurationChangeEvent): boolean {
  return change.affectsConfiguration(`${SECTION}.server`);
}

/** Whether `.idl` files of `scope` may be taken for GenoM3 files; an association made by the user wins. */
export function mayAssociateIdl(scope: vscode.Uri): boolean {
  const wanted = vscode.workspace.getConfiguration(SECTION, scope).get<boolean>('files.associateIdl', true);
  const associations = vscode.workspace.getConfiguration('files', scope).get<Record<string, string>>('associations', {});
  return wanted && !Object.keys(associations).some((pattern) => pattern.toLowerCase().endsWith('.idl'));
}
