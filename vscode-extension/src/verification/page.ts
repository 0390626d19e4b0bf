// The page of the verification panel.
import * as vscode from 'vscode';
import { page as panelPage } from '../panel/page';

const STYLE = `
body { height: auto; min-height: 100vh; }
h1 { font-size: 1.1em; margin: 0; font-weight: 600; }
h2 { font-size: 1em; margin: 14px 0 4px; font-weight: 600; }
main { padding: 4px 12px 16px; }
table { border-collapse: collapse; max-width: 100%; }
th { text-align: left; font-weight: normal; color: var(--vscode-descriptionForeground); }
th, td { padding: 2px 14px 2px 0; vertical-align: top; }
#checks td:first-child, #checks td:last-child:not([colspan]) { white-space: nowrap; }
td, th, li, .run-head h2 { overflow-wrap: anywhere; }
#checks .verdict, td.number, label { overflow-wrap: normal; }
.remedies a { margin-left: 8px; white-space: nowrap; }
#codels td { vertical-align: middle; }
code { font-family: var(--vscode-editor-font-family); }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
/* A background would leave its texts without the contrast that they have on the page. */
tr.shown td:first-child { box-shadow: inset 3px 0 var(--vscode-focusBorder); padding-left: 8px; }
a { color: var(--vscode-textLink-foreground); text-decoration: none; cursor: pointer; }
a:hover { text-decoration: underline; }
a:focus-visible { outline: 1px solid var(--vscode-focusBorder); }
.state { font-weight: 600; border-radius: 3px; padding: 1px 8px; border: 1px solid currentColor; }
.proved { color: color-mix(in srgb, var(--vscode-charts-green) 75%, var(--vscode-editor-foreground)); }
.refuted, .blocked { color: color-mix(in srgb, var(--vscode-editorError-foreground) 85%, var(--vscode-editor-foreground)); }
.gave-up, .nothing, .conditional { color: color-mix(in srgb, var(--vscode-editorWarning-foreground) 55%, var(--vscode-editor-foreground)); }
.stale, .running { color: var(--vscode-descriptionForeground); }
.faint { color: var(--vscode-descriptionForeground); }
.run-head { display: flex; flex-wrap: wrap; gap: 4px 8px; align-items: center; margin-top: 14px; }
.run-head h2 { margin: 0; flex: 1; }
#events { font-family: var(--vscode-editor-font-family); white-space: pre-wrap; overflow-wrap: anywhere; margin: 4px 0; }
#events div { padding-left: 2em; text-indent: -2em; }
details summary { cursor: pointer; margin-top: 14px; font-weight: 600; }
details summary:focus-visible { outline: 1px solid var(--vscode-focusBorder); }
form { display: flex; flex-wrap: wrap; gap: 6px 12px; align-items: center; }
input.wcet { width: 6em; text-align: right; }
input.cores { width: 4em; }
.limits { display: flex; flex-wrap: wrap; gap: 4px 8px; align-items: center; margin: 4px 0; }
progress { width: 10em; accent-color: var(--vscode-progressBar-background); }
ul { margin: 2px 0; padding-left: 1.4em; }
/* Beside an editor of half a window: rows become blocks, and each value says what it is. */
@media (max-width: 520px) {
  table.stacks, table.stacks tr, table.stacks td { display: block; }
  table.stacks tr { display: flex; flex-wrap: wrap; gap: 0 10px; margin-bottom: 4px; }
  table.stacks tr.heads { display: none; }
  table.stacks td { padding-right: 0; }
  table.stacks td:empty { display: none; }
  table.stacks td.what { flex: 1 1 65%; }
  table.stacks td[colspan] { flex: 1 1 100%; }
  table.stacks tr.note { margin-top: -4px; }
  table.stacks tr.shown { box-shadow: inset 3px 0 var(--vscode-focusBorder); padding-left: 8px; }
  table.stacks tr.shown td:first-child { box-shadow: none; padding-left: 0; }
  table.stacks td[data-of]::before { content: attr(data-of) ' '; color: var(--vscode-descriptionForeground); }
}
`;

const BODY = `<header aria-label="Verification">
<h1 id="title">Verification</h1>
<span id="state" class="state running" role="status" aria-live="polite">…</span>
<span id="facts" class="faint"></span>
<span class="gap"></span>
<button id="writeOut" hidden title="Write the scenario to a file, for editing">Write scenario…</button>
</header>
<div id="notice" role="status" aria-live="polite" hidden></div>
<main>
<h2>Checks</h2>
<table id="checks" class="stacks" role="table" aria-label="Checks"></table>
<section id="repairs" class="remedies" hidden><h2>What repairs it</h2><ul></ul></section>
<section id="run" hidden>
<div class="run-head"><h2 id="runTitle"></h2><button id="trace" title="Step through this run, below">Step Through</button><button id="dismiss" title="Close this run" hidden>Dismiss</button></div>
<ul id="reasons"></ul>
<details><summary>The run in words</summary><div id="events"></div></details>
</section>
<details id="variation"><summary>What if</summary>
<form id="whatIf">
<label>Cores <input type="text" class="cores" id="cores" aria-label="Number of cores, or free"></label>
<label>Policy <select id="policy"><option>fifo</option><option>edf</option><option>any</option></select></label>
<label>Durations <select id="durations"><option>interval</option><option>fixed</option><option>open</option></select></label>
<button type="submit">Verify</button><button type="button" id="reset" hidden>As written</button>
</form>
<table id="codels"></table>
</details>
<h2>Limits</h2>
<p class="limits"><button id="findLimits" title="Look for the smallest number of cores, the largest WCET of each codel and the smallest period of each task with which every deadline is met">Find limits</button><button id="stopLimits" hidden>Stop</button>
<progress id="limitsDone" max="100" value="0" aria-label="Progress of the search" hidden></progress>
<span id="limitsText" class="faint" role="status" aria-live="polite"></span></p>
<table id="limits" class="stacks" role="table" aria-label="Limits"></table>
<details id="blocked"><summary>Blocking</summary>
<table id="blocking" class="stacks" role="table" aria-label="Blocking"></table>
</details>
<details id="assumed"><summary>Assumptions</summary>
<ul id="assumptions"></ul>
</details>
</main>`;

export function page(webview: vscode.Webview, extension: vscode.Uri): string {
  return panelPage(webview, extension, { title: 'Verification', script: 'verification', style: STYLE, body: BODY });
}
