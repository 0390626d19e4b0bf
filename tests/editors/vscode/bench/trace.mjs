// Frames a second while a long run is moved through: `node bench/trace.mjs [STEPS]`.
import { opener } from '../webview/page.mjs';
import { trace } from '../webview/traces.mjs';

const steps = Number(process.argv[2] ?? 10_000);
const pages = await opener('src/trace/page.ts', 'src/webview/trace.ts');
const it = await pages.open();
await it.send({ type: 'trace', trace: trace(steps) });
await it.page.locator('#trace').focus();
for (const [name, keys] of [['all of it in sight', ['0']], ['a tenth of it', ['0', '+', '+', '+', '+', '+']], ['as it opens', ['f']]]) {
  for (const key of keys) await it.page.keyboard.press(key);
  await it.frame();
  const times = await it.page.evaluate(() => new Promise((done) => {
    const [canvas, all] = [document.getElementById('canvas'), []];
    const next = (now) => {
      all.push(now);
      if (all.length > 180) return done(all);
      canvas.dispatchEvent(new WheelEvent('wheel', { deltaX: all.length < 90 ? -25 : 25, bubbles: true, cancelable: true }));
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  }));
  const apart = times.slice(1).map((at, i) => at - times[i]).sort((a, b) => a - b);
  const mean = (times.at(-1) - times[0]) / apart.length;
  console.log(`${steps} steps, ${name}: ${(1000 / mean).toFixed(1)} frames a second, 99th percentile ${apart[Math.floor(apart.length * 0.99)].toFixed(1)} ms`);
}
await pages.close();
