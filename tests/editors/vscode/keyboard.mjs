// A user without a mouse, whose keys are counted.
import { LOST_MS } from './harness.mjs';

/** Presses keys, types text and runs commands in a window; counts the keys pressed and the characters typed. */
export function keyboard({ page }) {
  const count = { keys: 0, typed: 0 };
  const input = page.locator('.quick-input-widget input.input').first();
  const send = async (key) => {
    await page.keyboard.press(key);
    await page.evaluate(() => new Promise((next) => requestAnimationFrame(() => setTimeout(next, 0))));
  };
  const press = async (...keys) => {
    count.keys += keys.length;
    for (const key of keys) await send(key);
  };
  const type = async (text) => {
    count.typed += text.length;
    for (const key of text) await send(key === '\n' ? 'Enter' : key);
  };
  /**
   * Presses `key`, then `then`, until `row` shows; only the last try counts. A key pressed while the workbench is busy is lost,
   * and a list that opened early may stay without its rows.
   */
  const pressUntil = async (key, then, row) => {
    const before = { ...count };
    for (let attempt = 0; ; attempt++) {
      await press(key);
      try {
        await then();
        return await row.waitFor({ timeout: LOST_MS });
      } catch (error) {
        if (attempt === 4) throw error;
        Object.assign(count, before);
        await page.keyboard.press('Escape');
      }
    }
  };
  /** Runs a command of the palette. One opened early lacks the commands of extensions, and drops what is typed while it is filled. */
  const command = async (words, title) => {
    const typed = async () => {
      await input.waitFor({ timeout: LOST_MS });
      await type(words);
    };
    await pressUntil('F1', typed, page.locator('.quick-input-list .monaco-list-row.focused', { hasText: title }).first());
    await press('Enter');
  };
  /** Shows the code actions at the cursor, the first of them with `text`; Enter chooses it. Lenses that arrive meanwhile close the menu. */
  const actions = (text = '') => pressUntil('Control+.', async () => {}, page.locator('.action-widget .monaco-list-row.focused', { hasText: text }).first());
  return { count, input, press, pressUntil, type, command, actions };
}
