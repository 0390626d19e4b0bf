// The trace viewer: a missed deadline step by step, in the text and in the state machine, in three themes and at half width; a
// recorded run from a file.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { until } from '../harness.mjs';
import { trace } from '../webview/traces.mjs';

export const workspace = 'pump';
const recorded = trace(10_000);
export const files = { 'run.trace.json': JSON.stringify({ ...recorded, title: 'a recorded run' }), 'other.json': '{}' };
export const settings = { 'files.simpleDialog.enable': true };

export function checks(wb) {
  const { page } = wb;
  /** The page of the viewer, among those of other panels. */
  const viewer = () => wb.pageWith('#sheet canvas');
  const position = async () => (await viewer()).locator('#position');
  let steps;

  const more = [
    ['a missed deadline is stepped through, below the text', async () => {
      await wb.open('pump.gen');
      await page.locator('.contentWidgets .codelens-decoration a', { hasText: '✓ 8 of 9 ms' }).first().waitFor();
      await wb.endOf('pump.gen', 'yield pause::start wcet');
      for (let i = 0; i < '4 ms;'.length; i++) await page.keyboard.press('Backspace');
      await wb.type('6 ms;');
      await page.locator('.contentWidgets .codelens-decoration a', { hasText: '✗ can be late' }).first().waitFor();
      await wb.command('dotgen: Step Through Run');
      const frame = await viewer();
      await frame.locator('#position', { hasText: /step \d+ of \d+/ }).waitFor();
      const [, at, of] = /step (\d+) of (\d+)/.exec(await (await position()).textContent());
      assert.equal(at, of, 'it opens at the failure');
      steps = Number(of);
      await frame.locator('#title', { hasText: 'a run that refutes it' }).waitFor();
    }],
    ['each step marks its codel in the text and its state in the machine', async () => {
      const frame = await viewer();
      await frame.locator('#trace').focus();
      const what = frame.locator('#step');
      for (let i = 0; i < steps && !(await what.textContent()).includes('pump.report.start begins'); i++) await page.keyboard.press('ArrowLeft');
      await what.filter({ hasText: 'pump.report.start begins' }).waitFor();
      await what.filter({ hasText: 'The codel takes its locks and executes.' }).waitFor();
      await frame.locator('#machine .current', { hasText: 'start' }).waitFor();
      await wb.shot('80-trace-dark.png');
      const policy = await frame.locator('meta[http-equiv="Content-Security-Policy"]').getAttribute('content');
      assert.match(policy, /^default-src 'none'; img-src data:; style-src 'nonce-\w+'; script-src 'nonce-\w+'$/);
      await page.keyboard.press('Enter');
      await page.locator('.monaco-editor .line-numbers.active-line-number', { hasText: /^25$/ }).waitFor();
    }],
    ['another step that the rules allow is taken, and the run goes on from there', async () => {
      const frame = await viewer();
      await frame.locator('#trace').focus();
      await page.keyboard.press('Home');
      await page.keyboard.press('c');
      const choices = frame.locator('#following ol button');
      await choices.first().waitFor();
      assert.match(await frame.locator('#position').textContent(), /step 1 of/, 'the whole run is still there');
      await page.keyboard.press('Enter');
      await frame.locator('#title', { hasText: 'with chosen steps' }).waitFor();
      const first = Number(/of (\d+)/.exec(await frame.locator('#position').textContent())[1]);
      assert.ok(first < steps);
      // The choices of the new end are there at once, and the keyboard is among them.
      for (let i = 0; i < 8; i++) {
        await frame.locator('#following ol button:focus').waitFor();
        const before = await frame.locator('#following').textContent();
        await page.keyboard.press('Enter');
        await until('the next choices', async () => (await frame.locator('#following').textContent()) !== before || (await frame.locator('#following ol button').count()) === 0);
      }
      await wb.shot('80-trace-chosen.png');
      // Back at an earlier step, its own choices are listed again.
      await frame.locator('#trace').focus();
      await page.keyboard.press('Home');
      await frame.locator('#following button', { hasText: 'Choose the next step' }).click();
      await choices.first().waitFor();
      await wb.command('dotgen: Step Through Run');
      await frame.locator('#title', { hasText: 'a run that refutes it' }).waitFor();
    }],
    ['three themes, for eyes and for screen readers; half width', async () => {
      await wb.accessible('#sheet canvas', '80-trace');
      await page.setViewportSize({ width: 700, height: 900 });
      await wb.shot('80-trace-half.png');
      await page.setViewportSize({ width: 1400, height: 900 });
    }],
    ['a text that changes makes the run one of an earlier text', async () => {
      await wb.endOf('pump.gen', 'yield pause::start wcet');
      await wb.type(' ');
      const frame = await viewer();
      await frame.locator('#notice', { hasText: 'of an earlier one' }).waitFor();
      await page.keyboard.press('Backspace');
      await page.locator('.contentWidgets .codelens-decoration a', { hasText: '✗ can be late' }).first().waitFor({ state: 'attached' });
      await frame.locator('#refresh').click();
      await frame.locator('#notice').waitFor({ state: 'hidden' });
    }],
    ['a recorded run of 10,000 steps opens from its file', async () => {
      const open = async (name) => {
        await wb.command('dotgen: Open Recorded Run');
        await wb.choose(join(wb.folder, name));
      };
      await open('other.json');
      await page.locator('.notification-toast', { hasText: 'It is no trace' }).waitFor();
      await open('run.trace.json');
      const frame = await viewer();
      await frame.locator('#title', { hasText: 'a recorded run' }).waitFor();
      await frame.locator('#position', { hasText: `of ${recorded.steps.length}` }).waitFor();
      await wb.shot('81-recorded.png');
    }],
  ];
  return { more };
}
