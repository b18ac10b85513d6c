// The chart as a picture in PNG: what is drawn, with the names of the curves, the window and the reference.

import { download } from '../../components/download.ts'
import { tokenColour } from '../../components/palette.ts'
import { t } from '../../texts/texts.ts'

export interface PictureText {
  /** The station and the window. */
  title: string
  curves: { name: string; colour: string; text: string }[]
  /** What else the picture says, a line each. */
  notes: string[]
}

const FONT = 'px system-ui, sans-serif'
const LINE_PX = 22
const MARGIN_PX = 16

/** A canvas with the title, the chart and the curves below each other. */
function composed(chart: HTMLCanvasElement, text: PictureText): HTMLCanvasElement {
  const dpr = devicePixelRatio
  const canvas = document.createElement('canvas')
  const lines = text.curves.length + text.notes.length
  const margin = MARGIN_PX * dpr
  canvas.width = chart.width + 2 * margin
  canvas.height = chart.height + (lines + 2) * LINE_PX * dpr + 2 * margin
  const context = canvas.getContext('2d')
  if (!context) throw new Error(t.trends.noPicture)
  context.fillStyle = tokenColour('panel')
  context.fillRect(0, 0, canvas.width, canvas.height)
  context.textBaseline = 'middle'
  context.fillStyle = tokenColour('text')
  context.font = `600 ${15 * dpr}${FONT}`
  context.fillText(text.title, margin, margin + (LINE_PX / 2) * dpr)
  context.drawImage(chart, margin, margin + LINE_PX * dpr)
  context.font = `${13 * dpr}${FONT}`
  let y = margin + LINE_PX * 2.5 * dpr + chart.height
  for (const { name, colour, text: value } of text.curves) {
    context.fillStyle = colour
    context.fillRect(margin, y - 2 * dpr, 18 * dpr, 4 * dpr)
    context.fillStyle = tokenColour('text')
    context.fillText(value ? `${name}: ${value}` : name, margin + 26 * dpr, y)
    y += LINE_PX * dpr
  }
  context.fillStyle = tokenColour('muted')
  for (const note of text.notes) {
    context.fillText(note, margin, y)
    y += LINE_PX * dpr
  }
  return canvas
}

/** Saves the chart within `box` as a file of this name. Does nothing before the chart is drawn. */
export async function savePng(box: HTMLElement | null, name: string, text: PictureText): Promise<void> {
  const chart = box?.querySelector('canvas')
  if (!chart) return
  const picture = composed(chart, text)
  const octets = await new Promise<Blob | null>((done) => picture.toBlob(done, 'image/png'))
  if (!octets) throw new Error(t.trends.noPng)
  download(octets, name)
}
