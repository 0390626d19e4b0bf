import { readFileSync } from 'node:fs';
import { opener } from '/work/w/trace/tests/editors/vscode/webview/page.mjs';
const dir = readFileSync('/tmp/trace-dir','utf8').trim();
const pages = await opener('src/trace/page.ts', 'src/webview/trace.ts');
const trace = JSON.parse(readFileSync(dir + '/' + (process.argv[2] ?? 'miss') + '.trace.json', 'utf8'));
for (const theme of ['dark', 'light', 'contrast']) for (const width of [1400, 700]) {
  const it = await pages.open({ theme, width });
  await it.send({ type: 'trace', trace });
  for (let i = 0; i < 11; i++) await it.page.keyboard.press('ArrowLeft');
  await it.page.keyboard.press('ArrowLeft'); await it.frame();
  await it.page.screenshot({ path: `${dir}/${theme}-${width}.png` });
  if (it.errors.length) console.log(theme, it.errors);
  await it.page.close();
}
await pages.close();
