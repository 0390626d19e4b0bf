// The sizes at which a picture is shown: pure, for the canvas and for tests.

export interface Size {
  width: number;
  height: number;
}

/** Height of the letters of a picture at its natural size, in pixels. */
const LETTER = 11;
/** The scale from which the letters of a fitted picture are legible: 7 pixels. */
export const LEGIBLE = 7 / LETTER;
/** The scale from which letters are comfortable to read: 9 pixels. */
export const COMFORTABLE = 9 / LETTER;
/** The greatest scale of a fitted picture. */
export const GREATEST = 1.5;

/** The scale at which all of a picture is in the view: small pictures grow, large ones shrink. */
export function fitting(picture: Size, view: Size): number {
  const scale = Math.min(GREATEST, view.width / picture.width, view.height / picture.height);
  return Number.isFinite(scale) && scale > 0 ? scale : 1;
}

/** Returns the scale at which a picture opens: fitted if that is legible, or else its natural size. */
export function opening(picture: Size, view: Size): { scale: number; whole: boolean } {
  const scale = fitting(picture, view);
  return scale >= LEGIBLE ? { scale, whole: true } : { scale: 1, whole: false };
}
