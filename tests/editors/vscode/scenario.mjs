// Runs the scenarios in real workbenches, two side by side: `cargo xtask test vscode`, and with --demo the first part of the
// first for `cargo xtask demo --check`. SCENARIO=name runs one of them, also one of bench/.
//
// A scenario is a module in scenarios/: `workspace` (a folder of examples/, or undefined: an empty one), `isEmpty` (the window has no folder), `beside` (others it refers to), `files` (text by name, added to the copy of it),
// `settings` (the folder's), `others` (extensions that stand in for those of others), and `checks(wb)`, which gives pairs of name and function to run in their order, as `more` and
// (proved by the demo as well, run first) `demo`, and as `skipped` the reason why it cannot run here.
//
// CS_NODE, CS_ENTRY: from setup.sh. VSIX: the packaged extension, server inside. EXAMPLES: the folder of the examples.
// SHOTS: where screenshots go.
import { mkdirSync, readdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { openWindow, startBrowser, startServer } from './harness.mjs';

function required(name) {
  const value = process.env[name];
  if (value) return value;
  console.error(`${name} is not set; run this with cargo xtask test`);
  process.exit(2);
}
/** Scenarios that run at a time. A window mostly waits. */
const AT_A_TIME = 2;
const demo = process.argv.includes('--demo');
const only = process.env.SCENARIO;
const shots = resolve(required('SHOTS'));
mkdirSync(shots, { recursive: true });
const started = Date.now();
let passed = 0;
/** Told again at the end: a log of the workbench is long. */
const failures = [];
const skipped = [];

const browser = await startBrowser();
/** The servers, by the extensions of others that they have. */
const servers = new Map();
function serverWith(others = {}) {
  const key = Object.keys(others).join();
  if (!servers.has(key)) servers.set(key, startServer({ node: required('CS_NODE'), codeServer: required('CS_ENTRY'), vsix: required('VSIX'), others }));
  return servers.get(key);
}

async function run(name) {
  let current = 'the workbench starts';
  let wb;
  const begun = Date.now();
  try {
    const scenario = await import(name.startsWith('bench/') ? `./${name}.mjs` : `./scenarios/${name}.mjs`);
    const { workspace, isEmpty, beside = [], files, settings } = scenario;
    const example = (folder) => join(required('EXAMPLES'), folder);
    const server = await serverWith(scenario.others);
    wb = await openWindow({ browser, server, isEmpty, workspace: workspace && example(workspace), beside: beside.map(example), files, settings, shots });
    const { demo: first = [], more = [], skipped: reason } = scenario.checks(wb);
    if (reason) skipped.push(`${name}: ${reason}`);
    const steps = demo ? first : [...first, ...more];
    for (const [title, body] of steps) {
      current = title;
      await body();
      console.log(`${String(Date.now() - started).padStart(6)} ms  ok ${name}: ${title}`);
      passed++;
    }
    console.log(`${name}: ${((Date.now() - begun) / 1000).toFixed(1)} s`);
  } catch (error) {
    const picture = `99-failure-${name.replace('/', '-')}.png`;
    await wb?.shot(picture).catch(() => {});
    console.error(wb?.logs() ?? '');
    failures.push(`${name}: "${current}" failed (screenshot: ${join(shots, picture)})\n${error?.stack ?? error}`);
  } finally {
    await wb?.close().catch((error) => console.error(`${name}: ${error}`));
  }
}

// The longest first, so that both lanes end together.
const LONG = ['codels', 'preview', 'first-steps', 'run', 'verification'];
const all = readdirSync(new URL('scenarios', import.meta.url)).map((name) => name.replace('.mjs', ''));
const rest = all.filter((name) => !LONG.includes(name));
const wanted = demo ? ['first-steps'] : only ? [only] : [...LONG, ...rest];
const lane = async () => {
  for (let name = wanted.shift(); name; name = wanted.shift()) await run(name);
};
await Promise.all(Array.from({ length: AT_A_TIME }, lane));
await browser.close();
for (const server of servers.values()) await (await server.catch(() => undefined))?.close();
for (const failure of failures) console.error(`\n${failure}`);
for (const failure of failures) console.log(`failed: ${failure.split('\n', 2).join(': ').slice(0, 300)}`);
for (const reason of skipped) console.log(`skipped: ${reason}`);
console.log(`${passed} passed, ${failures.length} failed, ${skipped.length} skipped`);
process.exit(failures.length === 0 ? 0 : 1);
