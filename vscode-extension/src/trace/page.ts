// The page of the trace viewer.
import * as vscode from 'vscode';
import { page as panelPage } from '../panel/page';

const STYLE = `
body { height: 100vh; overflow: hidden; padding: 0; background: var(--vscode-panel-background, var(--vscode-editor-background)); }
header { flex-wrap: nowrap; padding: 4px 10px; min-width: 0; }
header h1 { font-size: 1em; font-weight: 600; margin: 0; overflow: hidden; text-overflow: ellipsis; white-space: nowrap; flex: 1 1 0; min-width: 6em; }
header .group { display: inline-flex; gap: 3px; flex: none; }
header button { min-width: 26px; padding: 2px 6px; }
#position { font-variant-numeric: tabular-nums; white-space: nowrap; color: var(--vscode-descriptionForeground); flex: none; }
#notice { display: flex; gap: 10px; align-items: center; }
#notice span { flex: 1; }
#remedies { display: flex; flex-wrap: wrap; gap: 4px; align-items: center; padding: 3px 10px; }
#remedies[hidden] { display: none; }
#remedies button { overflow-wrap: anywhere; text-align: left; }
#remedies button.previewed { outline: 1px solid var(--vscode-focusBorder); }
#search { width: 7em; }
#found { min-width: 1em; align-self: center; color: var(--vscode-descriptionForeground); font-variant-numeric: tabular-nums; white-space: nowrap; }
#overview { position: static; flex: none; width: 100%; height: 26px; cursor: pointer; border-bottom: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
main { flex: 1; display: flex; min-height: 0; }
#run { flex: 1; display: flex; min-width: 0; min-height: 0; }
#trace { flex: 1; overflow-x: hidden; overflow-y: auto; min-width: 0; position: relative; outline: none; }
#trace:focus-visible { box-shadow: inset 0 0 0 1px var(--vscode-focusBorder); }
#sheet { display: flex; min-height: 100%; }
#names { flex: none; max-width: 34%; margin: 0; padding: 24px 0 0; list-style: none; border-right: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); background: inherit; }
#names li { box-sizing: border-box; display: flex; align-items: center; padding: 0 10px; white-space: nowrap; overflow: hidden; text-overflow: ellipsis; border-bottom: 1px solid var(--vscode-editorIndentGuide-background1, var(--vscode-panel-border, transparent)); }
#names li.current { font-weight: 600; }
#fold { font: inherit; padding: 0; min-width: 0; border: 0; background: none; color: var(--vscode-textLink-foreground); cursor: pointer; }
#names .kind { color: var(--vscode-descriptionForeground); font-weight: normal; margin-left: 6px; }
#plane { flex: 1; min-width: 0; position: relative; }
canvas { position: sticky; top: 0; display: block; touch-action: none; cursor: default; }
canvas.pan { cursor: grabbing; }
#tip { position: fixed; z-index: 2; max-width: 420px; padding: 4px 8px; pointer-events: none; white-space: pre-line; color: var(--vscode-editorHoverWidget-foreground, var(--vscode-editor-foreground)); background: var(--vscode-editorHoverWidget-background, var(--vscode-editor-background)); border: 1px solid var(--vscode-editorHoverWidget-border, var(--vscode-contrastBorder, var(--vscode-focusBorder))); }
aside { flex: 0 0 min(340px, 36%); display: flex; flex-direction: column; min-width: 0; overflow: auto; border-left: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#step, #range { padding: 8px 12px; }
#following { padding: 0 12px 8px; }
#following h3 { font-size: 1em; font-weight: 600; margin: 4px 0; }
#following ol { margin: 0; padding: 0; list-style: none; }
#following ol button { width: 100%; text-align: left; margin: 1px 0; overflow-wrap: anywhere; }
#range { border-bottom: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#range h3, #step h3 { font-size: 1em; font-weight: 600; margin: 6px 0 0; }
#step h2, #range h2 { font-size: 1em; margin: 0 0 2px; font-weight: 600; overflow-wrap: anywhere; }
#step p, #range p { margin: 2px 0; }
#step .what-rule, #range .what-rule { color: var(--vscode-descriptionForeground); }
#step dl, #range dl { display: grid; grid-template-columns: max-content 1fr; gap: 1px 10px; margin: 6px 0 0; }
#step dt, #range dt { color: var(--vscode-descriptionForeground); }
#step dd, #range dd { margin: 0; overflow-wrap: anywhere; }
code { font-family: var(--vscode-editor-font-family); }
#machine { padding: 4px 12px 12px; border-top: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
#machine h2 { font-size: 1em; margin: 4px 0; font-weight: 600; }
#machine svg { display: block; max-width: 100%; height: auto; }
#machine .current .shape { stroke-width: 2.6px !important; stroke: var(--vscode-focusBorder) !important; fill: var(--vscode-editor-selectionHighlightBackground, none) !important; }
footer { display: flex; flex-wrap: wrap; gap: 2px 14px; padding: 3px 10px; font-size: .9em; color: var(--vscode-descriptionForeground); border-top: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); }
footer i { display: inline-block; width: 14px; height: 9px; margin-right: 4px; border: 1px solid currentColor; box-sizing: border-box; }
.l-run { color: var(--vscode-charts-blue); } .l-lock { color: var(--vscode-charts-orange); } .l-core { color: var(--vscode-charts-yellow); } .l-hold { color: var(--vscode-charts-purple); }
.l-run, .l-hold { background: color-mix(in srgb, currentColor 38%, transparent); }
.l-lock { background: repeating-linear-gradient(135deg, currentColor 0 1px, transparent 1px 4px); } .l-core { background: repeating-linear-gradient(135deg, currentColor 0 1px, transparent 1px 2.5px); }
.hidden { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
#empty { padding: 20px; }
#empty p { margin: 0 0 10px; }
@media (max-width: 760px) { header h1 { min-width: 3em; } footer { display: none; } aside { flex-basis: 38%; } #search { width: 4.5em; } }
@media (max-width: 560px) { header { flex-wrap: wrap; } header h1 { flex-basis: 100%; } #run { flex-direction: column; } aside { flex: 0 0 42%; border-left: 0; border-top: 1px solid var(--vscode-panel-border, var(--vscode-contrastBorder, transparent)); } #names { max-width: 42%; } }
@media (max-width: 560px), (max-height: 420px) { #remedies { flex-wrap: nowrap; overflow-x: auto; flex: none; } #remedies button { flex: none; white-space: nowrap; } }
@media (max-width: 560px) and (max-height: 560px) { #machine { display: none; } }
@media (max-width: 560px) and (max-height: 420px) { header h1 { flex-basis: 9em; } #overview { height: 16px; } aside { flex-basis: 64px; } }
`;

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
  return panelPage(webview, extension, { title: 'Trace', script: 'trace', style: STYLE, body: BODY });
}
