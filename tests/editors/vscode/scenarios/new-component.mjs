// The first five minutes: the walkthrough, a new component by the keyboard, the menu.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = 'maneuver';

export function checks(wb) {
  const { page } = wb;
  const at = (name) => join(wb.folder, name);
  const input = page.locator('.quick-input-widget input.input').first();
  const titled = (text) => page.locator('.quick-input-title', { hasText: text });

  const more = [
    ['the walkthrough leads through it', async () => {
      await wb.open('maneuver.gen');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await wb.command('dotgen: Get Started');
      await page.locator('.gettingStartedContainer', { hasText: 'Make a component' }).waitFor();
      await wb.shot('new-1-walkthrough.png');
    }],
    ['a component is asked for and written', async () => {
      await wb.command('dotgen: New Component');
      await titled('name (1/3)').waitFor();
      await input.fill('nav');
      await page.keyboard.press('Enter');
      await titled('tasks (2/3)').waitFor();
      await input.fill('track 20 ms, plan');
      await page.keyboard.press('Enter');
      await titled('ports (3/3)').waitFor();
      await wb.shot('new-2-ports.png');
      await page.locator('.quick-input-list .monaco-list-row', { hasText: 'uses or_pose_estimator' }).first().click();
      // The click took the focus: a key may go nowhere.
      await page.locator('.quick-input-action a', { hasText: 'OK' }).click();
      await page.locator('.tab.active[data-resource-name="nav.gen"]').first().waitFor();
      await until('its files are there', () => ['nav/nav.gen', 'nav/nav.scn', 'nav/codels/nav_track_codels.c'].every((it) => existsSync(at(it))));
      assert.match(readFileSync(at('nav/nav.gen'), 'utf8'), /uses or_pose_estimator;/);
    }],
    ['it is sound, and its verdict stands over it', async () => {
      // Beside the state machine of its task.
      await page.locator('.codelens-decoration', { hasText: '✓' }).filter({ hasText: 'state machine' }).first().waitFor();
      assert.equal(await wb.squiggles().count(), 0);
      assert.equal(await wb.squiggles('warning').count(), 0);
      await wb.shot('new-3-component.png');
    }],
    ['the status item has a menu', async () => {
      await wb.statusItem.click();
      for (const entry of ['GenoM3', 'New Component', 'Manual', 'Settings', 'Restart Server', 'Server Output']) {
        await page.locator('.quick-input-list .monaco-list-row', { hasText: entry }).first().waitFor();
      }
      await wb.shot('new-4-menu.png');
      await page.locator('.quick-input-list .monaco-list-row', { hasText: 'Manual' }).first().click();
      await titled('Manual of dotgen').waitFor();
      await page.keyboard.press('Enter');
      await page.locator('.tab.active', { hasText: 'Preview' }).waitFor();
      await wb.shot('new-5-manual.png');
    }],
  ];
  return { more };
}
