// The size of a small picture of a state machine.
import type { DiagramAnswer } from '../protocol';

/** A hover of VS Code is 250 pixels high, and half of a small window is left for the text around a comment. */
const WIDEST = 400;
const HIGHEST = 220;
/** Names of states have 7 pixels. */
const READABLE = 0.55;

/** Scales a picture to the space. If the names would be too small, returns the part around the marked state, else the start. */
export function fitted({ picture, width, height, nodes }: Pick<DiagramAnswer, 'picture' | 'width' | 'height' | 'nodes'>, state: string | undefined): { picture: string; width: number; height: number } {
  const scale = Math.min(1, WIDEST / width, HIGHEST / height);
  const id = nodes.find((it) => it.names.includes(state ?? 'start'))?.id;
  // The id of a codel of several states is `a+b`.
  const literal = id?.replace(/\W/g, '\\$&');
  const box = scale >= READABLE || literal === undefined ? null : new RegExp(`data-id="${literal}"[^]*?<rect class="shape" x="([\\d.]+)" y="([\\d.]+)" width="([\\d.]+)" height="([\\d.]+)"`).exec(picture);
  if (box === null) return { picture, width: Math.round(width * scale), height: Math.round(height * scale) };
  const [x = 0, y = 0, w = 0, h = 0] = box.slice(1).map(Number);
  const part = (size: number, most: number, middle: number) => {
    const length = Math.min(size, most / READABLE);
    return { from: Math.round(Math.max(0, Math.min(middle - length / 2, size - length))), length: Math.round(length) };
  };
  const [across, down] = [part(width, WIDEST, x + w / 2), part(height, HIGHEST, y + h / 2)];
  const pixels = { width: Math.round(across.length * READABLE), height: Math.round(down.length * READABLE) };
  const view = `width="${pixels.width}" height="${pixels.height}" viewBox="${across.from} ${down.from} ${across.length} ${down.length}"`;
  return { picture: picture.replace(/width="[\d.]+" height="[\d.]+" viewBox="[^"]*"/, view), ...pixels };
}
