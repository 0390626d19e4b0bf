// The Testing view: checks of scenarios are tests, of which only a proved one is green.

export const workspace = 'pump';
export const files = {
  'late.scn': 'scenario late {\n  use "pump.gen";\n  cores 1;\n  policy fifo;\n  check quick: response pump.control <= 5 ms;\n  check response pump.report <= 20 ms;\n  check never: always not (pump.control.main and pump.fill.wait);\n}\n',
  'wrong.scn': 'scenario wrong {\n  use "nowhere.gen";\n  check it: deadlock;\n}\n',
};

export function checks(wb) {
  const { page } = wb;
  const lens = (what) => page.locator('.contentWidgets .codelens-decoration a', { hasText: what }).first();
  const row = (text) => page.locator('.test-explorer .monaco-list-row', { hasText: text }).first();
  const result = (text, icon) => row(text).locator(`.codicon-testing-${icon}-icon`).waitFor();

  const more = [
    ['scenarios are listed as files of tests', async () => {
      await wb.open('pump.scn');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await lens('8 ms · proved').waitFor();
      await wb.command('Testing: Focus on Test Explorer View');
      for (const name of ['late.scn', 'pump.scn', 'wrong.scn']) await row(name).waitFor();
    }],
    ['all tests are run: proved is green, refuted is red, and what was not verified is neither', async () => {
      await wb.command('Test: Run All Tests');
      // VS Code shows errors before failures.
      await result('late.scn', 'error');
      await result('pump.scn', 'passed');
      await result('wrong.scn', 'error');
      await page.locator('.test-explorer .monaco-list-row', { hasText: 'pump.scn' }).first().click();
      await page.keyboard.press('ArrowUp');
      await page.keyboard.press('ArrowRight');
      await result('quick', 'failed');
      await result('response pump.report <= 20 ms', 'passed');
      await result('never', 'error');
      await wb.open('late.scn');
      await lens('7 ms · refuted').waitFor();
      await wb.shot('testing-1-results.png');
    }],
    ['a failed check has its cause at its place', async () => {
      await wb.command('Test: Peek Output');
      await page.locator('.test-output-peek', { hasText: 'cause: `control`' }).first().waitFor();
      await wb.shot('testing-2-cause.png');
      await page.keyboard.press('Escape');
    }],
    ['a continuous run follows what is saved', async () => {
      await page.locator('.part.sidebar .title-actions [aria-label*="Continuous Run"]').first().click();
      await wb.endOf('late.scn', 'check quick');
      for (let i = 0; i < '5 ms;'.length; i++) await page.keyboard.press('Backspace');
      await wb.type('9 ms;');
      await wb.save();
      await result('quick', 'passed');
      await wb.shot('testing-3-continuous.png');
    }],
  ];
  return { more };
}
