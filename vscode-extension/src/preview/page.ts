// The page of the preview.
import * as vscode from 'vscode';
import { page as panelPage, ZOOM_BUTTONS } from '../panel/page';

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
  return panelPage(webview, extension, { title: 'Diagram', script: 'webview', body: BODY });
}
