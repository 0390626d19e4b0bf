// Runs the scenarios in a real workbench, each in one of its own: `cargo xtask test vscode`, and with --demo the first part of
// the first for `cargo xtask demo --check`. SCENARIO=name runs one of them.
//
// A scenario is a module in scenarios/: `workspace` (a folder of examples/, or undefined: an empty one), `beside` (others it refers to), `files` (text by name, added to the copy of it),
// `settings` (the user's), `others` (extensions that stand in for those of others), and `checks(wb)`, which gives pairs of name and function to run in their order, as `more` and
// (proved by the demo as well, run first) `demo`.
//
// CS_NODE, CS_ENTRY: from setup.sh. VSIX: the packaged extension, server inside. EXAMPLES: the folder of the examples.
// SHOTS: where screenshots go.
import { mkdirSync, readdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { startWorkbench } from './harness.mjs';

function required(name) {
  const value = process.env[name];
  if (value) return value;
  console.error(`${name} is not set; run this with cargo xtask test`);
  process.exit(2);
}
const demo = process.argv.includes('--demo');
const only = process.env.SCENARIO;
const shots = resolve(required('SHOTS'));
mkdirSync(shots, { recursive: true });
const started = Date.now();
let passed = 0;
/** What failed at both tries, told again at the end: a log of the workbench is long. */
const failures = [];
/** Scenarios that passed at the second try. */
const again = [];

/** Runs a scenario; the failure, if there is one. */
async function attempt(name) {
  let current = 'the workbench starts';
  let wb;
  try {
    const scenario = await import(`./scenarios/${name}.mjs`);
    wb = await startWorkbench({
      node: required('CS_NODE'),
      codeServer: required('CS_ENTRY'),
      vsix: required('VSIX'),
      workspace: scenario.workspace && join(required('EXAMPLES'), scenario.workspace),
      beside: (scenario.beside ?? []).map((name) => join(required('EXAMPLES'), name)),
      files: scenario.files,
      settings: scenario.settings,
      others: scenario.others,
      shots,
    });
    const { demo: first = [], more = [] } = scenario.checks(wb);
    const steps = demo ? first : [...first, ...more];
    for (const [title, body] of steps) {
      current = title;
      await body();
      console.log(`${String(Date.now() - started).padStart(6)} ms  ok ${title}`);
    }
    passed += steps.length;
  } catch (error) {
    const picture = `99-failure-${name}.png`;
    await wb?.shot(picture).catch(() => {});
    console.error(wb?.logs() ?? '');
    return `${name}: "${current}" failed (screenshot: ${join(shots, picture)})\n${error?.stack ?? error}`;
  } finally {
    await wb?.close();
  }
}

const all = readdirSync(new URL('scenarios', import.meta.url)).map((name) => name.replace('.mjs', ''));
const wanted = demo ? ['first-steps'] : only ? [only] : ['first-steps', ...all.filter((name) => name !== 'first-steps').sort()];
for (const name of wanted) {
  const first = await attempt(name);
  if (!first) continue;
  // A busy machine loses a key now and then, between the browser and the workbench. What is broken fails twice, in a
  // workbench of its own each time; what failed once is told.
  console.error(`${first}\n\ntrying ${name} once more`);
  const second = await attempt(name);
  if (second) {
    failures.push(second);
  } else {
    again.push(name);
    console.error(`${name} passed at the second try; the first failure was: ${first.split('\n')[0]}`);
  }
}
for (const failure of failures) console.error(`\n${failure}`);
if (again.length > 0) console.log(`at the second try: ${again.join(', ')}`);
console.log(`${passed} passed, ${failures.length} failed`);
process.exitCode = failures.length === 0 ? 0 : 1;
