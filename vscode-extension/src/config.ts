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

/** Settings that the extension reads itself. */
const OURS = ['server', 'trace', 'files', 'run', 'diagrams'];

/** The names of the server's settings and tables of settings, without `dotgen.`, from the manifest. */
export function serverSettingNames(manifest: { contributes: { configuration: { properties: Record<string, unknown> } } }): string[] {
  const names = Object.keys(manifest.contributes.configuration.properties).map((it) => it.split('.')[1] ?? '');
  return [...new Set(names)].filter((it) => !OURS.includes(it));
}

const isTable = (it: unknown): it is Record<string, unknown> => typeof it === 'object' && it !== null && !Array.isArray(it);

/** An emptied field is not set. */
const isSet = (it: unknown): boolean => it !== undefined && it !== null && it !== '';

/**
 * What somebody has set in VS Code, for the server. Defaults are left out: they are shown, and must not win over
 * dotgen.toml. Tables are joined, as VS Code does it; the folder wins over the workspace, and that over the user.
 */
export function explicitSettings(names: string[], scope: vscode.Uri | undefined): Record<string, unknown> {
  const settings = vscode.workspace.getConfiguration(SECTION, scope);
  const out: Record<string, unknown> = {};
  for (const name of names) {
    const { globalValue, workspaceValue, workspaceFolderValue } = settings.inspect(name) ?? {};
    for (const value of [globalValue, workspaceValue, workspaceFolderValue].filter(isSet)) {
      const before = out[name];
      out[name] = isTable(value) ? { ...(isTable(before) ? before : {}), ...Object.fromEntries(Object.entries(value).filter(([, it]) => isSet(it))) } : value;
    }
  }
  return out;
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
