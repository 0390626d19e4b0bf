// The editing experience: completion, signature help, hover, navigation, rename, quick fix, refactoring, formatting.
// Its screenshots are those of docs/features.md.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = 'maneuver';
export const files = {
  'half.gen': `component half {
  ids { double speed; };
  task main {
    period 10 ms;
    codel<start> half_start(out speed) yield wait;
    codel<wait> half_wait(in speed) yield pause::wait;
  };
};
`,
};

// Hints stand between the words that are looked for.
export const settings = { 'editor.inlayHints.enabled': 'off' };

export function checks(wb) {
  const { page } = wb;
  const suggestions = page.locator('.suggest-widget.visible .monaco-list-row');
  const read = (name) => readFileSync(join(wb.folder, name), 'utf8');
  /** The editor alone: what surrounds it tells nothing. */
  const shot = (name) => wb.shot(`feature-${name}.png`, { x: 300, y: 30, width: 1100, height: 640 });
  /** Puts the cursor right behind `part` in the line that holds `text`. */
  async function behind(file, text, part) {
    await wb.endOf(file, text);
    const line = read(file)
      .split('\n')
      .find((it) => it.includes(text));
    for (let i = line.trimEnd().length - line.indexOf(part) - part.length; i > 0; i--) await page.keyboard.press('ArrowLeft');
  }

  const more = [
    ['completion knows the states of the machine', async () => {
      await wb.open('half.gen');
      await behind('half.gen', 'half_wait(in speed)', 'pause::wait');
      await wb.type(', ');
      await wb.press('Control+Space', suggestions.filter({ hasText: 'start' }).first());
      await suggestions.filter({ hasText: 'ether' }).first().waitFor();
      await shot('completion');
      await wb.type('eth');
      await suggestions.filter({ hasText: 'ether' }).first().waitFor();
      await page.keyboard.press('Enter');
      await wb.line('yield pause::wait, ether;').waitFor();
      await wb.save();
    }],
    ['completion of codel parameters offers what is not used', async () => {
      await behind('half.gen', 'half_wait(in speed)', 'in speed');
      await wb.type(', ');
      await wb.press('Control+Space', suggestions.first());
      await shot('completion-parameters');
      await page.keyboard.press('Escape');
      for (let i = 0; i < 2; i++) await page.keyboard.press('Backspace');
    }],
    ['signature help tells the parameters of a codel', async () => {
      await wb.open('maneuver.gen');
      await behind('maneuver.gen', 'mv_exec_wait(in state, in trajectory)', 'in trajectory');
      await wb.press('Control+Shift+Space', page.locator('.parameter-hints-widget.visible'));
      await shot('signature-help');
      await page.keyboard.press('Escape');
    }],
    ['hover shows prototypes, locks and the machine', async () => {
      await wb.endOf('maneuver.gen', 'mv_exec_main(in state');
      await wb.hover('mv_exec_main(in state', 'mv_exec_main');
      await shot('hover');
      await page.mouse.move(5, 5);
    }],
    ['references tell reads and writes', async () => {
      await behind('maneuver.gen', 'mv_plan_exec_stop(out trajectory)', 'out trajectory');
      await wb.press('Shift+F12', page.locator('.reference-zone-widget .monaco-list-row').first());
      await shot('references');
      await page.keyboard.press('Escape');
      await page.locator('.reference-zone-widget').waitFor({ state: 'detached' });
    }],
    ['a state is renamed wherever it is named', async () => {
      await behind('maneuver.gen', 'codel<wait> mv_exec_wait', 'codel<wait');
      const box = await wb.press('F2', page.locator('.rename-box input'));
      await box.fill('idle');
      await shot('rename');
      await box.press('Enter');
      await wb.line('codel<idle> mv_exec_wait').waitFor();
      await wb.save();
      const text = read('maneuver.gen');
      assert.match(text, /yield pause::idle, main wcet 1165 us/);
      assert.match(text, /yield idle, pause::main, start/);
      assert.equal(await wb.squiggles().count(), 0);
    }],
    ['an exception among the states is thrown by a quick fix', async () => {
      await behind('maneuver.gen', 'yield ether wcet 4 us;', 'ether');
      await wb.type(', e_nostate');
      await page.keyboard.press('Escape');
      await wb.squiggles().first().waitFor();
      await wb.action('instead of yielding it', () => shot('quick-fix'));
      await wb.line('throw ::maneuver::e_nostate;').waitFor();
      await wb.squiggles().first().waitFor({ state: 'detached' });
      await wb.save();
    }],
    ['an execution time changes its form', async () => {
      await behind('maneuver.gen', 'mv_exec_stop()', 'mv_exec_stop');
      await wb.action('#pragma wcet');
      await wb.line('#pragma wcet mv_exec_stop 4 us').waitFor();
      await shot('refactoring');
      await wb.save();
    }],
    ['the document is formatted', async () => {
      await wb.open('half.gen');
      await behind('half.gen', 'period 10 ms;', 'period');
      await wb.type('      ');
      await wb.command('Format Document');
      await until('the blanks are gone', async () => (await wb.line('period').innerText()).replace(/\u00a0/g, ' ').trimEnd() === '    period 10 ms;');
      await wb.save();
      assert.match(read('half.gen'), /\n {4}period 10 ms;\n/);
    }],
    ['the including specification of an interface is shown', async () => {
      await wb.open('pose_estimator.gen');
      await wb.command('dotgen: Select Including Specification');
      await page.locator('.quick-input-list .monaco-list-row', { hasText: 'maneuver.gen' }).waitFor();
      await shot('including-specification');
      await page.keyboard.press('Escape');
    }],
    ['the outline and the call hierarchy follow the machine', async () => {
      await wb.open('maneuver.gen');
      await behind('maneuver.gen', 'codel<exec> mv_plan_exec(', 'codel<exec> mv_plan_ex');
      await wb.command('Calls: Show Call Hierarchy');
      await page.locator('.monaco-list-row', { hasText: 'codel mv_goto_plan' }).first().waitFor();
      await page.mouse.move(5, 5);
      await wb.shot('feature-call-hierarchy.png');
    }],
  ];
  return { more };
}
