// The verification panel: verdicts, the events of a run, what blocks what, and variations. It follows the text; a run
// that was chosen stays until it is dismissed. The trace viewer shows runs as pictures.
import * as vscode from 'vscode';
import { WorkDoneProgress } from 'vscode-languageclient/node';
import type { Server } from '../client';
import { ready } from '../commands/server';
import { SidePanel } from '../panel/panel';
import { offer, reveal } from '../panel/reveal';
import { LANGUAGE, SCENARIO, sensitivity, verification, type VerificationAnswer, type WhatIf } from '../protocol';
import type { TraceTarget } from '../trace/panel';
import type { FromPage, Limits, Subject, ToPage } from './messages';
import { page } from './page';
import { writeOut } from './writeOut';
import { done } from '../walkthrough';

const NO_LIMITS: Limits = { state: 'none', text: '' };

/** Argument of the command, as lenses and code actions give it. */
export interface VerificationTarget {
  uri: string;
  check?: number | null;
  /** The check is refuted, and its run is wanted. */
  run?: boolean;
}

export class VerificationPanel extends SidePanel<Subject, FromPage, ToPage> {
  private answer: VerificationAnswer | undefined;
  // The run on show, when somebody chose it: kept while the text changes.
  private pinned: VerificationAnswer['run'] = null;
  private pinnedRefutes = false;
  // Answers to older questions are dropped, and their work is ended.
  private asked: vscode.CancellationTokenSource | undefined;
  // The search for limits, and what the page shows of it.
  private searching: vscode.CancellationTokenSource | undefined;
  private limits: Limits = NO_LIMITS;
  private searches = 0;
  private readonly subscriptions: vscode.Disposable;

  constructor(
    private readonly server: Server,
    extension: vscode.Uri,
  ) {
    super({ type: 'dotgen.verification', title: 'Verification', find: true, page }, extension);
    this.subscriptions = vscode.Disposable.from(
      server.onDidVerify((status) => {
        // What is asked about a specification may be answered by its scenario.
        if (this.panel !== undefined && (status.uri === this.subject?.uri || status.uri === this.answer?.uri)) {
          if (['stale', 'running'].includes(status.status)) this.endSearch(NO_LIMITS);
          void this.ask();
        }
      }),
      server.onDidChange((state) => state.kind === 'ready' && this.panel !== undefined && void this.ask()),
    );
  }

  override dispose(): void {
    this.asked?.cancel();
    this.searching?.cancel();
    this.subscriptions.dispose();
    super.dispose();
  }

  /** Opens the panel on what a lens names, or on the active document. */
  async show(target?: VerificationTarget): Promise<void> {
    const editor = vscode.window.activeTextEditor;
    const here = editor !== undefined && [LANGUAGE, SCENARIO].includes(editor.document.languageId) ? editor.document.uri.toString() : undefined;
    const uri = typeof target?.uri === 'string' ? target.uri : here;
    if (uri === undefined) {
      void vscode.window.showInformationMessage('Open a specification (.gen) or a scenario (.scn) first.');
      return;
    }
    if ((await ready(this.server)) === undefined) return;
    this.subject = { uri, ...(typeof target?.check === 'number' ? { check: target.check } : {}) };
    this.pinned = null;
    this.endSearch(NO_LIMITS);
    await this.open();
    await this.ask();
  }

  protected update(): Promise<void> {
    return this.ask();
  }

  protected closed(): void {
    this.asked?.cancel();
    this.endSearch(NO_LIMITS);
    this.answer = undefined;
    this.pinned = null;
  }

  protected async receive(message: FromPage): Promise<void> {
    if (this.subject === undefined) {
      return;
    }
    switch (message.type) {
      case 'ready':
        this.send({ type: 'limits', limits: this.limits });
        return this.ask();
      case 'findLimits':
        return this.findLimits();
      case 'stopLimits':
        return this.endSearch({ state: 'none', text: 'Stopped.' });
      case 'place':
        return reveal(message.uri, {
          start: { line: message.line, character: message.character },
          end: { line: message.endLine, character: message.endCharacter },
        });
      case 'repair': {
        const { uri, line, character } = message;
        return offer('fixes', uri, { start: { line, character }, end: { line, character } });
      }
      case 'check':
        this.subject = { ...this.subject, check: message.check };
        this.pinned = null;
        await this.ask(true);
        return this.showTrace(message.check);
      case 'trace':
        return this.showTrace();
      case 'dismiss': {
        const { check: _, ...rest } = this.subject;
        this.subject = rest;
        this.pinned = null;
        return this.ask();
      }
      case 'whatIf': {
        const { whatIf: _, check: __, ...rest } = this.subject;
        this.subject = message.whatIf === undefined ? rest : { ...rest, whatIf: message.whatIf };
        this.pinned = null;
        this.endSearch(NO_LIMITS);
        return this.ask();
      }
      case 'writeOut':
        return writeOut(vscode.Uri.parse(this.answer?.uri ?? this.subject?.uri ?? ''));
    }
  }

