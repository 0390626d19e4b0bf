// The manual that the extension carries, shown as Markdown is.
import * as vscode from 'vscode';

const PAGES = ['features.md', 'diagnostics/README.md', 'verification.md', 'drift.md', 'configuration.md', 'diagrams.md', 'templates.md', 'formatting.md', 'releases.md', 'language.md'];

/** The folder of the pages. */
function folder(extension: vscode.Uri): vscode.Uri {
  return vscode.Uri.joinPath(extension, 'docs');
}

/** Lets a page of the manual be chosen, and shows it. */
export async function openManual(extension: vscode.Uri): Promise<void> {
  const found: { label: string; description: string; uri: vscode.Uri }[] = [];
  for (const page of PAGES) {
    const uri = vscode.Uri.joinPath(folder(extension), page);
    const text = await vscode.workspace.fs.readFile(uri).then((it) => Buffer.from(it).toString('utf8'), () => undefined);
    const title = text === undefined ? undefined : /^# (.+)$/m.exec(text)?.[1];
    if (title !== undefined) {
      found.push({ label: title, description: page, uri });
    }
  }
  const picked = await vscode.window.showQuickPick(found, { title: 'Manual of dotgen', matchOnDescription: true });
  if (picked !== undefined) {
    await vscode.commands.executeCommand('markdown.showPreview', picked.uri);
  }
}

/** A link to a page of the manual shows it as Markdown is shown, not as text. */
export function previewed(target: vscode.Uri, extension: vscode.Uri): vscode.Uri {
  const isOurs = target.scheme === 'file' && target.path.startsWith(`${folder(extension).path}/`);
  return isOurs ? vscode.Uri.parse(`command:markdown.showPreview?${encodeURIComponent(JSON.stringify([target]))}`) : target;
}
