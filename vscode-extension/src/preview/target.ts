// What a picture is to show, and in which colours.
import * as vscode from 'vscode';

/** Argument of the commands, as code lenses give it. */
export interface Target {
  uri: string;
  component?: string;
  owner?: string;
  /** The place to open it; by default the one in the settings. */
  place?: 'beside';
}

/** Returns the argument of a command; undefined for a menu, which gives the file instead. */
export function named(target: Target | undefined): Target | undefined {
  return typeof target?.uri === 'string' ? target : undefined;
}

/** Returns true if the settings say that a lens opens its machine between the lines. */
export function opensInline(target: Target | undefined): boolean {
  return target !== undefined && target.place === undefined && vscode.workspace.getConfiguration('dotgen', vscode.Uri.parse(target.uri)).get('diagrams.open') === 'inline';
}

export function isDark(): boolean {
  const { Dark, HighContrast } = vscode.ColorThemeKind;
  const { kind } = vscode.window.activeColorTheme;
  return kind === Dark || kind === HighContrast;
}
