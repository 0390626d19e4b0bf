// The page of the preview.
import * as vscode from 'vscode';
import { page as panelPage, ZOOM_BUTTONS } from '../panel/page';

const STYLE = `
input[type=search] { width: 8em; }
#found { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
#view { flex: 1; padding: 8px; }
#view svg { margin: 0 auto auto; }
.node { cursor: pointer; }
.current .shape { stroke-width: 2.6px !important; stroke: var(--vscode-focusBorder) !important; fill: var(--vscode-editor-selectionHighlightBackground, none) !important; }
.missed { opacity: .3; }
#details { max-height: 35vh; overflow: auto; padding: 8px 12px; border-top: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#details h2 { font-size: 1em; margin: 0 0 4px; }
#details dl { display: grid; grid-template-columns: max-content 1fr; gap: 1px 12px; margin: 0; }
#details dt { color: var(--vscode-descriptionForeground); }
#details dd { margin: 0; font-family: var(--vscode-editor-font-family); white-space: pre-line; }
`;

const BODY = `<header role="toolbar" aria-label="Diagram">
<select id="kind" aria-label="Kind of diagram"><option value="fsm">State machine</option><option value="system">System</option><option value="locks">Locks</option></select>
<label class="fsm" title="Worst-case execution times, and their share of the period"><input type="checkbox" id="wcet" checked>WCET</label>
<label class="fsm" title="The longest time from each state to the next pause"><input type="checkbox" id="paths">Paths</label>
<label class="fsm" title="How many codels each codel excludes"><input type="checkbox" id="locks">Locks</label>
<label class="system" hidden><input type="checkbox" id="interrupts">Interrupts</label>
<input type="search" id="search" placeholder="Find" title="Find (/)" aria-label="Find in the diagram"><span id="found" role="status"></span>
<span class="group">${ZOOM_BUTTONS}</span>
<span class="group"><button id="svg" title="Export as SVG">SVG</button><button id="png" title="Export as PNG">PNG</button></span>
</header>
<div id="notice" role="status" aria-live="polite" hidden></div>
<main id="view" aria-label="Picture"></main>
<section id="details" aria-live="polite" aria-label="Details" hidden></section>`;

export function page(webview: vscode.Webview, extension: vscode.Uri): string {
  return panelPage(webview, extension, { title: 'Diagram', script: 'webview', style: STYLE, body: BODY });
}
