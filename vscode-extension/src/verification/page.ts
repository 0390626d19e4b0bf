// The page of the verification panel.
import * as vscode from 'vscode';
import { page as panelPage } from '../panel/page';

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
  return panelPage(webview, extension, { title: 'Verification', script: 'verification', body: BODY });
}
