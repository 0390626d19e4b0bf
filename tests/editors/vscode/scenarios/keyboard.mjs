// A first session by keyboard alone, from a window without a folder to a component that is made, repaired, verified and simulated.
import assert from 'node:assert/strict';
import { keyboard } from '../keyboard.mjs';

export const workspace = undefined;
export const isEmpty = true;

/** Keys beside what is typed, and characters typed. */
const MOST_KEYS = 14;
const MOST_TYPED = 13;

export function checks(wb) {
  const { page } = wb;
  const { count, input, press, type, command, actions } = keyboard(wb);
  const titled = (text) => page.locator('.quick-input-title', { hasText: text });
  const lens = (text) => page.locator('.codelens-decoration a', { hasText: text }).first();

  const more = [
    ['a component is made with the answers that are proposed', async () => {
      await page.setViewportSize({ width: 1000, height: 700 });
      await command('new comp', 'dotgen: New Component');
      await titled('folder (1/3)').waitFor();
      // The dialog begins with the home folder, and lists it late.
      await page.locator('.quick-input-list .monaco-list-row', { hasText: '..' }).first().waitFor();
      await wb.shot('keyboard-1-folder.png');
      await press('Enter');
      await titled('name (2/3)').waitFor();
      await type('arm');
      await press('Enter');
      await titled('tasks (3/3)').waitFor();
      await press('Enter');
      await page.locator('.tab.active[data-resource-name="arm.gen"]').waitFor();
      await lens('✓').waitFor();
      await wb.shot('keyboard-2-component.png');
    }],
    ['a slip is repaired by a quick fix', async () => {
      await press('Control+G');
      await input.waitFor();
      await type('23');
      await press('Enter', 'End', 'Backspace');
      await wb.squiggles().first().waitFor();
      await actions();
      await wb.shot('keyboard-3-fix.png');
      await press('Enter');
      await wb.squiggles().first().waitFor({ state: 'detached' });
      await lens('✓').waitFor();
    }],
    ['it is verified and simulated, by a key each', async () => {
      await press('Control+K', 'v');
      await (await wb.pageWith('#checks .proved')).locator('#checks').waitFor();
      await wb.shot('keyboard-4-verified.png');
      await press('Control+F5');
      const run = await wb.pageWith('#tasks tbody tr');
      await run.locator('#state', { hasText: 'simulated' }).waitFor();
      await wb.shot('keyboard-5-simulated.png');
      const { keys, typed } = count;
      const said = `keyboard: ${keys} keys, ${typed} characters`;
      console.log(said);
      assert.ok(keys <= MOST_KEYS && typed <= MOST_TYPED, said);
    }],
  ];
  return { more };
}
