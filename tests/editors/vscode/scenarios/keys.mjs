// A first session with the keyboard alone: from an empty folder to a component with stubs that is broken, repaired, proved and simulated,
// with at most 120 presses, and without an error that the session did not make.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';
import { keyboard } from '../keyboard.mjs';

export const workspace = undefined;

const MOST_PRESSES = 120;

export function checks(wb) {
  const { page } = wb;
  const { count, press, pressUntil, type, command, actions } = keyboard(wb);
  const titled = (text) => page.locator('.quick-input-title', { hasText: text });
  const lens = (text) => page.locator('.contentWidgets .codelens-decoration a', { hasText: text }).first();
  const errors = wb.squiggles();
  const marker = page.locator('.marker-widget, .monaco-editor .zone-widget');
  const text = (name) => readFileSync(join(wb.folder, name), 'utf8');

  const more = [
    ['a component from nothing', async () => {
      await command('new comp', 'dotgen: New Component');
      await titled('name (1/').waitFor();
      await type('arm\n');
      await titled('tasks (2/').waitFor();
      await type('\n');
      await page.locator('.tab.active[data-resource-name="arm.gen"]').first().waitFor();
      await lens('✓').waitFor();
      assert.equal(await errors.count() + (await wb.squiggles('warning').count()), 0);
      await wb.shot('keys-1-component.png');
    }],
    ['a function with a slip: one error, which names what was meant', async () => {
      await press('Control+End', 'ArrowUp', 'ArrowUp', 'End');
      await type('\nfunction go(in long speed) { codel arm_go(in sped); };');
      // The error of the whole line: while it is typed, there are others, each a character wide.
      const wide = () => [...document.querySelectorAll('.squiggly-error')].some((it) => it.getBoundingClientRect().width > 54);
      await page.waitForFunction(wide);
      await pressUntil('F8', async () => {}, marker.filter({ hasText: 'did you mean `speed`?' }).first());
      await wb.shot('keys-2-broken.png');
    }],
    ['the first fix repairs it', async () => {
      await actions('speed');
      await press('Enter');
      await errors.first().waitFor({ state: 'detached' });
      await press('Control+S');
      await until('it is written', () => /codel arm_go\(in speed\)/.test(text('arm/arm.gen')), () => text('arm/arm.gen'));
    }],
    ['it is proved, and simulated', async () => {
      await lens('✓').waitFor();
      await command('simulate', 'dotgen: Simulate');
      const frame = await wb.pageWith('#tasks');
      await frame.locator('#state', { hasText: 'simulated' }).waitFor();
      await wb.shot('keys-5-simulated.png');
      const presses = count.keys + count.typed;
      console.log(`    ${presses} presses`);
      assert.ok(presses <= MOST_PRESSES, `${presses} presses`);
    }],
  ];
  return { more };
}
