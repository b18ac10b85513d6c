// Colours of the styles for a canvas.

/** The present value of a colour in styles/tokens.css, for a canvas. */
export function tokenColour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()
}
