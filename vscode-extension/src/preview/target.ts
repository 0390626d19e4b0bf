// What a picture is to show, and in which colours.
import * as vscode from 'vscode';

/** Argument of the commands, as code lenses give it. */
export interface Target {
  uri: string;
  component?: string;
  owner?: string;
}

export function isDark(): boolean {
  const { Dark, HighContrast } = vscode.ColorThemeKind;
  const { kind } = vscode.window.activeColorTheme;
  return kind === Dark || kind === HighContrast;
}
