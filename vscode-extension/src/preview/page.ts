// The page of the preview.
import * as vscode from 'vscode';
import { page as panelPage, ZOOM_BUTTONS } from '../panel/page';

const STYLE = `
input[type=search] { width: 8em; }
#found, .unseen { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
#view { flex: 1; padding: 8px; }
/* What a run writes beside a loop may stand outside. */
#view svg { margin: 0 auto auto; overflow: visible; }
.node { cursor: pointer; }
.current .shape { stroke-width: 2.6px !important; stroke: var(--vscode-focusBorder) !important; fill: var(--vscode-editor-selectionHighlightBackground, none) !important; }
.missed { opacity: .3; }
.hit .shape { stroke-width: 2.6px !important; stroke: var(--vscode-focusBorder) !important; }
.toggle { cursor: pointer; font-size: 12px; }
.part { cursor: pointer; }
.part:hover, .part:focus { text-decoration: underline; outline: none; }
.moving { opacity: .7; cursor: grabbing; }
button[aria-pressed=true] { color: var(--vscode-button-foreground); background: var(--vscode-button-background); outline: 1px solid var(--vscode-contrastActiveBorder, transparent); }
#chainless { display: flex; flex-wrap: wrap; gap: 4px 8px; align-items: center; padding: 4px 10px; border-bottom: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#told { padding: 4px 10px; border-bottom: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#legend { display: flex; flex-wrap: wrap; gap: 2px 16px; padding: 4px 10px; font-size: .9em; color: var(--vscode-descriptionForeground); border-top: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#legend i { display: inline-block; box-sizing: border-box; width: 16px; height: 11px; margin-right: 5px; vertical-align: -1px; border: 1px solid currentColor; border-radius: 2px; }
#legend .disc, #legend .ring { width: 11px; border-radius: 50%; }
#legend .disc { background: currentColor; }
#legend .ring { border-width: 2px; }
#legend .end { border: 3px double currentColor; }
#legend .async { border-style: dashed; }
#legend .missing { border-color: var(--vscode-editorError-foreground); }
#legend .pause { height: 0; border-width: 0 0 2px; border-style: dashed; border-color: var(--vscode-charts-blue, var(--vscode-textLink-foreground)); border-radius: 0; vertical-align: 3px; }
#legend .faint { opacity: .5; }
.here .shape { stroke: var(--vscode-charts-green, currentColor) !important; stroke-width: 2.6px !important; }
.executes .shape { fill: color-mix(in srgb, var(--vscode-charts-green, currentColor) 28%, transparent) !important; }
.never .line, .never .head { opacity: .35; }
.taken { font-size: 11px; font-weight: 600; fill: var(--vscode-charts-green, currentColor); paint-order: stroke; stroke: var(--vscode-editor-background); stroke-width: 4px; stroke-linejoin: round; }
#ran i { border-color: var(--vscode-charts-green, currentColor); border-width: 2px; }
#details { max-height: 35vh; overflow: auto; padding: 8px 12px; border-top: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#details h2 { font-size: 1em; margin: 0 0 4px; }
#details dl { display: grid; grid-template-columns: max-content 1fr; gap: 1px 12px; margin: 0; }
#details dt { color: var(--vscode-descriptionForeground); }
#details dd { margin: 0; font-family: var(--vscode-editor-font-family); white-space: pre-line; }
`;

const BODY = `<header aria-label="Diagram"><h1 class="unseen">Diagram</h1>
<select id="kind" aria-label="Kind of diagram"><option value="fsm">State machine</option><option value="system">System</option><option value="locks">Locks</option></select>
<label class="fsm" title="Worst-case execution times"><input type="checkbox" id="wcet" checked>WCET</label>
<label class="fsm" title="The share of the period that execution takes"><input type="checkbox" id="load" checked>Load</label>
<label class="fsm" title="The longest time from each state to the next pause"><input type="checkbox" id="paths">Paths</label>
<label class="fsm system" title="What excludes each other: codels of a component, or at a port"><input type="checkbox" id="locks">Locks</label>
<label class="system" title="Chains of data that scenarios ask for, with their times" hidden><input type="checkbox" id="chains">Chains</label>
<label class="system" title="Which service interrupts which" hidden><input type="checkbox" id="interrupts">Interrupts</label>
<button class="fsm" id="way" aria-pressed="false" title="Choose states one after the other: how long does the path through them execute? (p, or Shift and click)">Path</button>
<button class="system" id="arrange" title="Everything where it is laid out, as much of it as at first" hidden>Arrange</button>
<input type="search" id="search" placeholder="Find" title="Find (/)" aria-label="Find in the diagram"><span id="found" role="status"></span>
<span class="group">${ZOOM_BUTTONS}</span>
<span class="group"><button id="svg" title="Export as SVG">SVG</button><button id="png" title="Export as PNG">PNG</button></span>
</header>
<div id="notice" role="status" aria-live="polite" hidden></div>
<div id="told" role="status" aria-live="polite" hidden></div>
<div id="chainless" role="status" aria-live="polite" hidden><span>No scenario asks for a chain of data. A check in a scenario does: <code>check reaction sensor.scan -&gt; motor.speed &lt;= 20 ms;</code></span><button id="scenario">Write Scenario…</button><button id="aboutChains">Manual</button></div>
<main id="view" aria-label="Picture"></main>
<footer id="legend" aria-label="Legend"><span><i class="disc"></i>begins</span><span><i class="ring"></i>goes on here when interrupted</span><span><i class="end"></i>ether, the end</span><span><i class="pause"></i>in the next period</span><span><i class="async"></i>async</span><span><i class="missing"></i>no codel</span><span><i class="faint"></i>never reached</span><span>warm colour: share of the period</span><span id="ran" hidden><i></i>a run is here; numbers: how often it went so, and how long it took at most</span></footer>
<section id="details" aria-live="polite" aria-label="Details" hidden></section>`;

export function page(webview: vscode.Webview, extension: vscode.Uri): string {
  return panelPage(webview, extension, { title: 'Diagram', script: 'webview', style: STYLE, body: BODY });
}
