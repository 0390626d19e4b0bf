// The page of the trace viewer.
import * as vscode from 'vscode';
import { page as panelPage } from '../panel/page';

const BODY = `<header aria-label="Trace">
<h1 id="title">Trace</h1>
<span id="position"></span>
<span class="group" role="group" aria-label="Steps">
<button id="first" title="First step (Home)" aria-label="First step">|←</button><button id="previous" title="Previous step (←)" aria-label="Previous step">←</button><button id="next" title="Next step (→)" aria-label="Next step">→</button><button id="last" title="Last step (End)" aria-label="Last step">→|</button>
</span>
<span class="group" role="group" aria-label="Time"><button id="out" title="Zoom out (-)" aria-label="Zoom out">−</button><button id="in" title="Zoom in (+)" aria-label="Zoom in">+</button><button id="fit" title="The whole run (0)">All</button><button id="focus" title="Where it fails (F)">Failure</button></span>
<span class="group"><input type="search" id="search" placeholder="Find" title="Find in what happens, codels and lanes (/). Enter: next, Shift+Enter: previous" aria-label="Find in the run"><span id="found" role="status"></span></span>
<span class="group"><button id="go" title="To the codel in the text (Enter)">Codel</button></span>
</header>
<div id="notice" role="status" aria-live="polite" hidden><span></span><button id="refresh">Show the present one</button></div>
<section id="remedies" aria-label="Changes that repair the check" hidden></section>
<canvas id="overview" aria-hidden="true" title="The whole run: a click or a drag shows another part" hidden></canvas>
<main>
<div id="run" hidden>
<div id="trace" tabindex="0" role="application" aria-roledescription="trace" aria-label="Trace. Left and right arrows step through the run, up and down stay in the lane, W and S or plus and minus zoom, A and D pan, M selects what the step is about and sums it, C lists the steps that may follow, slash searches." aria-describedby="told">
<div id="sheet"><ul id="names" aria-label="Lanes"></ul><div id="plane"><canvas id="canvas" aria-hidden="true"></canvas></div></div>
</div>
<aside aria-label="Step" tabindex="0"><section id="range" aria-label="Selected part" aria-live="polite" hidden></section><section id="step" aria-label="What happens"></section><section id="following" aria-label="What may follow" hidden></section><section id="machine" aria-label="State machine" hidden></section></aside>
</div>
<section id="empty" aria-label="Nothing to show"><p id="why">No run is shown. Open one from a verification, or a recorded one.</p><button id="open">Open Recorded Run…</button></section>
</main>
<footer aria-label="Legend"><span><i class="l-run"></i>executes</span><span><i class="l-hold"></i>has its locks</span><span><i class="l-lock"></i>waits for a lock</span><span><i class="l-core"></i>waits for a core</span><span>↑ period begins</span><span>∨ job ends</span><span>▾ request</span><span>✕ too late</span><span>Shift and drag: sums</span></footer>
<div id="told" class="hidden" role="status" aria-live="polite"></div>
<div id="tip" role="tooltip" hidden></div>`;

export function page(webview: vscode.Webview, extension: vscode.Uri): string {
  return panelPage(webview, extension, { title: 'Trace', script: 'trace', body: BODY });
}
