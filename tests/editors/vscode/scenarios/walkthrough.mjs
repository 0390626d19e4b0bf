// The marks of the walkthrough: each step gets its mark when what it says has happened, and not before.
import assert from 'node:assert/strict';

export const workspace = 'maneuver';

const STEPS = ['component', 'machine', 'repair', 'stubs', 'verify', 'simulate'];

export function checks(wb) {
  const { page } = wb;
  const input = page.locator('.quick-input-widget input.input').first();
  const titled = (text) => page.locator('.quick-input-title', { hasText: text });
  const mark = (step, isDone) => page.locator(`.getting-started-step[data-step-id$="#${step}"] .codicon-getting-started-step-${isDone ? 'checked' : 'unchecked'}`).first();
  const done = new Set();

  /** Shows the walkthrough: the steps in `done` have a mark, the others have none. */
  async function marks() {
    await wb.command('dotgen: Get Started');
    for (const step of STEPS) await mark(step, done.has(step)).waitFor();
  }

  const more = [
    ['no step has a mark before anything is done', async () => {
      await page.setViewportSize({ width: 1000, height: 700 });
      await wb.open('maneuver.gen');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await marks();
      await wb.shot('walkthrough-1-nothing.png');
    }],
    ['an error is no repair; its repair is', async () => {
      await wb.open('maneuver.gen');
      await wb.endOf('maneuver.gen', 'yield ether wcet 4 us');
      await page.keyboard.type(' oops');
      await wb.squiggles().first().waitFor();
      await marks();
      await wb.open('maneuver.gen');
      await wb.endOf('maneuver.gen', 'yield ether wcet 4 us');
      for (let i = 0; i < ' oops'.length; i++) await page.keyboard.press('Backspace');
      await wb.squiggles().first().waitFor({ state: 'detached' });
      await wb.save();
      done.add('repair');
      await marks();
    }],
    ['a state machine that is shown', async () => {
      await wb.open('maneuver.gen');
      await wb.endOf('maneuver.gen', 'task exec');
      await wb.command('dotgen: Show State Machine');
      await wb.pageWith('g.node');
      await wb.command('View: Close Editors in Other Groups');
      done.add('machine');
      await marks();
    }],
    ['a verification that is answered', async () => {
      await wb.open('maneuver.gen');
      await wb.command('dotgen: Show Verification');
      await (await wb.pageWith('#checks')).locator('#state', { hasText: /proved|refuted|gave up/ }).waitFor();
      await wb.command('View: Close Editors in Other Groups');
      done.add('verify');
      await marks();
      await wb.shot('walkthrough-2-half.png');
    }],
    ['a component that is begun has no mark; one that is written has', async () => {
      await wb.command('dotgen: New Component');
      await titled('name (1/3)').waitFor();
      await input.fill('nav');
      await page.keyboard.press('Escape');
      await input.waitFor({ state: 'hidden' });
      await marks();
      await wb.command('dotgen: New Component');
      await titled('name (1/3)').waitFor();
      for (const [value, next] of [['nav', 'tasks (2/3)'], ['track 20 ms', 'ports (3/3)']]) {
        await input.fill(value);
        await page.keyboard.press('Enter');
        await titled(next).waitFor();
      }
      await page.locator('.quick-input-action a', { hasText: 'OK' }).click();
      await page.locator('.tab.active[data-resource-name="nav.gen"]').first().waitFor();
      done.add('component');
      await marks();
    }],
    ['a simulation with a result; what nobody did has no mark', async () => {
      await wb.open('nav.gen');
      await wb.command('dotgen: Simulate');
      await (await wb.pageWith('#tasks tbody tr')).locator('#again').waitFor();
      done.add('simulate');
      await marks();
      assert.deepEqual(STEPS.filter((it) => !done.has(it)), ['stubs']);
      await wb.shot('walkthrough-3-done.png');
    }],
  ];
  return { more };
}
