// Writes the server's settings into package.json, from the schema that the server's sources generate
// (docs/dotgen.schema.json). The extension's own settings, below server, trace and files, are left alone.
//
//   node scripts/settings.mjs            write them
//   node scripts/settings.mjs --check    fail if package.json has others
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const at = (path) => fileURLToPath(new URL(path, import.meta.url));
const schema = JSON.parse(readFileSync(at('../../docs/dotgen.schema.json'), 'utf8'));
const text = readFileSync(at('../package.json'), 'utf8');
const manifest = JSON.parse(text);

const OURS = /^dotgen\.(server|trace|files)\./;
const FIRST_ORDER = 10;
const camelCase = (name) => name.replace(/-(\w)/g, (_, letter) => letter.toUpperCase());
const unwrap = (description) => description?.replace(/([^\n])\n(?=[^\n])/g, '$1 ');

/** The schema with references replaced by what they name, and lines of prose joined. */
function resolve(value) {
  if (Array.isArray(value)) return value.map(resolve);
  if (value === null || typeof value !== 'object') return value;
  const { $ref, ...rest } = value;
  const whole = $ref === undefined ? rest : { ...schema.$defs[$ref.split('/').at(-1)], ...rest };
  const entries = Object.entries(whole).filter(([key]) => key !== 'format');
  return Object.fromEntries(entries.map(([key, it]) => [key, key === 'description' ? unwrap(it) : resolve(it)]));
}

const settings = Object.entries(schema.properties).map(([name, property], i) => {
  const { description, default: _, ...shape } = resolve(property);
  const none = shape.type === 'array' ? [] : shape.type === 'object' ? {} : null;
  return [`dotgen.${camelCase(name)}`, { ...shape, default: none, scope: 'resource', order: FIRST_ORDER + i, markdownDescription: description }];
});
const { configuration } = manifest.contributes;
const own = Object.entries(configuration.properties).filter(([name]) => OURS.test(name));
configuration.properties = Object.fromEntries([...own, ...settings]);

const fresh = JSON.stringify(manifest, null, 2) + '\n';
if (process.argv.includes('--check')) {
  if (fresh !== text) {
    console.error('the settings in package.json are out of date: run `npm run settings` and commit it');
    process.exit(1);
  }
} else {
  writeFileSync(at('../package.json'), fresh);
}
