// Checks that the search of the book answers the questions of docs/questions.md: the page that answers a
// question is among the first three hits, with the index and the options of the book itself.
//
//     mdbook build docs && node tests/book-search.mjs
import { readFileSync, readdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import vm from 'node:vm';

const HITS = 3;
const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const book = join(root, 'target/book');

/** The only file of the book with this beginning and end: names contain a digest. */
function named(start, end) {
  const found = readdirSync(book).filter((name) => name.startsWith(start) && name.endsWith(end));
  if (found.length !== 1) {
    throw new Error(`${book} has ${found.length} files ${start}*${end}: run \`mdbook build docs\` in an empty folder`);
  }
  return join(book, found[0]);
}

/** The index of the book, with its options. */
function searchIndex() {
  const window = { search: {} };
  vm.runInNewContext(readFileSync(named('searchindex', '.js'), 'utf8'), { window, JSON, Object });
  return window.search;
}

/** The questions of the page, each with the address of its answer in the book. */
function questions() {
  const rows = readFileSync(join(root, 'docs/questions.md'), 'utf8').matchAll(/^\| (.+?) \| \[[^\]]+\]\((.+?)\)/gm);
  return [...rows].map(([, question, link]) => ({ question, answer: link.replace(/\.md(?=#|$)/, '.html') }));
}

const page = (url) => url.split('#')[0];
const elasticlunr = createRequire(import.meta.url)(named('elasticlunr', '.js'));
const { index, doc_urls: urls, search_options: options } = searchIndex();
const searched = elasticlunr.Index.load(index);
const asked = questions();
let failed = 0;
for (const { question, answer } of asked) {
  const hits = searched.search(question, options).map(({ ref }) => urls[ref]);
  const rank = hits.findIndex((url) => page(url) === page(answer));
  const isKnown = urls.some((url) => (answer.includes('#') ? url === answer : page(url) === answer));
  const isFound = rank >= 0 && rank < HITS;
  if (!isKnown || !isFound || process.argv.includes('--all')) {
    const place = rank < 0 ? 'not found' : `hit ${rank + 1}`;
    console.log(`${question}\n  ${answer}: ${isKnown ? place : 'no such heading'}`);
    hits.slice(0, HITS).forEach((url) => console.log(`    ${url}`));
  }
  failed += !isKnown || !isFound;
}
console.log(`${asked.length - failed} of ${asked.length} questions are answered by the first ${HITS} hits`);
process.exitCode = failed === 0 && asked.length >= 30 ? 0 : 1;
