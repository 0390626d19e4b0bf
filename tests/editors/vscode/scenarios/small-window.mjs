// A window of 1000 x 700 with its side bar: the text stays legible next to each panel, and large pictures and runs are whole.
import assert from 'node:assert/strict';
import { until } from '../harness.mjs';

export const workspace = 'quadcopter';
export const beside = ['maneuver'];

/** A machine of 40 states: a chain with steps back and an early end. */
const states = Array.from({ length: 40 }, (_, i) => (i === 0 ? 'start' : i === 39 ? 'stop' : `step${i}`));
const codels = states.map((name, i) => {
  const next = i === 39 ? 'ether' : [states[i + 1], ...(i % 5 === 4 ? [`pause::${states[i - 3]}`] : []), ...(i % 7 === 6 ? ['stop'] : [])].join(', ');
  return `    codel<${name}> large_${name}(ids inout n) yield ${next} wcet ${(i % 9) + 1} us;`;
});
export const files = {
  'late.gen': 'component late {\n  version "1.0";\n  lang "c";\n  ids { long n; };\n\n  task fast { period 10 ms; codel<start> late_fast(ids inout n) yield pause::start wcet 6 ms; };\n  task slow { period 30 ms; codel<start> late_slow(ids inout n) yield pause::start wcet 13 ms; };\n};\n',
  'large.gen': `component large {\n  version "1.0";\n  lang "c";\n  ids { long n; };\n\n  task main {\n    period 10 ms;\n${codels.join('\n')}\n  };\n};\n`,
};

/** Least width of the text, in pixels: 50 columns. */
const LEAST_WIDTH = 420;
const LEAST_HEIGHT = 200;

export function checks(wb) {
  const { page } = wb;
  const text = page.locator('.editor-instance .monaco-editor').first();

  /** The text is wide and high enough to be read. */
  async function legible() {
    await until('the text is legible', async () => {
      const { width, height } = await text.boundingBox();
      return width >= LEAST_WIDTH && height >= LEAST_HEIGHT;
    }, async () => JSON.stringify(await text.boundingBox()));
  }

  const more = [
    ['a state machine of 40 states', async () => {
      await page.setViewportSize({ width: 1000, height: 700 });
      await wb.open('large.gen');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await wb.endOf('large.gen', 'codel<step12>');
      await wb.command('dotgen: Show State Machine');
      const frame = await wb.pageWith('g.node');
      await frame.locator('g.node[data-id="step12"]').waitFor();
      assert.ok((await frame.locator('g.node').count()) >= 40);
      await wb.accessible('g.node', 'small-1-machine');
      await legible();
      await frame.locator('#fit').click();
      await wb.shot('small-2-fit.png');
      await wb.command('View: Focus First Editor Group');
      await wb.command('View: Close Editors in Other Groups');
      assert.equal(await page.locator('.tab').count(), 1, 'the text alone is left');
    }],
    ['the verification', async () => {
      await wb.open('nhfc.gen');
      await wb.command('dotgen: Show Verification');
      await (await wb.pageWith('#checks')).locator('#checks tr').first().waitFor();
      await wb.shot('small-3-verification.png');
      await legible();
      await wb.command('View: Close Editors in Other Groups');
    }],
    ['a trace', async () => {
      await wb.open('late.gen');
      await page.locator('.contentWidgets .codelens-decoration a', { hasText: '✗ can be late' }).first().waitFor();
      await wb.command('dotgen: Step Through Run');
      await (await wb.pageWith('#sheet canvas')).locator('#position').waitFor();
      await wb.shot('small-4-trace.png');
      await legible();
      await wb.command('View: Toggle Panel Visibility');
    }],
    ['a run of a large system', async () => {
      await wb.open('flight.scn');
      await wb.command('dotgen: Simulate');
      const frame = await wb.pageWith('#tasks tbody tr');
      await frame.locator('#again').waitFor();
      assert.ok((await frame.locator('#components tbody tr').count()) >= 5);
      await wb.accessible('#tasks tbody tr', 'small-5-run');
      await legible();
      // No table is wider than the page.
      assert.ok(await frame.locator('body').evaluate((it) => it.scrollWidth <= it.clientWidth));
    }],
  ];
  return { more };
}