  private async ask(pin = this.subject?.check !== undefined): Promise<void> {
    const { running: client } = this.server;
    const { subject } = this;
    if (client === undefined || subject === undefined || this.panel === undefined) {
      return;
    }
    this.asked?.cancel();
    const asked = new vscode.CancellationTokenSource();
    this.asked = asked;
    if (subject.whatIf !== undefined) {
      this.send({ type: 'busy', text: 'Verifying the variation …' });
    }
    let answer: VerificationAnswer | null;
    // While answers come in, the run on show stays if it refutes something.
    const shown = this.answer?.earlier === false && this.answer.status === 'running' && this.refutes(this.answer) ? this.answer.run?.check : undefined;
    try {
      const { uri, check = shown, whatIf } = subject;
      answer = await client.sendRequest(
        verification,
        { textDocument: { uri }, ...(check === undefined ? {} : { check }), ...(whatIf === undefined ? {} : { whatIf: strip(whatIf) }) },
        asked.token,
      );
    } catch {
      // Overtaken by an edit: the notification that follows asks again.
      return;
    }
    if (asked.token.isCancellationRequested || answer === null) {
      return;
    }
    this.answer = answer;
    if (answer.status !== 'running') done('verify');
    this.panel.title = `Verification: ${answer.scenario}`;
    // Somebody looks at this run: it does not disappear under their eyes.
    const { pinned } = this;
    const present = !answer.earlier;
    const { run } = answer;
    const replaces = present && run !== null && run.check === pinned?.check && (this.refutes(answer) || !this.pinnedRefutes);
    const keeps = pinned !== null && !replaces;
    // What was asked for may not be answered yet.
    const settled = present && answer.status !== 'running';
    if (!keeps && pin && (settled || (present && run?.check === subject.check))) {
      this.pinned = run;
      this.pinnedRefutes = this.refutes(answer);
    }
    this.send({ type: 'answer', subject, answer: keeps ? { ...answer, run: pinned } : answer, pinned: keeps });
  }

  /** Whether the run of an answer refutes its check. */
  private refutes({ run, checks }: VerificationAnswer): boolean {
    return run !== null && checks[run.check]?.verdict === 'refuted';
  }

  /** Opens the trace viewer with the run on show. */
  private async showTrace(check = (this.pinned ?? this.answer?.run)?.check): Promise<void> {
    if (this.subject === undefined) return;
    const { uri, whatIf } = this.subject;
    const target: TraceTarget = { uri, ...(check === undefined ? {} : { check }), ...(whatIf === undefined ? {} : { whatIf: strip(whatIf) }) };
    await vscode.commands.executeCommand('dotgen.showTrace', target);
  }

  private showLimits(limits: Limits): void {
    this.limits = limits;
    this.send({ type: 'limits', limits });
  }

  private endSearch(limits: Limits): void {
    this.searching?.cancel();
    this.searching = undefined;
    this.showLimits(limits);
  }

  private async findLimits(): Promise<void> {
    const { running: client } = this.server;
    const { subject } = this;
    if (client === undefined || subject === undefined) {
      return;
    }
    this.endSearch({ state: 'running', text: 'Looking …', percentage: 0 });
    const searching = new vscode.CancellationTokenSource();
    this.searching = searching;
    const workDoneToken = `dotgen/limits/${++this.searches}`;
    const progress = client.onProgress(WorkDoneProgress.type, workDoneToken, (it) => {
      if (this.searching === searching && it.kind === 'report') {
        this.showLimits({ state: 'running', text: `Looking for ${it.message ?? 'limits'} …`, percentage: it.percentage ?? 0 });
      }
    });
    const { uri, whatIf } = subject;
    let found: Limits;
    try {
      const answer = await client.sendRequest(
        sensitivity,
        { textDocument: { uri }, workDoneToken, ...(whatIf === undefined ? {} : { whatIf: strip(whatIf) }) },
        searching.token,
      );
      found = answer === null ? { state: 'none', text: 'There is nothing to verify here.' } : { state: 'found', answer };
    } catch {
      found = { state: 'none', text: 'The search ended without an answer.' };
    } finally {
      progress.dispose();
    }
    if (this.searching === searching) {
      this.endSearch(found);
    }
  }
}

/** Without what is as written. */
function strip(whatIf: WhatIf): WhatIf {
  return Object.fromEntries(Object.entries(whatIf).filter(([, value]) => value !== undefined));
}
