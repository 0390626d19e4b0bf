// The page of a panel: no code but our bundle, no style but ours, nothing from elsewhere.
import { randomBytes } from 'node:crypto';
import * as vscode from 'vscode';

export interface PageParts {
  title: string;
  /** Name of the bundle in dist/, without extension. */
  script: string;
  style: string;
  body: string;
}

/** What all panels look like. */
const STYLE = `
body { margin: 0; padding: 0; height: 100vh; display: flex; flex-direction: column; color: var(--vscode-editor-foreground); background: var(--vscode-editor-background); font: var(--vscode-font-size) var(--vscode-font-family); }
header { display: flex; flex-wrap: wrap; gap: 4px 10px; align-items: center; padding: 6px 10px; border-bottom: 1px solid var(--vscode-panel-border, transparent); }
header .gap { flex: 1; }
label { display: inline-flex; gap: 3px; align-items: center; }
button, select, input[type=search], input[type=text], input[type=number] { font: inherit; color: var(--vscode-input-foreground); background: var(--vscode-input-background); border: 1px solid var(--vscode-input-border, var(--vscode-contrastBorder, transparent)); border-radius: 3px; padding: 2px 7px; }
button { color: var(--vscode-button-secondaryForeground); background: var(--vscode-button-secondaryBackground); cursor: pointer; }
button:hover { background: var(--vscode-button-secondaryHoverBackground); }
button:focus-visible, select:focus-visible, input:focus-visible { outline: 1px solid var(--vscode-focusBorder); }
#notice { padding: 5px 10px; color: var(--vscode-inputValidation-warningForeground, inherit); background: var(--vscode-inputValidation-warningBackground); border-bottom: 1px solid var(--vscode-inputValidation-warningBorder); }
#view { overflow: auto; display: grid; min-height: 0; }
#view svg { margin: auto; display: block; }
#view.pan { cursor: grabbing; }
[hidden] { display: none !important; }
`;

export const ZOOM_BUTTONS =
  '<button id="out" title="Zoom out (-)" aria-label="Zoom out">−</button><button id="in" title="Zoom in (+)" aria-label="Zoom in">+</button><button id="fit" title="Fit (0)">Fit</button>';

export function page(webview: vscode.Webview, extension: vscode.Uri, { title, script, style, body }: PageParts): string {
  const nonce = randomBytes(16).toString('hex');
  const bundle = webview.asWebviewUri(vscode.Uri.joinPath(extension, 'dist', `${script}.js`));
  return `<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'nonce-${nonce}'; script-src 'nonce-${nonce}'">
<title>${title}</title>
<style nonce="${nonce}">${STYLE}${style}</style>
</head>
<body>
${body}
<script nonce="${nonce}" src="${bundle}"></script>
</body>
</html>`;
}
