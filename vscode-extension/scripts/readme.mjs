// Writes dist/readme.md, the page of the extension: README.md without pictures. VS Code shows pictures there
// from http and https only, neither from the package nor from the text, and the project has no public address
// yet.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';

mkdirSync('dist', { recursive: true });
writeFileSync('dist/readme.md', readFileSync('README.md', 'utf8').replace(/\n *!\[[^\]]*\]\(docs\/[^)]*\)\n/g, ''));
