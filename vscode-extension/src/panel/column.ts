// The place of a panel: next to the text, or below the text where the window is narrow.
import * as vscode from 'vscode';

/** Width of the editors, in pixels, from which a text and a panel fit next to each other. */
const LEAST_WIDTH = 800;
const SIDE_BY_SIDE = 0;
const STACKED = 1;

interface Layout {
  orientation?: number;
  groups: { size?: number; groups?: unknown }[];
}

const layout = () => vscode.commands.executeCommand<Layout>('vscode.getEditorLayout');
const setLayout = (wanted: Layout) => vscode.commands.executeCommand('vscode.setEditorLayout', wanted);

/** Returns the column of a new panel. In a narrow window with one group of editors, a group is made below. */
export async function columnOfPanel(): Promise<vscode.ViewColumn> {
  let { orientation, groups } = await layout();
  if (groups.length === 1 && groups[0]?.groups === undefined) {
    if (orientation === STACKED) {
      // The size of a single group is its width in this direction only.
      await setLayout({ orientation: SIDE_BY_SIDE, groups: [{}] });
      ({ groups } = await layout());
    }
    const width = groups[0]?.size;
    if (width === undefined || width >= LEAST_WIDTH) return vscode.ViewColumn.Beside;
    await setLayout({ orientation: STACKED, groups: [{ size: 0.45 }, { size: 0.55 }] });
    return vscode.ViewColumn.Two;
  }
  // Another panel is below: *beside* would divide the part of the text.
  const { all, activeTabGroup } = vscode.window.tabGroups;
  const other = all.length === 2 && orientation === STACKED ? all.find((it) => it !== activeTabGroup) : undefined;
  return other?.viewColumn ?? vscode.ViewColumn.Beside;
}
