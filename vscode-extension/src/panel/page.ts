// The page of a panel: no code but our bundle, no style but ours, nothing from elsewhere.
import { randomBytes } from 'node:crypto';
import * as vscode from 'vscode';

export interface PageParts {
  title: string;
  /** Name of the bundle in dist/ and of its style, without extension. */
  script: string;
  body: string;
}

export const ZOOM_BUTTONS =
  '<button id="out" title="Zoom out (-)" aria-label="Zoom out">−</button><button id="in" title="Zoom in (+)" aria-label="Zoom in">+</button><button id="fit" title="Fit (0)">Fit</button>';

export function page(webview: vscode.Webview, extension: vscode.Uri, { title, script, body }: PageParts): string {
  const nonce = randomBytes(16).toString('hex');
  const bundle = webview.asWebviewUri(vscode.Uri.joinPath(extension, 'dist', script));
  return `<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'nonce-${nonce}'; script-src 'nonce-${nonce}'">
<title>${title}</title>
<link rel="stylesheet" nonce="${nonce}" href="${bundle}.css">
</head>
<body>
${body}
<script nonce="${nonce}" src="${bundle}.js"></script>
</body>
</html>`;
}
