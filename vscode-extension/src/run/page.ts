// The page of a run.
import * as vscode from 'vscode';
import { page as panelPage } from '../panel/page';

const BODY = `<header aria-label="Run">
<h1 id="title">Run</h1>
<span id="state" class="state faint" role="status" aria-live="polite">nothing runs</span>
<span id="facts" class="faint"></span>
<span class="gap"></span>
<input type="search" id="filter" hidden placeholder="Filter" title="Open the services and ports that match (/). Enter goes to the first one, Escape clears the filter." aria-label="Filter services and ports"><span id="found" class="faint" role="status"></span>
<button id="stubs" hidden title="Its codels have no functions: show what writes their stubs">Write Stubs</button>
<button id="import" hidden title="Write the execution times of this run into the specification">Import Times</button>
<button id="trace" hidden title="Step through this run, below">Step Through</button>
<button id="again" hidden title="Run it again">Again</button>
<button id="stop" hidden title="End the run, and tell what happened">Stop</button>
</header>
<main>
<div class="first">
<section id="components" hidden><h2>Components</h2><div class="tables"><table></table></div></section>
<section id="violations" hidden><h2>Violations</h2><div id="violated" tabindex="0" role="region" aria-label="Violations"><ul></ul></div></section>
</div>
<section id="tasks" hidden><h2>Tasks</h2><div class="tables"><table></table></div></section>
<section id="checks" hidden><h2>Checks</h2><div class="tables"><table></table></div></section>
<section id="ports" hidden><h2>Ports</h2><div class="all"></div></section>
<section id="services" hidden><h2>Services</h2><div class="all"></div></section>
<section id="requests" hidden><h2>Requests</h2><div class="tables"><table></table></div></section>
<details id="machines" hidden><summary>Transitions</summary><div class="tables"><table></table></div></details>
<section id="told" hidden><h2>Log</h2><pre id="log" tabindex="0" role="log" aria-label="Log"></pre></section>
<details id="assumptions" hidden><summary>What this rests on</summary><ul></ul></details>
</main>`;

export function page(webview: vscode.Webview, extension: vscode.Uri): string {
  return panelPage(webview, extension, { title: 'Run', script: 'run', body: BODY });
}
