// Real VS Code workbenches: one code-server with a throw-away profile and the packaged extension, one headless Chromium, and
// a window on a copy of a workspace for each scenario.
import { execFile, spawn } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, readlinkSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { basename, dirname, join, resolve, sep } from 'node:path';
import { promisify } from 'node:util';
import { chromium } from 'playwright-core';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
/** Themes, and the class of the workbench in each; the first is that of the scenarios. */
const THEMES = [['Default Dark Modern', 'vs-dark'], ['Default Light Modern', 'vs'], ['Default High Contrast', 'hc-black']];

/** Only a failure takes so long. */
const TIMEOUT_MS = Number(process.env.WORKBENCH_TIMEOUT_MS ?? 90_000);
/** After this a key or a click counts as lost, and is repeated: longer than a loaded machine takes, since a second click may take back what the first did. */
export const LOST_MS = TIMEOUT_MS / 6;

const SETTINGS = {
  'workbench.startupEditor': 'none',
  'workbench.tips.enabled': false,
  'workbench.secondarySideBar.defaultVisibility': 'hidden',
  'security.workspace.trust.enabled': false,
  'telemetry.telemetryLevel': 'off',
  'extensions.autoUpdate': false,
  'extensions.autoCheckUpdates': false,
  'update.mode': 'none',
  'files.autoSave': 'off',
  'editor.minimap.enabled': false,
  'git.enabled': false,
  'workbench.colorTheme': 'Default Dark Modern',
};

function freePort() {
  return new Promise((ok, fail) => {
    const server = createServer().listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close((error) => (error ? fail(error) : ok(port)));
    });
  });
}

/** A folder below `root`, which is made. */
function below(root, name) {
  const path = join(root, name);
  mkdirSync(path, { recursive: true });
  return path;
}

/** A headless browser, for the windows of all scenarios. */
export const startBrowser = () =>
  chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    headless: true,
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
  });

/**
 * Starts a server of workbenches with a throw-away profile and the packaged extension. `node` and `codeServer` are what
 * setup.sh wrote to its `env` file. `others` are extensions that stand in for those of others: `main` (text) and the rest of
 * the manifest by identifier.
 */
