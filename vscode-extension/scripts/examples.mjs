// Copies the small examples to dist/examples, which is part of the package, and describes them in
// dist/examples/list.json. The command Open Example… offers these. Not included: quadcopter (3.5 MB).
import { cpSync, lstatSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

/** In the order in which they are offered. */
const EXAMPLES = ['pump', 'drift', 'motor', 'maneuver', 'outdoor'];
/** Bytes of all examples. */
const MOST = 200_000;

const from = fileURLToPath(new URL('../../examples/', import.meta.url));
const to = fileURLToPath(new URL('../dist/examples/', import.meta.url));

/** Builds and editors leave files whose names begin with a dot. */
const isSource = (path) => !path.slice(from.length).split(/[\\/]/).some((name) => name.startsWith('.'));
const bytes = (path) =>
  lstatSync(path).isDirectory() ? readdirSync(path).reduce((sum, name) => sum + bytes(join(path, name)), 0) : lstatSync(path).size;

rmSync(to, { recursive: true, force: true });
for (const name of EXAMPLES) cpSync(join(from, name), join(to, name), { recursive: true, filter: isSource });
const list = EXAMPLES.map((name) => {
  const [title] = readFileSync(join(from, name, 'README.md'), 'utf8').split('\n');
  return { name, description: title.replace(/^# \w+: /, '') };
});
writeFileSync(join(to, 'list.json'), `${JSON.stringify(list, null, 2)}\n`);
const size = bytes(to);
if (size > MOST) {
  console.error(`The examples have ${size} bytes, and ${MOST} are allowed: shorten the list in scripts/examples.mjs.`);
  process.exit(1);
}
