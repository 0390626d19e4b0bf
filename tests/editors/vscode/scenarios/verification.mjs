// Real-time verification: a longer codel misses the deadline, its run shows why, and a shorter one is proved again.
import assert from 'node:assert/strict';
import { until } from '../harness.mjs';

export const workspace = 'pump';
/** Nobody has measured it, and it can go round for ever. */
const GUESS = `component guess {
  version "1.0";
  ids { long x; };
  task spin { period 10 ms; codel<start> f(out x) yield go;
    codel<go> g(out x) yield go, pause::go;
  };
  task slow { period 20 ms; codel<start> h(in x) yield pause::start wcet 3 ms; };
};
`;
/** A lamp, and a mixer of which not everything can be found out. */
const EIGHT = [0, 1, 2, 3, 4, 5, 6, 7];
const LAMP = `component lamp {
  ids { long light; };
  task blink { period 8 ms; codel<start> toggle(inout light) yield pause::start wcet 1 ms; };
};
component mixer {
  ids { long level; };
  task u { period 7 ms; codel<start> w(inout level) yield pause::start wcet 1301 us; };
${EIGHT.map((i) => `  activity a${i}() { task u; codel<start> s${i}(inout level) yield pause::start, ether wcet ${1000 + 7 * i} us; };`).join('\n')}
};
`;
const BOTH = `scenario both {
  use "lamp.gen";
  client any { repeat * { delay [0,*] ms; choice ${EIGHT.map((i) => `{ send mixer.a${i}; }`).join(' or ')} } }
  check response lamp.blink;
  check wrong: always not lamp.blink;
  check limit: within mixer.a0.run => mixer.a0.void <= 1 s;
}
`;
export const files = {
  'lamp.gen': LAMP,
  'both.scn': BOTH,
  'guess.gen': GUESS,
  'guess.scn': 'scenario guess {\n  use "guess.gen";\n  check schedulable guess.slow;\n  check response guess.spin;\n}\n',
};

