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
   * Runs a command of the palette. One opened early lacks the commands of extensions, and drops what is typed while it is
   * filled: then it is opened again, and only the last try counts.
   */
  const command = async (words, title) => {
    const before = { ...count };
    const row = page.locator('.quick-input-list .monaco-list-row.focused', { hasText: title }).first();
    for (let attempt = 0; ; attempt++) {
      await press('F1');
      await input.waitFor();
      await type(words);
      try {
        await row.waitFor({ timeout: LOST_MS });
        return await press('Enter');
      } catch (error) {
        if (attempt === 4) throw error;
        Object.assign(count, before);
        await page.keyboard.press('Escape');
      }
    }
  };
  return { count, input, press, type, command };
}
