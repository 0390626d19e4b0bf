// A window without a folder: a component is made where the user says, and its folder is opened.
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = undefined;
export const isEmpty = true;

export function checks(wb) {
  const { page } = wb;
  const input = page.locator('.quick-input-widget input.input').first();
  const titled = (text) => page.locator('.quick-input-title', { hasText: text });

  const more = [
    ['a component is asked for, with its folder', async () => {
      await wb.command('dotgen: New Component');
      await titled('folder (1/3)').waitFor();
      await wb.shot('no-folder-1-where.png');
      const listed = (name) => page.locator('.quick-input-list .monaco-list-row', { hasText: name }).first();
      // The dialog begins with the home folder, and lists it late.
      await listed('..').waitFor();
      await input.fill(`${wb.folder}/`);
      await listed('.vscode').waitFor();
      await page.locator('.quick-input-action a', { hasText: 'OK' }).click();
      await titled('name (2/3)').waitFor();
      await input.fill('nav');
      await page.keyboard.press('Enter');
      await titled('tasks (3/3)').waitFor();
      await page.keyboard.press('Enter');
      await until('its files are there', () => ['nav/nav.gen', 'nav/nav.scn'].every((it) => existsSync(join(wb.folder, it))));
    }],
    ['its folder is opened, and it is shown', async () => {
      await page.locator('.explorer-folders-view .monaco-list-row', { hasText: 'nav.gen' }).waitFor();
      await page.locator('.tab.active[data-resource-name="nav.gen"]').waitFor();
      await page.locator('.codelens-decoration a', { hasText: '✓' }).first().waitFor();
      await wb.shot('no-folder-2-opened.png');
    }],
  ];
  return { more };
}