export function checks(wb) {
  const { page } = wb;
  const lens = (what) => page.locator('.contentWidgets .codelens-decoration a', { hasText: what }).first();
  // The trace viewer is another one, which is hidden when it is not needed.
  const frame = page.frameLocator('iframe.webview.ready:visible').first().frameLocator('iframe#active-frame');
  const state = (word) => frame.locator('#state', { hasText: word });

  /** Hides the trace viewer, which is below the text. */
  async function hideRun() {
    await page.locator('.part.panel').waitFor();
    await wb.command('View: Toggle Panel Visibility');
    await page.locator('.part.panel').waitFor({ state: 'hidden' });
  }

  /** Sets the execution time at the end of a line. */
  async function wcet(before, after) {
    await wb.endOf('pump.gen', 'yield pause::start wcet');
    for (let i = 0; i < `${before} ms;`.length; i++) await page.keyboard.press('Backspace');
    await wb.type(`${after} ms;`);
  }

  const more = [
    ['a scenario has colours, and its verdicts over its checks', async () => {
      await wb.open('pump.scn');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await lens('8 ms · proved').waitFor();
      await lens('33.5 ms · proved').waitFor();
      const colours = new Set(await page.locator('.monaco-editor .view-lines .view-line span span').evaluateAll((all) => all.map((it) => it.className)));
      assert.ok(colours.size > 4, [...colours].join(' '));
      await wb.shot('60-scenario.png');
    }],
    ['hovers and completion know the names of the specification', async () => {
      await wb.hover('check control', 'control');
      await page.keyboard.press('Escape');
      await wb.endOf('pump.scn', 'cores 1;');
      await wb.type('\nslots pu');
      await wb.press('Control+Space', page.locator('.suggest-widget .monaco-list-row', { hasText: 'pump.fill' }).first());
      await wb.shot('61-scenario-completion.png');
      await page.keyboard.press('Escape');
      await lens('not verified: there are errors').waitFor();
      for (let i = 0; i < '\n  slots pu'.length; i++) await page.keyboard.press('Control+Z');
      await lens('8 ms · proved').waitFor();
      await wb.save();
    }],
    ['a task has its response time over it', async () => {
      await wb.open('pump.gen');
      await lens('✓ 8 of 9 ms').waitFor();
      await wb.shot('62-lens.png');
    }],
    ['a longer codel misses the deadline', async () => {
      await wcet(4, 6);
      await wb.squiggles('warning').first().waitFor();
      await lens('✗ can be late').waitFor();
      await wb.command('Problems: Focus on Problems View');
      await page.locator('.markers-panel .monaco-list-row', { hasText: 'can miss its deadline' }).first().waitFor();
      await wb.shot('63-deadline-miss.png');
      await page.keyboard.press('Control+J');
    }],
    ['a click on the verdict opens the run at its failure', async () => {
      await wb.click(lens('✗ can be late'), page.locator('.part.panel'));
      let trace;
      await until('the viewer is there', async () => {
        for (const it of page.frames()) if ((await it.locator('#sheet canvas').count().catch(() => 0)) > 0) trace = it;
        return trace !== undefined;
      });
      await trace.locator('#position', { hasText: /step (\d+) of \1$/ }).waitFor();
      await wb.shot('64-run-dark.png');
      await hideRun();
    }],
    ['the panel has the run in words, which leads to its codels', async () => {
      await wb.open('pump.gen');
      await wb.command('dotgen: Show Verification');
      await state('refuted').waitFor();
      const policy = await frame.locator('meta[http-equiv="Content-Security-Policy"]').getAttribute('content');
      assert.match(policy, /^default-src 'none'; img-src data:; style-src 'nonce-\w+'; script-src 'nonce-\w+'$/);
      await frame.locator('#run summary').click();
      await frame.locator('#events a', { hasText: 'pump.report.start begins' }).last().click();
      await page.locator('.monaco-editor .line-numbers.active-line-number', { hasText: /^25$/ }).waitFor();
      await wb.shot('64-panel-dark.png');
    }],
    ['what would be enough: a variation, and back', async () => {
      await frame.locator('#variation summary').click();
      await frame.locator('#cores').fill('2');
      await frame.locator('#cores').press('Enter');
      await frame.locator('#notice', { hasText: 'a variation' }).waitFor();
      await frame.locator('#facts', { hasText: '2 cores' }).waitFor();
      await frame.locator('input[data-codel="pump.report.start"]').fill('3000');
      await frame.locator('input[data-codel="pump.report.start"]').press('Enter');
      await state('proved').waitFor();
      await wb.shot('65-what-if.png');
      await frame.locator('#reset').click();
      await state('refuted').waitFor();
    }],
    ['three themes, for eyes and for screen readers', () => wb.accessible('#checks', '65-panel')],
    ['light', async () => {
      wb.folderSettings({ 'workbench.colorTheme': 'Default Light Modern' });
      await page.locator('.monaco-workbench.vs').waitFor();
      await wb.shot('66-panel-light.png');
      await frame.locator('#blocked summary').click();
      await frame.locator('#blocking').scrollIntoViewIfNeeded();
      await wb.shot('67-blocking-light.png');
      wb.folderSettings({});
    }],
    ['shorter again, it is proved; the run stays until it is dismissed', async () => {
      await frame.locator('#checks a', { hasText: 'show why' }).first().click();
      await hideRun();
      await frame.locator('#checks tr.shown').first().waitFor();
      await page.locator('.monaco-editor .view-line', { hasText: 'task report' }).first().click();
      await wcet(6, 4);
      await state('proved').waitFor();
      await page.locator('.monaco-editor .squiggly-warning').first().waitFor({ state: 'detached' });
      await frame.locator('#runTitle', { hasText: 'of an earlier text' }).waitFor();
      await lens('✓ 8 of 9 ms').waitFor();
      await wb.shot('68-proved-again.png');
      await frame.locator('#dismiss').click();
      await frame.locator('#runTitle', { hasText: 'of an earlier text' }).waitFor({ state: 'detached' });
    }],
    ['the limits are looked for on demand, and forgotten when the text changes', async () => {
      const limit = (of) => frame.locator('#limits tr', { hasText: of });
      await frame.locator('#findLimits').click();
      await limit('smallest number of cores').waitFor();
      assert.match(await limit('largest WCET').filter({ hasText: 'pump.control.main' }).textContent(), /ms/);
      assert.match(await limit('smallest period').filter({ hasText: 'pump.control' }).textContent(), /8\.1 ms/);
      assert.ok(await frame.locator('#stopLimits').isHidden());
      await limit('pump.control.main').locator('a').click();
      await page.locator('.monaco-editor .line-numbers.active-line-number', { hasText: /^18$/ }).waitFor();
      await frame.locator('#limits').scrollIntoViewIfNeeded();
      await wb.shot('69-limits.png');
      wb.folderSettings({ 'workbench.colorTheme': 'Default High Contrast' });
      await page.locator('.monaco-workbench.hc-black').waitFor();
      await wb.shot('69-limits-high-contrast.png');
      wb.folderSettings({});
      await wcet(4, 5);
      await limit('smallest number of cores').waitFor({ state: 'detached' });
      await wcet(5, 4);
      await state('proved').waitFor();
    }],
    ['what was given up names the setting to raise', async () => {
      wb.folderSettings({ 'dotgen.verification': { 'max-states': 30 } });
      await state('gave up').waitFor();
      await frame.locator('#notice', { hasText: 'raise verification.max-states in the settings' }).waitFor();
      await wb.open('pump.scn');
      await lens('gave up at').waitFor();
      await frame.locator('#title').scrollIntoViewIfNeeded();
      await wb.shot('69-gave-up.png');
      wb.folderSettings({});
      await state('proved').waitFor();
      await frame.locator('#notice').waitFor({ state: 'hidden' });
    }],
    ['what is assumed of the model leads to it', async () => {
      await wb.open('guess.scn');
      await wb.squiggles('warning').first().waitFor();
      await wb.command('dotgen: Show Verification');
      const assumed = frame.locator('#assumptions a');
      await frame.locator('#assumed summary').click();
      await assumed.filter({ hasText: 'have no wcet' }).waitFor();
      await frame.locator('#assumptions').scrollIntoViewIfNeeded();
      await wb.shot('69-assumed.png');
      await assumed.filter({ hasText: 'have no wcet' }).click();
      await page.locator('.tab.active', { hasText: 'guess.gen' }).waitFor();
      await page.locator('.monaco-editor .line-numbers.active-line-number', { hasText: /^4$/ }).waitFor();
    }],
    ['answers are shown as they are found', async () => {
      wb.folderSettings({ 'dotgen.verification': { 'time-limit': 3600, 'max-states': 4000000000 } });
      await wb.open('both.scn');
      await lens('verifying … · 2 of 3 checks answered').waitFor();
      await lens('1 ms · proved').waitFor();
      await wb.squiggles('warning').first().waitFor();
      await wb.command('dotgen: Show Verification');
      await state('verifying').waitFor();
      await frame.locator('#facts', { hasText: '2 of 3 checks answered' }).waitFor();
      await frame.locator('#checks tr', { hasText: 'limit' }).locator('.running', { hasText: 'verifying' }).waitFor();
      await frame.locator('#runTitle', { hasText: 'a run that refutes it' }).waitFor();
      await wb.shot('69-partly.png');
    }],
    ['the rest comes without a change of what is looked at', async () => {
      const why = frame.locator('#checks a', { hasText: 'show why' });
      await why.focus();
      await page.keyboard.press('Enter');
      await hideRun();
      // The element itself stays, and with it focus and selection.
      await why.evaluate((it) => { it.marked = true; });
      await page.locator('.monaco-editor .view-line', { hasText: 'check limit' }).first().click();
      await page.keyboard.press('End');
      await page.keyboard.press('Shift+Home');
      await page.keyboard.press('Delete');
      await state('refuted').waitFor();
      await frame.locator('#facts', { hasText: 'states' }).waitFor();
      await lens('refuted ·').waitFor();
      assert.ok(await why.evaluate((it) => it.marked));
      await wb.shot('69-whole.png');
      wb.folderSettings({});
    }],
  ];
  return { more };
}