export async function startServer({ node, codeServer, vsix, others = {} }) {
  // A language server that starts removes folders `dotgen-*` without a lock.
  const root = mkdtempSync(join(tmpdir(), 'workbench-'));
  const user = below(root, 'user');
  const extensions = below(root, 'extensions');
  writeFileSync(join(below(root, 'user/User'), 'settings.json'), JSON.stringify(SETTINGS, null, 2));
  writeFileSync(join(root, 'config.yaml'), 'auth: none\n');
  const env = {
    ...process.env,
    HOME: below(root, 'home'),
    XDG_CONFIG_HOME: below(root, 'config'),
    XDG_DATA_HOME: below(root, 'data'),
    XDG_CACHE_HOME: below(root, 'cache'),
  };
  // The test itself may run inside an editor.
  for (const name of Object.keys(env).filter((name) => name.startsWith('VSCODE_'))) delete env[name];

  const base = [codeServer, '--config', join(root, 'config.yaml'), '--user-data-dir', user, '--extensions-dir', extensions];
  // What lies there before the first installation is taken for installed.
  for (const [id, { main, ...manifest }] of Object.entries(others)) {
    const [publisher, name] = id.split('.');
    const place = below(root, `extensions/${id}-1.0.0`);
    const whole = { name, publisher, version: '1.0.0', engines: { vscode: '^1.60.0' }, main: './main.js', activationEvents: ['onStartupFinished'], ...manifest };
    writeFileSync(join(place, 'package.json'), JSON.stringify(whole));
    writeFileSync(join(place, 'main.js'), main);
  }
  await promisify(execFile)(node, [...base, '--install-extension', resolve(vsix)], { env });
  const port = await freePort();
  // The processes of a window that is closed end at once.
  const options = ['--auth', 'none', '--disable-telemetry', '--disable-update-check', '--disable-workspace-trust', '--disable-getting-started-override', '--reconnection-grace-time', '1'];
  const server = spawn(node, [...base, '--bind-addr', `127.0.0.1:${port}`, ...options], { env, stdio: ['ignore', 'pipe', 'pipe'] });
  process.once('exit', () => server.kill('SIGKILL')); // never leave a server behind a failed start
  let log = '';
  server.stdout.on('data', (data) => (log += data));
  server.stderr.on('data', (data) => (log += data));
  const origin = `http://127.0.0.1:${port}`;
  await until('the workbench server answers', async () => (await fetch(`${origin}/healthz`)).ok, () => log);
  return {
    user,
    extensions,
    origin,
    log: () => log,
    async close() {
      const ended = new Promise((done) => server.once('exit', done));
      server.kill('SIGTERM');
      await Promise.race([ended, new Promise((done) => setTimeout(done, 5000))]);
      if (server.exitCode === null && server.signalCode === null) server.kill('SIGKILL');
      rmSync(root, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
    },
  };
}

/**
 * Opens a window on a copy of a workspace. `files` (text by name) are added to the copy; the folders `beside` are copied next to
 * it, under their names; with `isEmpty` the window has no folder; `settings` are those of the folder.
 */
export async function openWindow({ browser, server, workspace, isEmpty = false, beside = [], files = {}, settings = {}, shots }) {
  const { user, extensions, origin } = server;
  const root = mkdtempSync(join(tmpdir(), 'workspace-'));
  const folder = below(root, 'workspace');
  if (workspace) cpSync(workspace, folder, { recursive: true });
  for (const path of beside) cpSync(path, join(root, basename(path)), { recursive: true });
  for (const [name, text] of Object.entries(files)) {
    mkdirSync(dirname(join(folder, name)), { recursive: true });
    writeFileSync(join(folder, name), text);
  }
  const folderSettings = (values) => writeFileSync(join(below(folder, '.vscode'), 'settings.json'), JSON.stringify({ ...settings, ...values }, null, 2));
  folderSettings({});

  const context = await browser.newContext({ viewport: { width: 1400, height: 900 } });
  context.setDefaultTimeout(TIMEOUT_MS);
  const page = await context.newPage();
  const consoleLines = [];
  page.on('console', (message) => consoleLines.push(`[${message.type()}] ${message.text()}`));
  page.on('pageerror', (error) => consoleLines.push(`[pageerror] ${error}`));
  await page.goto(isEmpty ? `${origin}/?ew=true` : `${origin}/?folder=${encodeURIComponent(folder)}`);
  await page.locator('.monaco-workbench').waitFor();
  if (!isEmpty) await page.locator('.explorer-folders-view .monaco-list-row').first().waitFor();

  const wb = {
    page,
    folder,
    folderSettings,
    shot: (name, clip) => page.screenshot({ path: join(shots, name), clip, animations: 'disabled' }),

    /** A line of the active editor. */
    line: (text) => page.locator('.monaco-editor .view-lines .view-line', { hasText: text }).first(),
    squiggles: (severity = 'error') => page.locator(`.monaco-editor .squiggly-${severity}`),
    /** The page of a webview that holds `selector`, among those of all panels. */
    async pageWith(selector) {
      let found;
      await until(`a page with ${selector} is there`, async () => {
        for (const frame of page.frames()) {
          if ((await frame.locator(selector).count().catch(() => 0)) > 0) found = frame;
        }
        return found !== undefined;
      }, () => page.frames().map((it) => it.url()).join('\n'));
      return found;
    },
    /** Runs axe-core on the page of a webview in three themes; throws if it reports a violation. Screenshots begin with `shot`. */
    async accessible(selector, shot) {
      const found = [];
      for (const [theme, shown] of [...THEMES.slice(1), THEMES[0]]) {
        folderSettings({ 'workbench.colorTheme': theme });
        await page.locator(`.monaco-workbench.${shown}`).waitFor();
        const frame = await wb.pageWith(selector);
        await frame.locator(`body.${{ vs: 'vscode-light', 'vs-dark': 'vscode-dark', 'hc-black': 'vscode-high-contrast' }[shown]}`).waitFor();
        await frame.evaluate(axe);
        const violations = await frame.evaluate(async () => (await window.axe.run(document)).violations);
        found.push(...violations.map(({ id, nodes }) => `${theme}: ${id}: ${nodes.map((it) => it.html).join(' ')}`));
        await wb.shot(`${shot}-${shown}.png`);
      }
      folderSettings({});
      if (found.length > 0) throw new Error(found.join('\n'));
    },
    statusItem: page.locator('#dotgen\\.dotgen\\.dotgen\\.status, [id$="dotgen.status"]').first(),

    /** Presses a key until `shown` shows: one pressed while the workbench is busy is lost. */
    async press(key, shown) {
      for (let attempt = 0; ; attempt++) {
        await page.keyboard.press(key);
        try {
          await shown.waitFor({ timeout: LOST_MS });
          return shown;
        } catch (error) {
          if (attempt === 5) throw error;
        }
      }
    },
    /** Clicks a lens until `shown` shows, or has the state: one that is being replaced by the same in the new place does nothing. */
    async click(lens, shown, state = 'visible') {
      for (let attempt = 0; ; attempt++) {
        try {
          await lens.click({ timeout: LOST_MS });
          await shown.waitFor({ state, timeout: LOST_MS });
          return;
        } catch (error) {
          if (attempt === 4) throw error;
        }
      }
    },
    /** Opens the quick input with a key. */
    quick: (key) => wb.press(key, page.locator('.quick-input-widget input.input').first()),
    /**
     * Opens the quick input with a key, writes `text` and calls `choose` with the input: all of it again if that fails. The
     * input closes when something that was opened before takes the focus, and drops what is typed while it is being filled.
     */
    async choosing(key, text, choose) {
      for (let attempt = 0; ; attempt++) {
        try {
          const input = await wb.quick(key);
          await input.fill(text, { timeout: LOST_MS });
          return await choose(input);
        } catch (error) {
          if (attempt === 4) throw error;
          await page.keyboard.press('Escape');
        }
      }
    },
    /** Runs a command of the palette. */
    command(title) {
      const row = page.locator('.quick-input-list .monaco-list-row', { hasText: title }).first();
      return wb.choosing('F1', '>' + title, () => row.click({ timeout: LOST_MS }));
    },
    /**
     * Chooses a file of the workspace in the dialog that asks for one (`files.simpleDialog.enable`). The dialog shows its
     * input before it writes the folder it starts in there, over what was typed meanwhile.
     */
    async choose(path) {
      const input = page.locator('.quick-input-widget input.input').first();
      await until('the dialog is in the folder', async () => (await input.inputValue()) === folder + sep, () => `expected ${folder + sep}`);
      await input.fill(path);
      await page.locator('.quick-input-list .monaco-list-row.focused', { hasText: basename(path) }).first().waitFor();
      await page.keyboard.press('Enter');
      await input.waitFor({ state: 'hidden' });
    },
    async open(name) {
      // The list is filled twice (recent files, then the search): accept once the first row is the one wanted.
      const row = page.locator('.quick-input-list .monaco-list-row.focused', { hasText: name }).first();
      await wb.choosing('Control+P', name, async (input) => {
        await row.waitFor({ timeout: LOST_MS });
        await input.press('Enter', { timeout: LOST_MS });
        await page.locator(`.tab.active[data-resource-name="${name}"]`).first().waitFor({ timeout: LOST_MS });
      });
      await page.locator('.monaco-editor .view-line').first().waitFor();
    },
    /** Puts the cursor at the end of the first line of `name` (the active file) that holds `text` on disk. */
    async endOf(name, text) {
      const lines = readFileSync(join(folder, name), 'utf8').split('\n');
      const number = lines.findIndex((line) => line.includes(text)) + 1;
      if (number === 0) throw new Error(`no line with "${text}" in ${name}`);
      await wb.choosing('Control+G', `:${number}`, async (input) => {
        await input.press('Enter', { timeout: LOST_MS });
        await input.waitFor({ state: 'hidden', timeout: LOST_MS });
        await page.locator('.monaco-editor .line-numbers.active-line-number', { hasText: new RegExp(`^${number}$`) }).waitFor({ timeout: LOST_MS });
      });
      await page.keyboard.press('End');
    },
    /** Shows the hover of `word` in the line that holds `text`. A move while the editor still scrolls is lost: repeat. */
    async hover(text, word) {
      const hover = page.locator('.monaco-hover:not(.hidden)', { hasText: word }).first();
      for (let attempt = 0; ; attempt++) {
        // A line that is being drawn anew (lenses, hints) has no box for a moment.
        let box = null;
        while (!box) box = await wb.line(text).locator('span span', { hasText: word }).last().boundingBox();
        await page.mouse.move(5, 5);
        await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2, { steps: 3 });
        try {
          await hover.waitFor({ timeout: LOST_MS / 2 });
          return hover;
        } catch (error) {
          if (attempt === 5) throw error;
        }
      }
    },
    /** Types as a person does, one key at a time: keys that arrive together count as a paste, without closing brackets. */
    async type(text) {
      for (const key of text) {
        await page.keyboard.press(key === '\n' ? 'Enter' : key);
        await page.evaluate(() => new Promise((next) => requestAnimationFrame(() => setTimeout(next, 0))));
      }
    },
    /**
     * Chooses a code action at the cursor until `shown` shows; `seen` runs while the menu shows. Lenses that arrive meanwhile
     * move the text, and VS Code closes the menu, also under the click.
     */
    async action(text, seen = async () => {}, shown = undefined) {
      const row = page.locator('.action-widget .monaco-list-row', { hasText: text }).first();
      for (let attempt = 0; ; attempt++) {
        await page.keyboard.press('Control+.');
        try {
          await row.waitFor({ timeout: LOST_MS / 2 });
          await seen();
          await row.click({ timeout: LOST_MS / 2 });
          await shown?.waitFor({ timeout: LOST_MS });
          return;
        } catch (error) {
          if (attempt === 5) throw error;
          await page.keyboard.press('Escape');
        }
      }
    },
    async save() {
      await page.keyboard.press('Control+S');
      await page.locator('.tab.active.dirty').waitFor({ state: 'detached' });
    },
    /** Process ids of the language servers of this window. */
    languageServers() {
      return readdirSync('/proc')
        .filter((name) => /^\d+$/.test(name))
        .filter((pid) => {
          try {
            // Its helpers are the same program, started by it with other arguments.
            const words = readFileSync(`/proc/${pid}/cmdline`, 'utf8').split('\0');
            return readlinkSync(`/proc/${pid}/exe`).startsWith(extensions + sep) && words[1] === 'lsp' && readlinkSync(`/proc/${pid}/cwd`) === folder;
          } catch {
            return false; // ended meanwhile, or not ours to look at
          }
        })
        .map(Number);
    },
    /** What to print when a test fails. */
    logs() {
      const files = readdirSync(join(user, 'logs'), { recursive: true })
        .map(String)
        .filter((name) => name.includes('exthost') && (name.endsWith('remoteexthost.log') || /dotgen/.test(name)) && name.endsWith('.log'));
      // The list of the built-in extensions alone fills a screen; what the closed network refuses tells nothing.
      const telling = (line) => !/api\.github\.com|open-vsx|gallery|ERR_NAME_NOT_RESOLVED|_doActivateExtension vscode\./i.test(line);
      const last = (lines) => lines.filter(telling).slice(-20).map((line) => line.slice(0, 400));
      const texts = files.flatMap((name) => [`--- ${name}`, ...last(readFileSync(join(user, 'logs', name), 'utf8').split('\n'))]);
      return [...texts, '--- browser console', ...last(consoleLines), '--- workbench server', ...last(server.log().split('\n'))].join('\n');
    },
    async close() {
      // A page that leaves says good-bye to its processes; one that is closed does not.
      await page.goto('about:blank');
      await context.close();
      rmSync(root, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
    },
  };
  return wb;
}

/** Waits until `condition` holds; `details` is added to the failure. */
export async function until(what, condition, details = () => '') {
  const end = Date.now() + TIMEOUT_MS;
  let last;
  while (Date.now() < end) {
    try {
      if (await condition()) return;
    } catch (error) {
      last = error;
    }
    await new Promise((next) => setTimeout(next, 100));
  }
  throw new Error(`timed out waiting until ${what}\n${last ?? ''}\n${details()}`);
}
