// A page of the extension in Chromium, without VS Code: the very HTML, policy and bundle, with the colours of a theme and a
// host that keeps what the page says.
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { chromium } from 'playwright-core';

const extension = resolve(import.meta.dirname, '../../../../vscode-extension');
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const { build } = createRequire(join(extension, 'package.json'))('esbuild');

/** Some of what VS Code gives to pages, from its default themes. */
export const THEMES = {
  light: {
    kind: 'vscode-light',
    'editor-foreground': '#3b3b3b', foreground: '#3b3b3b', descriptionForeground: '#3b3b3b', 'editor-background': '#ffffff', 'panel-background': '#f8f8f8',
    'panel-border': '#e5e5e5', 'editorIndentGuide-background1': '#d3d3d3', focusBorder: '#005fb8', 'editorError-foreground': '#e51400',
    'charts-blue': '#0063d3', 'charts-orange': '#d18616', 'charts-yellow': '#895503', 'charts-purple': '#652d90', 'charts-green': '#388a34',
    'button-secondaryForeground': '#3b3b3b', 'button-secondaryBackground': '#e5e5e5', 'input-foreground': '#3b3b3b', 'input-background': '#ffffff',
    'editorHoverWidget-background': '#f8f8f8', 'editorHoverWidget-foreground': '#3b3b3b', 'editorHoverWidget-border': '#c8c8c8',
    'list-inactiveSelectionBackground': '#e4e6f1', 'textLink-foreground': '#005fb8', 'editorWarning-foreground': '#bf8803',
  },
  dark: {
    kind: 'vscode-dark',
    'editor-foreground': '#cccccc', foreground: '#cccccc', descriptionForeground: '#9d9d9d', 'editor-background': '#1f1f1f', 'panel-background': '#181818',
    'panel-border': '#2b2b2b', 'editorIndentGuide-background1': '#404040', focusBorder: '#0078d4', 'editorError-foreground': '#f14c4c',
    'charts-blue': '#59a4f9', 'charts-orange': '#d18616', 'charts-yellow': '#cca700', 'charts-purple': '#b180d7', 'charts-green': '#89d185',
    'button-secondaryForeground': '#cccccc', 'button-secondaryBackground': '#313131', 'input-foreground': '#cccccc', 'input-background': '#313131',
    'editorHoverWidget-background': '#202020', 'editorHoverWidget-foreground': '#cccccc', 'editorHoverWidget-border': '#454545',
    'list-inactiveSelectionBackground': '#37373d', 'textLink-foreground': '#4daafc', 'editorWarning-foreground': '#cca700',
  },
  contrast: {
    kind: 'vscode-high-contrast',
    'editor-foreground': '#ffffff', foreground: '#ffffff', descriptionForeground: '#ffffff', 'editor-background': '#000000', 'panel-background': '#000000',
    'panel-border': '#6fc3df', contrastBorder: '#6fc3df', focusBorder: '#f38518', 'editorError-foreground': '#f48771',
    'charts-blue': '#3794ff', 'charts-orange': '#d18616', 'charts-yellow': '#ffd700', 'charts-purple': '#b180d7', 'charts-green': '#89d185',
    'button-secondaryForeground': '#ffffff', 'button-secondaryBackground': '#000000', 'input-foreground': '#ffffff', 'input-background': '#000000',
    'editorHoverWidget-background': '#000000', 'editorHoverWidget-foreground': '#ffffff', 'editorHoverWidget-border': '#6fc3df',
    'list-inactiveSelectionBackground': '#000000', 'textLink-foreground': '#21a6ff', 'editorWarning-foreground': '#ffd370',
  },
};

/** What axe-core finds wrong with a page, a line each. */
export async function violations(page) {
  await page.evaluate(axe);
  const { violations: all } = await page.evaluate(() => window.axe.run(document));
  return all.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html.slice(0, 200)).join(' ')}`);
}

/** Bundles a page: `html` makes its text with a module of the extension, `script` and `style` are its bundle. */
async function bundled(module, script) {
  const folder = mkdtempSync(join(tmpdir(), 'dotgen-page-'));
  try {
    const [html, js] = [join(folder, 'page.mjs'), join(folder, 'script.js')];
    const vscode = { name: 'vscode', setup: (it) => {
      it.onResolve({ filter: /^vscode$/ }, () => ({ path: 'vscode', namespace: 'stub' }));
      it.onLoad({ filter: /.*/, namespace: 'stub' }, () => ({ contents: 'export const Uri = { joinPath: () => "/script" };' }));
    } };
    await build({ entryPoints: [join(extension, module)], bundle: true, platform: 'node', format: 'esm', outfile: html, plugins: [vscode] });
    await build({ entryPoints: [join(extension, script)], bundle: true, platform: 'browser', format: 'iife', target: 'es2022', minify: true, outfile: js });
    const { page } = await import(html);
    return { html: page({ asWebviewUri: (it) => it }, {}), script: readFileSync(js, 'utf8'), style: readFileSync(join(folder, 'script.css'), 'utf8') };
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

/** Opens pages of one kind; `close` ends the browser. */
export async function opener(module, script) {
  const parts = await bundled(module, script);
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox', '--disable-gpu'] });
  return {
    /** A page in a theme; `said` are the messages of the page. */
    async open({ theme = 'dark', width = 1400, height = 420 } = {}) {
      const page = await browser.newPage({ viewport: { width, height } });
      const errors = [];
      page.on('pageerror', (error) => errors.push(String(error)));
      page.on('console', (it) => it.type() === 'error' && errors.push(it.text()));
      await page.route('http://page.test/**', (route) => {
        const { pathname } = new URL(route.request().url());
        if (pathname === '/') return route.fulfill({ contentType: 'text/html', body: parts.html });
        if (pathname === '/script.js') return route.fulfill({ contentType: 'text/javascript', body: parts.script });
        if (pathname === '/script.css') return route.fulfill({ contentType: 'text/css', body: parts.style });
        return route.fulfill({ status: 204, body: '' });
      });
      await page.addInitScript(({ kind, ...colours }) => {
        window.said = [];
        // As in VS Code, the state outlives the page.
        window.acquireVsCodeApi = () => ({
          postMessage: (it) => window.said.push(it),
          setState: (it) => sessionStorage.setItem('state', JSON.stringify(it)),
          getState: () => JSON.parse(sessionStorage.getItem('state') ?? 'null') ?? undefined,
        });
        document.addEventListener('DOMContentLoaded', () => {
          document.body.classList.add(kind);
          const { style } = document.documentElement;
          for (const [name, value] of Object.entries(colours)) style.setProperty(`--vscode-${name}`, value);
          style.setProperty('--vscode-font-family', 'Ubuntu, "DejaVu Sans", sans-serif');
          style.setProperty('--vscode-font-size', '13px');
          style.setProperty('--vscode-editor-font-family', '"DejaVu Sans Mono", monospace');
        });
      }, THEMES[theme]);
      await page.goto('http://page.test/');
      const frame = () => page.evaluate(() => new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next))));
      await frame();
      return {
        page,
        errors,
        frame,
        send: async (message) => {
          await page.evaluate((it) => window.postMessage(it, '*'), message);
          await frame();
        },
        said: () => page.evaluate(() => window.said),
      };
    },
    close: () => browser.close(),
  };
}
