// The page of a run.
import * as vscode from 'vscode';
import { page as panelPage } from '../panel/page';

const STYLE = `
body { height: auto; min-height: 100vh; }
h1 { font-size: 1.1em; margin: 0; font-weight: 600; overflow-wrap: anywhere; }
h2 { font-size: 1em; margin: 16px 0 4px; font-weight: 600; }
main { padding: 0 12px 16px; }
table { border-collapse: collapse; max-width: 100%; }
th { text-align: left; font-weight: normal; color: var(--vscode-descriptionForeground); }
th, td { padding: 2px 14px 2px 0; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
code, #log, .value { font-family: var(--vscode-editor-font-family); }
.state { font-weight: 600; border-radius: 3px; padding: 1px 8px; border: 1px solid currentColor; }
.kept { color: color-mix(in srgb, var(--vscode-charts-green) 75%, var(--vscode-editor-foreground)); }
.violated { color: var(--vscode-editorError-foreground); }
.faint { color: var(--vscode-descriptionForeground); }
.tables { overflow-x: auto; }
form { padding: 6px 0 8px; border-bottom: 1px solid var(--vscode-panel-border, transparent); }
form .name { font-weight: 600; font-family: var(--vscode-editor-font-family); }
form .head { display: flex; flex-wrap: wrap; gap: 2px 12px; align-items: baseline; }
form .doc, form .about, form .unit { color: var(--vscode-descriptionForeground); }
form .fields { display: flex; flex-direction: column; gap: 4px; margin: 4px 0; }
form .fields:empty { display: none; }
form .field { display: flex; flex-wrap: wrap; gap: 2px 8px; align-items: center; }
form .label { min-width: 6em; overflow-wrap: anywhere; }
form .about { flex: 1 1 12em; }
form fieldset { border: 0; border-left: 2px solid var(--vscode-panel-border, currentColor); margin: 0; padding: 2px 0 2px 10px; }
form legend { padding: 0; float: left; width: 100%; }
form fieldset > *, form .elements > * { clear: both; }
form fieldset > .field, form .elements > * { margin-top: 3px; }
form input[type='text'], form input[type='number'] { width: 9em; }
form .foot { display: flex; flex-wrap: wrap; gap: 4px 10px; align-items: center; margin-top: 4px; }
form .more, form .less { margin: 4px 6px 0 0; padding: 0 8px; }
[hidden] { display: none !important; }
.answer { overflow-wrap: anywhere; }
.port { display: flex; flex-wrap: wrap; gap: 2px 12px; align-items: center; padding: 3px 0; }
.port .value { overflow-wrap: anywhere; flex: 1 1 12em; }
.plot { display: inline-flex; gap: 4px; align-items: center; }
.plot svg { width: 120px; height: 26px; overflow: visible; }
.plot polyline { fill: none; stroke: var(--vscode-charts-blue, currentColor); stroke-width: 1.4; vector-effect: non-scaling-stroke; }
#log { white-space: pre-wrap; overflow-wrap: anywhere; max-height: 30vh; overflow-y: auto; margin: 0; }
#log:focus-visible { outline: 1px solid var(--vscode-focusBorder); }
ul { margin: 2px 0; padding-left: 1.4em; }
details summary { cursor: pointer; margin-top: 14px; font-weight: 600; }
details summary:focus-visible { outline: 1px solid var(--vscode-focusBorder); }
`;

const BODY = `<header aria-label="Run">
<h1 id="title">Run</h1>
<span id="state" class="state faint" role="status" aria-live="polite">nothing runs</span>
<span id="facts" class="faint"></span>
<span class="gap"></span>
<button id="stubs" hidden title="Its codels have no functions: show what writes their stubs">Write Stubs</button>
<button id="import" hidden title="Write the execution times of this run into the specification">Import Times</button>
<button id="trace" hidden title="Step through this run, below">Step Through</button>
<button id="again" hidden title="Run it again">Again</button>
<button id="stop" hidden title="End the run, and tell what happened">Stop</button>
</header>
<main>
<section id="violations" hidden><h2>Violations</h2><ul></ul></section>
<section id="tasks" hidden><h2>Tasks</h2><div class="tables"><table></table></div></section>
<section id="checks" hidden><h2>Checks</h2><div class="tables"><table></table></div></section>
<section id="services" hidden><h2>Services</h2><div class="all"></div></section>
<section id="ports" hidden><h2>Ports</h2><div class="all"></div></section>
<section id="requests" hidden><h2>Requests</h2><div class="tables"><table></table></div></section>
<details id="machines" hidden><summary>Transitions</summary><div class="tables"><table></table></div></details>
<section id="told" hidden><h2>Log</h2><pre id="log" tabindex="0" role="log" aria-label="Log"></pre></section>
<details id="assumptions" hidden><summary>What this rests on</summary><ul></ul></details>
</main>`;

export function page(webview: vscode.Webview, extension: vscode.Uri): string {
  return panelPage(webview, extension, { title: 'Run', script: 'run', style: STYLE, body: BODY });
}
